//! A test, and the demonstration.

use super::coupled_check;
use super::figures::Figures;
use super::improvement;
use super::section::{TestSection, lead};
use super::summaries::summaries;
use crate::document::Document;
use crate::improve::Improvement;
use experiment::Experiment;
use experiment::numbers::{joule, length, percent};
use experiment::summary::Summary;
use experiment::trace::{Response, Trace};
use outerloop_core::Method;

/// Describes the files next to the page.
const RECORDS: &str = "Every channel of every control step is in record.csv, and in record.h5 for Python and MATLAB, which repeats \
                       the test, too. The figures are in summary.json. They lie beside this page.";

/// One test. `remarks`: notes on its rig; `trace`: with the ideal, if it was kept.
pub fn of_run(
    experiment: &Experiment,
    summary: &Summary,
    remarks: &[String],
    trace: Option<(&Trace, &Response)>,
) -> Document {
    let title = format!("Pseudodynamic test under {}", summary.record);
    let mut d = Document::new(title, lead(experiment, summary), trace.is_some());
    d.tell(experiment.in_words());
    remarks.iter().for_each(|remark| d.tell(remark));
    d.on_terminal(|d| summaries(d, std::slice::from_ref(summary)));
    d.on_page(|d| {
        verdict(d, summary);
        d.items(remarks.to_vec());
    });
    if let Some((trace, ideal)) = trace {
        tiles(&mut d, summary);
        let section = TestSection {
            experiment,
            summary,
            trace,
            ideal,
        };
        let f = Figures::of(&section);
        f.displacement(&mut d);
        f.watched(&mut d);
        f.ground_motion(&mut d);
        f.loops(&mut d);
        f.actuators(&mut d);
        if summary.coupled.is_none() {
            f.energy(&mut d);
            f.damping(&mut d);
            f.estimate(&mut d);
        }
    }
    if let Some(coupled) = &summary.coupled {
        coupled_check::found(&mut d, coupled);
    }
    // A failed test reports this once, at the end.
    if summary.outcome().is_ok() {
        d.tell(summary.sentence());
    }
    if let Some(watch) = &summary.watch {
        d.tell(watch.sentence());
    }
    d.heading("The record");
    d.explain(RECORDS);
    d.test_file(&experiment.test.text);
    d
}

/// A demonstration: the same test without and with compensation, and a test on a rig that differs from its declaration.
pub fn of_demo(
    none: &TestSection<'_>,
    paper: &TestSection<'_>,
    rows: &[Summary],
    undeclared: &Improvement,
) -> Document {
    let (bare, cured) = (Figures::of(none), Figures::of(paper));
    let title = "A fast pseudodynamic test, and what an actuator's delay does to it";
    let mut d = Document::new(title, lead(paper.experiment, paper.summary), true);
    let structure = &paper.experiment.test.config.structure;
    d.tell(format!(
        "A structure of {} kg on {} kN/m, an actuator {} ms late, {:.0} s of a near-fault ground motion.",
        structure.mass_kg[0],
        structure.stiffness_n_per_m[0] / 1e3,
        paper.experiment.test.config.compensation.delay_ms,
        paper.experiment.seconds,
    ));
    d.on_page(|d| {
        verdict(d, paper.summary);
        d.explain(
            "A computer integrates the equation of motion of a structure, an actuator pushes a specimen to each computed \
             displacement, and the measured force goes back into the equation. The actuator is a few milliseconds late. That is \
             enough to put more energy into the structure than its damping takes out.",
        );
        bare.ground_motion(d);
        d.heading("Without compensation");
        verdict(d, none.summary);
        bare.response(
            d,
            "Grey is the structure as it would move, orange is what the uncompensated test made of it.",
        );
        bare.loops(d);
        d.heading("With the variable damping of the paper");
        d.explain(
            "The energy that the actuator's error puts in is measured in every step, and a viscous damping of just that size \
             takes it out again.",
        );
        tiles(d, paper.summary);
        cured.displacement(d);
        cured.loops(d);
        cured.energy(d);
        cured.damping(d);
    });
    d.heading("Every compensation in this test");
    summaries(&mut d, rows);
    let shown = [Method::None, Method::Paper].map(Method::name);
    for row in rows.iter().filter(|r| shown.contains(&r.compensation)) {
        d.tell(format!("{}: {}", row.compensation, row.sentence()));
    }
    d.tell(format!(
        "\nAnd when the rig has something in it that nobody declared ({}):",
        undeclared.undeclared()
    ));
    d.on_terminal(|d| improvement::in_short(d, undeclared));
    improvement::table_of(&mut d, &[("undeclared".to_owned(), undeclared)]);
    let title = "When the rig has something in it that nobody declared";
    d.on_page(|d| improvement::section(d, title, undeclared));
    d.test_file(&paper.experiment.test.text);
    d
}

/// The verdict, and the watch's summary.
fn verdict(d: &mut Document, s: &Summary) {
    let doubt = if s.model_doubt_share > 0.05 {
        format!(
            " The filter's model of the rig did not fit the measurements in {} of the test.",
            percent(s.model_doubt_share)
        )
    } else {
        String::new()
    };
    d.verdict(s.validity(), format!("{}{doubt}", s.sentence()));
    if let Some(watch) = &s.watch {
        d.say(watch.sentence());
    }
}

fn tiles(d: &mut Document, s: &Summary) {
    let mut tiles = vec![
        (
            percent(s.eps_rms),
            "rms error, of the largest ideal displacement (Eq 18)".to_owned(),
        ),
        (percent(s.eps_max), "largest error (Eq 17)".into()),
        (length(s.peak_displacement_m), "largest displacement".into()),
    ];
    match &s.coupled {
        None => tiles.push((
            percent(s.mean_added_damping_ratio),
            "mean added damping, of critical".into(),
        )),
        Some(coupled) => tiles.extend(coupled_check::tiles(coupled)),
    }
    tiles.push((
        joule(s.energy_error_j),
        "energy error of the actuator (Eq 12); negative: put in".into(),
    ));
    d.tiles(tiles);
}
