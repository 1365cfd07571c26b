//! Stiffness lost for good, by the largest displacement so far or by travel, and what cannot be told from it.

use crate::criteria::specimen::{EVEN, TOGETHER};
use crate::model::answer::{ChannelAnswer, FoundEffect};
use crate::prepare::advice::four;
use crate::prepare::input::{Deficiency, alike};
use crate::record::recording::Recording;
use crate::record::{rest, travel};
use plant::{Channel, Effect};

fn damage(answer: &ChannelAnswer) -> Option<&FoundEffect> {
    let lost = |e: &&FoundEffect| e.name == Effect::Degradation;
    answer.effects.iter().find(lost)
}

/// A gain that falls with time and a stiffness that falls with travel, if the travel grows evenly with time.
pub fn deficiency(
    channel: Channel,
    effects: &[FoundEffect],
    train: &[Recording],
) -> Option<Deficiency> {
    let tires = |e: &FoundEffect| e.name == Effect::Degradation && e.value("travel_mm").is_some();
    let cools = |e: &FoundEffect| {
        e.name == Effect::TemperatureGain && e.value("change").is_some_and(|c| c < 0.0)
    };
    let asked = |e: &FoundEffect| tires(e) || cools(e);
    if channel != Channel::Specimen || !effects.iter().any(asked) {
        return None;
    }
    let ahead = train.iter().map(ahead).collect::<Option<Vec<f64>>>()?;
    let even = ahead.iter().all(|a| *a < EVEN);
    even.then(|| Deficiency {
        sentence: "The way gone grows evenly with time: a stiffness that is lost with travel cannot be told from a gain that \
                   changes with time, whatever fits. Pauses, or cycles of another size, tell them apart."
            .into(),
        alike: vec![vec![Effect::Degradation, Effect::TemperatureGain]],
    })
}

/// Largest deviation of a motion from an even pace, as a fraction of its travel; rests at its ends are no pauses.
fn ahead(record: &Recording) -> Option<f64> {
    let moving = rest::without(record);
    let travel = travel::cumulative(moving.displacement_mm.as_ref()?, moving.interval_s())?;
    let n = travel.len() as f64;
    let whole = travel.last()?.max(f64::MIN_POSITIVE);
    let off = travel.iter().enumerate();
    Some(
        off.map(|(i, w)| (w / whole - (i + 1) as f64 / n).abs())
            .fold(0.0, f64::max),
    )
}

/// Which of the two reduces the stiffness, and by how much.
pub fn note(answer: &ChannelAnswer, train: &[Recording]) -> Option<String> {
    let effect = damage(answer)?;
    let travel_mm: f64 = train
        .iter()
        .filter_map(|r| {
            let travel = travel::cumulative(r.displacement_mm.as_ref()?, r.interval_s())?;
            travel.last().copied()
        })
        .sum();
    let known = answer
        .refitted
        .iter()
        .find(|r| r.name == "stiffness_n_per_mm");
    let half_mm = effect.value("travel_mm");
    let share = effect.value("lost_share").or_else(|| {
        let lost = effect.value("stiffness_lost_in_the_end_n_per_mm")?;
        known.filter(|k| k.value > 0.0).map(|k| lost / k.value)
    });
    let both = train.iter().map(together).collect::<Option<Vec<f64>>>()?;
    let one = both.iter().all(|r| *r > TOGETHER);
    let which = match (half_mm, share) {
        // The mean over the records' travel.
        (Some(half_mm), Some(share)) => format!(
            "The stiffness falls with the way gone, by {} % per metre over the {} m of the training data",
            four(100.0 * share / (travel_mm + half_mm) * 1e3),
            four(1e-3 * travel_mm)
        ),
        (Some(_), None) => "The stiffness falls with the way gone".into(),
        (None, _) => "The stiffness falls with the largest displacement so far".into(),
    };
    let other = match (half_mm, one) {
        (_, true) => {
            "; the largest displacement grows as the way does, so which of the two takes it is not told. Smaller cycles after \
             the largest would"
        }
        (Some(_), false) => ", not with the largest displacement so far",
        (None, false) => ", not with the way gone",
    };
    Some(format!("{which}{other}."))
}

/// How closely the largest displacement so far follows the travel, each moment weighted by its force.
fn together(record: &Recording) -> Option<f64> {
    let x = record.displacement_mm.as_ref()?;
    let travel = travel::cumulative(x, record.interval_s())?;
    let mut largest = record.largest_before_mm();
    let moments = x.iter().zip(&travel).map(|(x, w)| {
        largest = largest.max(x.abs());
        (x * x, largest, *w)
    });
    Some(alike(&moments.collect::<Vec<_>>()))
}
