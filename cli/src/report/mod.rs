//! The report: one HTML file that needs nothing beside it.

mod plot;

use crate::bench::Finished;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::summary::{Summary, Verdict, added_damping_ratio};
use crate::terminal::{joule, percent};
use plot::{Curve, IDEAL, TESTED, THIRD, WRONG, history, path};
use std::fmt::Write as _;

/// A test as the report shows it.
pub struct Section<'a> {
    /// What was tested.
    pub test: &'a TestFile,
    /// Its figures.
    pub summary: &'a Summary,
    /// Its trace.
    pub run: &'a Finished,
    /// The ideal it is compared with.
    pub ideal: &'a Finished,
}

type Drawn = Result<String, Box<dyn std::error::Error>>;

/// The report of one test.
///
/// # Errors
/// The drawing library's.
pub fn of_run(s: &Section<'_>) -> Result<String, Failure> {
    let body = run_body(s).map_err(cannot)?;
    Ok(page(
        &format!("Pseudodynamic test: {}", s.summary.record),
        &lead(s),
        &(summary_table(std::slice::from_ref(s.summary)) + &body),
    ))
}

/// The report of a demonstration: the same test without and with compensation.
///
/// # Errors
/// The drawing library's.
pub fn of_demo(
    none: &Section<'_>,
    paper: &Section<'_>,
    rows: &[Summary],
) -> Result<String, Failure> {
    let mut body = summary_table(rows);
    let story = || -> Drawn {
        let mut html = String::from(
            "<h2>Without compensation</h2><p>The actuator follows some milliseconds late. Force and displacement then \
             turn around each other the wrong way: every cycle puts energy in, and the structure runs away.</p>",
        );
        html += &displacement(none)?;
        html += "<h2>With the paper's variable damping</h2><p>The energy error of each step is measured and a viscous \
                 damping of just that size takes it out again.</p>";
        html += &run_body(paper)?;
        Ok(html)
    };
    body += &story().map_err(cannot)?;
    Ok(page("outerloop: a demonstration", &lead(paper), &body))
}

fn cannot(e: Box<dyn std::error::Error>) -> Failure {
    Failure::Test(format!("the report cannot be drawn: {e}"))
}

fn lead(s: &Section<'_>) -> String {
    let c = &s.test.config;
    format!(
        "{} at {} Hz{}, compensation <b>{}</b>, {:.1} s of ground motion.",
        match c.degrees_of_freedom() {
            1 => "One degree of freedom".into(),
            n => format!(
                "{n} degrees of freedom, {} in the laboratory",
                c.physical_storeys()
            ),
        },
        c.timing.rate_hz,
        if c.timing.time_scale == 1.0 {
            " in real time".into()
        } else {
            format!(", {} times slower than real time", c.timing.time_scale)
        },
        s.summary.compensation,
        s.summary.steps as f64 / s.summary.rate_hz / c.timing.time_scale,
    )
}

fn summary_table(rows: &[Summary]) -> String {
    let mut html = String::new();
    for s in rows {
        let good = s.verdict == Verdict::Completed && s.eps_rms < 0.1 && s.locked_share < 0.2;
        let class = if good { "verdict" } else { "verdict bad" };
        let _ = write!(
            html,
            "<p class=\"{class}\"><b>{}</b>: {}</p>",
            s.compensation,
            escape(&s.sentence())
        );
    }
    html += "<table><tr><th>compensation</th><th>verdict</th><th>eps_max</th><th>eps_rms</th><th>peak</th>\
             <th>added damping, mean / peak</th><th>energy error (Eq 12 / HSEM / Eq 6)</th></tr>";
    for s in rows {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2} mm</td><td>{} / {}</td><td>{} / {} / {}</td></tr>",
            s.compensation,
            s.trip.unwrap_or(s.verdict.name()),
            percent(s.eps_max),
            percent(s.eps_rms),
            s.peak_displacement_m * 1e3,
            percent(s.mean_added_damping_ratio),
            percent(s.peak_added_damping_ratio),
            joule(s.energy_error_j),
            joule(s.energy_error_hsem_j),
            joule(s.energy_error_stiffness_j),
        );
    }
    html += "</table><p class=\"lead\">eps_max and eps_rms are Eqs 17 and 18 of the paper: the difference to the same \
             integration with an ideal actuator, relative to the largest ideal displacement.</p>";
    html
}

