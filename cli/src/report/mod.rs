//! The report: one HTML file that needs nothing beside it.

mod check;
mod comparison;
mod coupled;
mod coupled_test;
mod desk;
mod diagnosis;
mod difference;
mod figures;
mod frequency_response;
mod marths;
mod monte_carlo;
mod next;
mod page;
mod plot;
mod rths;
mod scale;
mod served;
mod sweep;
mod watched;

pub use check::{CheckSection, of_check};
pub use comparison::{of_compare, of_comparison};
pub use coupled::of_coupled;
pub use coupled_test::of_coupled_check;
pub use desk::of_desk;
pub use difference::of_difference;
pub use frequency_response::of_identify;
pub use marths::{DeclaredPart, of_marths};
pub use monte_carlo::{ManyTests, of_monte_carlo};
pub use page::TestSection;
pub use rths::of_rths;
pub use served::{SessionSection, of_served};
pub use sweep::of_sweep;

use crate::improve::Improvement;
use crate::terminal::{joule, percent};
use experiment::judged::JudgedRun;
use experiment::numbers::length;
use experiment::summary::Summary;
use figures::Figures;
use page::{escape, lead, page, table, test_file};
use std::fmt::Write as _;

/// What stands beside the report of a test.
const RECORDS: &str = "<h2>The record</h2><p>Every channel of every control step: <a href=\"record.csv\">record.csv</a>, and \
                       <a href=\"record.h5\">record.h5</a> for Python and MATLAB, which repeats the test, too. The figures: \
                       <a href=\"summary.json\">summary.json</a>. They lie beside this page.</p>";

/// The report of one test.
pub fn of_run(s: &TestSection<'_>) -> String {
    let f = Figures::of(s);
    let own = match &s.summary.coupled {
        None => [f.energy(), f.damping(), f.estimate()],
        Some(coupled) => [f.actuators(), coupled_test::found(coupled), String::new()],
    };
    let body = [
        verdict(s.summary),
        tiles(s.summary),
        f.displacement(),
        f.watched(),
        f.ground_motion(),
        f.loops(),
        own.concat(),
        RECORDS.into(),
        test_file(&s.experiment.test.text),
    ]
    .concat();
    let title = format!("Pseudodynamic test under {}", s.summary.record);
    page(&title, &lead(s), &body)
}

/// The report of a demonstration: the same test without and with compensation, and a test on a rig that was not as
/// declared.
pub fn of_demo(
    none: &TestSection<'_>,
    paper: &TestSection<'_>,
    rows: &[Summary],
    undeclared: &Improvement,
) -> String {
    let (bare, cured) = (Figures::of(none), Figures::of(paper));
    let body = [
        verdict(paper.summary),
        "<p>A computer integrates the equation of motion of a structure, an actuator pushes a specimen to each \
         computed displacement, and the measured force goes back into the equation. The actuator is a few \
         milliseconds late. That is enough to put more energy into the structure than its damping takes out.</p>"
            .into(),
        bare.ground_motion(),
        "<h2>Without compensation</h2>".into(),
        verdict(none.summary),
        bare.response("Grey is the structure as it would move, orange is what the uncompensated test made of it."),
        bare.loops(),
        "<h2>With the variable damping of the paper</h2>".into(),
        "<p>The energy that the actuator's error puts in is measured in every step, and a viscous damping of just \
         that size takes it out again.</p>"
            .into(),
        tiles(paper.summary),
        cured.displacement(),
        cured.loops(),
        cured.energy(),
        cured.damping(),
        "<h2>Every compensation in this test</h2>".into(),
        table(rows),
        improvement_section("When the rig has something in it that nobody declared", undeclared),
        test_file(&paper.experiment.test.text),
    ]
    .concat();
    let title = "A fast pseudodynamic test, and what an actuator's delay does to it";
    page(title, &lead(paper), &body)
}

/// The report of a diagnosis.
pub fn of_diagnosis(
    title: &str,
    d: &::diagnosis::Diagnosis,
    next: Option<&::diagnosis::Next>,
    [declared, improved]: [&str; 2],
) -> String {
    let each = |of: fn(&::diagnosis::ChannelAnswer) -> String| -> String {
        d.channels.iter().map(of).collect()
    };
    let steps = each(diagnosis::steps);
    let mut html = each(diagnosis::verdict);
    if !steps.is_empty() || next.is_some() {
        let play = next.map_or_else(String::new, |n| {
            format!(
                "<li><b>play the next test</b>: {} <a href=\"#next\">Its command and what each cause predicts</a></li>",
                escape(&crate::wording::plan::summary(n))
            )
        });
        let _ = write!(html, "<h2>What to do next</h2><ul>{steps}{play}</ul>");
    }
    for channel in &d.channels {
        html += &diagnosis::channel_details(channel);
    }
    if let Some(n) = next {
        html += &next::section(n);
    }
    let _ = write!(
        html,
        "<h2>The models</h2><div class=\"pair\"><div><h3>As declared</h3><pre class=\"file\">{}</pre></div><div><h3>With what \
         was found</h3><pre class=\"file\">{}</pre></div></div>",
        escape(declared.trim()),
        escape(improved.trim())
    );
    let lead = "What was measured is compared with what the declared model says, its parameters refitted around what \
                was declared; what is left beyond the noise is traced to an effect that the model lacks.";
    page(title, lead, &html)
}

