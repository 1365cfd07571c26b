//! An unused channel, and a varied setting, on third-party records: what both must show is known by other means
//! (`outside2/README.md` of the data).
#![cfg(not(debug_assertions))] // Minutes without optimisation.

use diagnosis::{
    Diagnosis, Dose, Model, Recording, Says, Testimony, Witnessed, diagnose, testimonies, turned,
};
use experiment::files::columns::Columns;
use experiment::files::measured::{FilePart, RecordFiles};
use experiment::files::model;
use experiment::files::witness::WitnessColumn;
use plant::Effect;
use std::path::{Path, PathBuf};

/// The folder of the records; `None` if they are missing, which is counted.
fn folder() -> Option<PathBuf> {
    let cases = test_data::file("outside2/cases.toml")?;
    cases.parent().map(Path::to_owned)
}

fn part(folder: &Path, part: &str) -> Vec<Recording> {
    let part: FilePart = folder.join(part).display().to_string().parse().unwrap();
    RecordFiles::default().parts(&[part]).unwrap()
}

/// A declared model, a diagnosis with it, and its training and held-out records.
type Found = (Model, Diagnosis, [Vec<Recording>; 2]);

/// The diagnosis of two spans of a file, without their force if `with_force` is false.
pub fn found(folder: &Path, declared: &str, spans: [&str; 2], with_force: bool) -> Found {
    let declared = model::load(&folder.join(declared)).unwrap();
    let sets = spans.map(|span| {
        let mut records = part(folder, span);
        for r in &mut records {
            let mut own = Some(r);
            while let Some(part) = own {
                if !with_force {
                    part.force_n = None;
                }
                own = part.before.as_deref_mut();
            }
        }
        records
    });
    let diagnosis = diagnose(&declared, &sets[0], &sets[1], &[]).unwrap();
    (declared, diagnosis, sets)
}

/// What the column `force_1` of a file says of the one name, and the share of it that each name explains.
pub fn testimony(folder: &Path, file: &str, found: &Found) -> (Testimony, impl Fn(Effect) -> f64) {
    let (declared, diagnosis, sets) = found;
    let column = format!("{}:force_1", folder.join(file).display());
    let column: WitnessColumn = column.parse().unwrap();
    let read = column.read(&Columns::default()).unwrap();
    let witnessed = [0, 1].map(|set: usize| -> Vec<Witnessed> {
        let beside = |r: &Recording| Witnessed {
            record: r.clone(),
            read: read.at(&r.time_s).unwrap(),
        };
        sets[set].iter().map(beside).collect()
    });
    let all = testimonies(declared, diagnosis, &sets[0], &witnessed);
    let [only] = &all[..] else {
        panic!("{all:?}");
    };
    let said = only.clone();
    println!(
        "{} {:?} {:.2} {:?}",
        said.name, said.says, said.share, said.others
    );
    let of = move |wanted: Effect| {
        let other = said.others.iter().find(|o| o.name == wanted);
        if said.name == wanted {
            said.share
        } else {
            other.map_or(0.0, |o| o.share)
        }
    };
    (only.clone(), of)
}

#[test]
fn the_pressure_of_a_shake_table_shows_friction_and_no_asymmetry() {
    let Some(folder) = folder() else { return };
    let spans = ["table_small.csv@0..45", "table_small.csv@45..71.9"];
    let found = found(&folder, "table.toml", spans, false);
    let (heard, of) = testimony(&folder, "table_small.csv", &found);
    // The motion is held back at each reversal: by friction, or by play, which this motion cannot distinguish.
    assert_eq!(heard.says, Says::For);
    assert!(matches!(
        heard.name,
        Effect::CoulombFriction | Effect::Backlash
    ));
    assert!(of(Effect::CoulombFriction) > 0.6);
    assert!(of(Effect::AsymmetricActuator) < 0.15);
}

#[test]
fn the_force_of_a_brake_follows_the_tension_of_its_band_and_nothing_declared_does() {
    let Some(folder) = folder() else { return };
    let spans = ["damper_35lb.csv@0..9", "damper_35lb.csv@9..16"];
    let (declared, diagnosis, _) = found(&folder, "damper.toml", spans, true);
    let dose = |(at, span): (f64, &str)| Dose {
        at,
        records: part(&folder, span),
    };
    let doses = [
        (80.0, "damper_80lb.csv"),
        (20.0, "damper_20lb.csv@0..16"),
        (35.0, "damper_35lb.csv"),
    ]
    .map(dose);
    let all = turned(&declared, &diagnosis, &doses);
    let [brake] = &all[..] else {
        panic!("{all:?}");
    };
    println!("{brake:?}");
    assert_eq!(brake.doses, [20.0, 35.0, 80.0]);
    for number in &brake.numbers {
        assert_eq!(number.follows, number.name == "rms_n", "{number:?}");
    }
    // The plateaus measured by its makers, in increasing order: 4.2, 9.2, 12.5 kN; sliding fills most of each loop.
    let made = &brake.numbers[0].values;
    for (rms_n, plateau_n) in made.iter().zip([4.2e3, 9.2e3, 12.5e3]) {
        assert!((0.6..1.0).contains(&(rms_n / plateau_n)), "{made:?}");
    }
    assert!(brake.left.iter().all(|left| *left < 0.25));
}