fn run_body(s: &Section<'_>) -> Drawn {
    let trace = &s.run.trace;
    let time = model_time(s);
    let mut html = String::from("<h2>Ground motion</h2>");
    html += &figure(
        &plot::plot(
            "time [s]",
            "acceleration [m/s²]",
            &[Curve {
                name: "",
                colour: TESTED,
                points: history(&time, |i| f64::from(trace.ground_m_per_s2[i])),
            }],
        )?,
        "As the integration saw it.",
    );
    html += "<h2>Displacement</h2>";
    html += &displacement(s)?;
    html += "<h2>Force against displacement</h2><div class=\"pair\">";
    for (j, floor) in trace
        .floors
        .iter()
        .enumerate()
        .take(s.test.config.physical_storeys())
    {
        let force = |i: usize| f64::from(floor.force_n[i]) * 1e-3;
        let measured = path(floor.force_n.len(), |i| {
            (f64::from(floor.displacement_m[i]) * 1e3, force(i))
        });
        let perceived = path(floor.force_n.len(), |i| {
            (f64::from(floor.command_m[i]) * 1e3, force(i))
        });
        html += &figure(
            &plot::square(
                "displacement [mm]",
                "force [kN]",
                &[
                    Curve {
                        name: "perceived: against the command",
                        colour: WRONG,
                        points: perceived,
                    },
                    Curve {
                        name: "measured: against the specimen",
                        colour: TESTED,
                        points: measured,
                    },
                ],
            )?,
            &format!(
                "Floor {}. The red loop is the energy that the actuator's error puts in.",
                j + 1
            ),
        );
    }
    html += "</div><h2>Energy error</h2>";
    let energy = |name, colour, column: &[f32]| Curve {
        name,
        colour,
        points: history(&time, |i| f64::from(column[i])),
    };
    html += &figure(
        &plot::plot(
            "time [s]",
            "cumulative energy error [J]",
            &[
                energy("Thewalt and Roman, Eq 6", IDEAL, &trace.energy_stiffness_j),
                energy("HSEM, Eqs 7 to 9", WRONG, &trace.energy_hsem_j),
                energy("modified, Eqs 10 to 12", TESTED, &trace.energy_modified_j),
            ],
        )?,
        "Negative: the actuator puts energy in (Fig 9 of the paper).",
    );
    if let Some(floor) = trace.floors.first() {
        let ratio = 100.0 * added_damping_ratio(s.test);
        html += "<h2>Added damping</h2>";
        html += &figure(
            &plot::plot(
                "time [s]",
                "added damping [% of critical]",
                &[Curve {
                    name: "",
                    colour: TESTED,
                    points: history(&time, |i| {
                        ratio * f64::from(floor.added_damping_n_s_per_m[i])
                    }),
                }],
            )?,
            "What the compensation adds (Fig 11).",
        );
        html += &figure(
            &plot::plot(
                "time [s]",
                "gain G_v [1]",
                &[Curve {
                    name: "",
                    colour: THIRD,
                    points: history(&time, |i| f64::from(floor.gain[i])),
                }],
            )?,
            "The switch of Eq 19: 1 in motion, towards 0 where the structure turns round (Fig 16).",
        );
    }
    Ok(html)
}

fn displacement(s: &Section<'_>) -> Drawn {
    let time = model_time(s);
    let mut html = String::new();
    for (j, (floor, ideal)) in s
        .run
        .trace
        .floors
        .iter()
        .zip(&s.ideal.trace.floors)
        .enumerate()
    {
        let n = floor.command_m.len().min(ideal.command_m.len());
        let curve = |name, colour, column: &[f32]| Curve {
            name,
            colour,
            points: history(&time[..n], |i| f64::from(column[i]) * 1e3),
        };
        html += &figure(
            &plot::plot(
                "time [s]",
                "displacement [mm]",
                &[
                    curve(
                        "test",
                        if s.summary.verdict == Verdict::Completed {
                            TESTED
                        } else {
                            WRONG
                        },
                        &floor.command_m,
                    ),
                    curve("ideal actuator", IDEAL, &ideal.command_m),
                ],
            )?,
            &format!("Floor {}.", j + 1),
        );
        let error = history(&time[..n], |i| {
            (f64::from(floor.command_m[i]) - f64::from(ideal.command_m[i])) * 1e3
        });
        html += &figure(
            &plot::plot(
                "time [s]",
                "error [mm]",
                &[Curve {
                    name: "",
                    colour: WRONG,
                    points: error,
                }],
            )?,
            "Test less ideal.",
        );
    }
    Ok(html)
}

/// Time of the model: what the ground motion is written in.
fn model_time(s: &Section<'_>) -> Vec<f64> {
    let scale = s.test.config.timing.time_scale;
    s.run.trace.time_s.iter().map(|t| t / scale).collect()
}

fn figure(svg: &str, caption: &str) -> String {
    format!("<figure>{svg}<figcaption>{caption}</figcaption></figure>\n")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

fn page(title: &str, lead: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><title>{title}</title><style>{}</style></head><body>\
         <h1>{title}</h1><p class=\"lead\">{lead}</p>{body}<footer>outerloop {}</footer></body></html>\n",
        include_str!("style.css"),
        env!("CARGO_PKG_VERSION"),
    )
}