/// The report of tests whose records were diagnosed, and of the tests after them.
pub fn of_improvements(stories: &[(String, &Improvement)]) -> String {
    let parts: Vec<String> = stories
        .iter()
        .map(|(name, s)| improvement_section(&format!("Test {}", escape(name)), s))
        .collect();
    let lead = "A test runs on a rig that has something in it that nobody declared. Its record is diagnosed, what was \
                found goes into the next test, and that test is judged by the same ideal.";
    page("From a record to a better test", lead, &parts.concat())
}

/// A test, its diagnosis, and the test after it.
fn improvement_section(title: &str, s: &Improvement) -> String {
    let section = |experiment, run: &'_ JudgedRun| -> String {
        let Some(trace) = &run.trace else {
            return String::new();
        };
        let section = TestSection {
            experiment,
            summary: &run.summary,
            trace,
            ideal: &s.ideal,
        };
        Figures::of(&section).response("Grey is the structure as it would move on an ideal rig.")
    };
    let mut html = format!(
        "<h2>{title}</h2><p class=\"verdict {}\">eps_rms {} before, <b>{}</b> after{}.</p>",
        s.after.summary.validity().class(),
        percent(s.before.summary.eps_rms),
        percent(s.after.summary.eps_rms),
        s.possible.as_ref().map_or_else(String::new, |r| format!(
            "; without the effect in the rig it is {}",
            percent(r.summary.eps_rms)
        )),
    );
    html += "<h3>The test as it was declared</h3>";
    html += &section(&s.experiment, &s.before);
    for c in s
        .diagnosis
        .channels
        .iter()
        .filter(|c| !c.effects.is_empty() || c.verdict == ::diagnosis::Verdict::Unknown)
    {
        html += &diagnosis::channel(c);
    }
    for d in &s.designed {
        html += &next::section(&d.next);
        html += "<h3>What all records say together</h3>";
        for c in &d.diagnosis.channels {
            let _ = write!(html, "<p>{}</p>", escape(&crate::wording::headline(c)));
        }
    }
    html += "<h3>What was done about it</h3>";
    if s.changes.is_empty() {
        html += "<p>Nothing: the second test is the first once more.</p>";
    }
    html += "<ul>";
    for change in &s.changes {
        let _ = write!(html, "<li>{}</li>", escape(change));
    }
    html += "</ul><h3>The test with what was found</h3>";
    html += &section(&s.improved, &s.after);
    let _ = write!(
        html,
        "<p>The record of this test, diagnosed with the improved model: missing is {}.</p>",
        Improvement::named(&s.remains)
    );
    html
}

fn verdict(s: &Summary) -> String {
    let doubt = if s.model_doubt_share > 0.05 {
        format!(
            " The filter's model of the rig did not fit the measurements in {} of the test.",
            percent(s.model_doubt_share)
        )
    } else {
        String::new()
    };
    let watched = s.watch.as_ref().map_or_else(String::new, |watch| {
        format!("<p>{}</p>", escape(&watch.sentence()))
    });
    format!(
        "<p class=\"verdict {}\">{}{doubt}</p>{watched}",
        s.validity().class(),
        escape(&s.sentence())
    )
}

fn tiles(s: &Summary) -> String {
    let mut tiles = vec![
        (
            percent(s.eps_rms),
            "rms error, of the largest ideal displacement (Eq 18)",
        ),
        (percent(s.eps_max), "largest error (Eq 17)"),
        (length(s.peak_displacement_m), "largest displacement"),
    ];
    match &s.coupled {
        None => tiles.push((
            percent(s.mean_added_damping_ratio),
            "mean added damping, of critical",
        )),
        Some(coupled) => tiles.extend(coupled_test::tiles(coupled)),
    }
    tiles.push((
        joule(s.energy_error_j),
        "energy error of the actuator (Eq 12); negative: put in",
    ));
    page::tiles(&tiles)
}
