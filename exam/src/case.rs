//! One question of the exam, from a class and a seed.

use crate::class::{Class, Options};
use crate::declared::Declared;
use crate::draws::Draws;
use crate::effect::{Acts, Channel, Scale, family, indistinguishable};
use crate::excitation::{Excitation, Plan};
use crate::fine::{derivative, peak, rms};
use crate::key::{ChannelKey, Hidden, Key};
use crate::lab::Lab;
use crate::measure::{Placed, Readings, measure};
use crate::question::{Question, questions, slow_only, undeclared};
use crate::record::Record;
use crate::rig::Scene;
use crate::size::strength_of;

/// A question and its key.
#[derive(Clone, Debug)]
pub struct Case {
    /// Class and seed.
    pub id: String,
    /// What the examinee gets.
    pub paper: Paper,
    /// What only the scorer gets.
    pub key: Key,
}

/// What the examinee gets.
#[derive(Clone, Debug)]
pub struct Paper {
    /// The declared model.
    pub declared: Declared,
    /// The training record: 22 000 samples.
    pub train: Record,
    /// The test record: 12 000 samples of another excitation.
    pub test: Record,
    /// The rests before and after the motion in the training record, s.
    pub rest_s: [(f64, f64); 2],
}

/// Lengths of the training and the test record, in samples.
const SAMPLES: [usize; 2] = [22_000, 12_000];

/// The case of a class and a seed; the same seed gives the same case.
pub fn set(class: Class, seed: u64, options: &Options) -> Case {
    let mut rng = rng(class, seed);
    let questions = questions(class, seed, &mut rng);
    let mut tries = 0;
    loop {
        // Smooth yielding is visible at every usual strength, so a small effect needs an unusually weak one.
        let usual = tries < USUAL_TRIES;
        if let Some(case) = attempt(class, seed, &questions, options, usual, &mut rng) {
            return case;
        }
        tries += 1;
    }
}

/// Names that the case of a class and a seed hides, without making the case; empty for an effect that is not in the list.
pub fn hides(class: Class, seed: u64) -> Vec<&'static str> {
    let questions = questions(class, seed, &mut rng(class, seed));
    questions.into_iter().map(Question::name).collect()
}

/// Each class has its own random stream.
fn rng(class: Class, seed: u64) -> Draws {
    Draws::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ ((class as u64 + 1) << 56))
}

/// Number of rigs drawn before strengths below the usual ones are tried.
const USUAL_TRIES: usize = 40;

/// None if the rig drawn does not show the effect at the wanted size.
fn attempt(
    class: Class,
    seed: u64,
    questions: &[Question],
    options: &Options,
    usual: bool,
    rng: &mut Draws,
) -> Option<Case> {
    let lab = Lab::draw(undeclared(questions), rng);
    let rate_hz = rng.pick(&[1000.0, 2000.0]);
    let plans = plans(slow_only(class, questions), rate_hz, rng);
    let commands = plans.map(|p| p.trajectory(rng));

    let (drive, x) = lab.truth.displacement(&commands[0]);
    let seconds = SAMPLES[0] as f64 / rate_hz;
    let scale = Scale {
        x: peak(&x),
        v: rms(&derivative(&x)) * (seconds / plans[0].moving_s).sqrt(),
        k: lab.truth.stiffness_n_per_mm,
        seconds,
        high_hz: plans[0].high_hz,
    };
    let room = rng.between(1.15, 1.6);
    let full_scale = [room * scale.x, room * peak(&lab.truth.force(&x).1)];
    let readings = Readings {
        rate_hz,
        full_scale,
        sigma: full_scale.map(|f| options.noise_ratio * f),
        bits: [(); 2].map(|()| rng.pick(&[12, 13, 14, 16, 18])),
    };
    let bare = Bare {
        lab: &lab,
        command: &commands[0],
        drive,
        x,
        scale,
        sigma: readings.sigma,
    };
    let placed = bare.place(questions, options, usual, rng)?;

    let [(train, _), (test, floors)] = [0, 1].map(|i| {
        measure(
            &lab.truth,
            &placed,
            &commands[i],
            SAMPLES[i],
            &readings,
            rng,
        )
    });
    let motion_ends_s = plans[0].rest_before_s + plans[0].moving_s;
    Some(Case {
        id: format!("{}-{seed}", class.name()),
        paper: Paper {
            declared: lab.declared,
            train,
            test,
            rest_s: [
                (0.0, plans[0].rest_before_s - 0.05),
                (motion_ends_s + 0.4, seconds - 1.0 / rate_hz),
            ],
        },
        key: Key {
            class,
            excitation: plans[0].kind,
            channels: Channel::ALL.map(|c| channel_key(c, questions, &placed, floors)),
        },
    })
}

/// Training and test: two different excitations, the second no larger and no faster than the first.
fn plans(slow: bool, rate_hz: f64, rng: &mut Draws) -> [Plan; 2] {
    let high_hz = if slow {
        rng.between(0.8, 1.3)
    } else {
        rng.between(6.0, 14.0)
    };
    let pool: &[Excitation] = if slow {
        &[Excitation::Multisine, Excitation::Chirp]
    } else {
        &Excitation::ALL
    };
    let first = rng.pick(pool);
    let others: Vec<Excitation> = pool.iter().copied().filter(|k| *k != first).collect();
    let second = rng.pick(&others);
    let amplitude_mm = rng.log_between(5.0, 40.0);
    let smaller = rng.between(0.8, 1.0);
    let plan = |kind, samples: usize, rest_before_s: f64, rest_after_s: f64, share: f64| Plan {
        kind,
        amplitude_mm: amplitude_mm * share,
        high_hz: high_hz * share,
        rest_before_s,
        moving_s: samples as f64 / rate_hz - rest_before_s - rest_after_s,
        rest_after_s,
    };
    [
        plan(first, SAMPLES[0], 1.6, 1.8, 1.0),
        plan(second, SAMPLES[1], 1.0, 0.6, smaller),
    ]
}

/// The training record's rig before anything is hidden in it.
struct Bare<'a> {
    lab: &'a Lab,
    command: &'a [f64],
    drive: Scene,
    /// mm
    x: Vec<f64>,
    scale: Scale,
    sigma: [f64; 2],
}

impl Bare<'_> {
    /// Chooses the strengths, the actuator's first because the specimen moves with it. None if the rig does not show an
    /// effect at its wanted size.
    fn place(
        &self,
        questions: &[Question],
        options: &Options,
        usual: bool,
        rng: &mut Draws,
    ) -> Option<Vec<Placed>> {
        let lab = self.lab;
        let wanted = rng.log_between(options.size.0, options.size.1);
        let [x_sigma, f_sigma] = self.sigma;
        let floor = [x_sigma, f_sigma.hypot(self.scale.k * x_sigma)];
        let mut placed: Vec<Placed> = Vec::new();
        let mut moves = self.x.clone();
        for channel in Channel::ALL {
            if !questions.iter().any(|q| q.channel() == channel) {
                continue;
            }
            let (scene, without, free) = match channel {
                Channel::Actuator => (
                    self.drive.clone(),
                    self.x.clone(),
                    lab.actuator_free(self.command),
                ),
                Channel::Specimen => {
                    let (scene, force) = lab.truth.force(&moves);
                    (scene, force, lab.specimen_free(&moves))
                }
            };
            for question in questions.iter().filter(|q| q.channel() == channel) {
                let physics = question.draw(&self.scale, rng)?;
                // A second effect is neither much larger nor much smaller than the first.
                let ratio = if placed.is_empty() {
                    1.0
                } else {
                    rng.log_between(0.5, 2.0)
                };
                let unit = floor[channel as usize];
                let goal = wanted * ratio;
                let (strength, size) =
                    strength_of(&physics, &scene, &without, &free, goal * unit, usual);
                let size = size / unit;
                if !(0.6 * goal..1.6 * goal).contains(&size) {
                    return None;
                }
                if channel == Channel::Actuator && physics.acts == Acts::Motion {
                    moves = (physics.apply)(strength, &scene, &moves);
                }
                placed.push(Placed {
                    physics,
                    strength,
                    size,
                });
            }
        }
        Some(placed)
    }
}

fn channel_key(
    channel: Channel,
    questions: &[Question],
    placed: &[Placed],
    floors: [f64; 2],
) -> ChannelKey {
    let mut key = ChannelKey {
        channel,
        hidden: Vec::new(),
        outside: None,
        echo: None,
        floor_rms: floors[channel as usize],
    };
    for p in placed {
        let physics = &p.physics;
        let asked = questions
            .iter()
            .find(|q| q.name() == physics.name && q.channel() == physics.channel);
        match (family(physics.name), asked) {
            _ if physics.channel != channel => {
                if physics.channel == Channel::Actuator && physics.acts != Acts::Motion {
                    key.echo = Some(physics.name);
                }
            }
            (Some(family), Some(question)) => key.hidden.push(Hidden {
                name: physics.name,
                family,
                equations: question.equations(),
                equation: physics.equation,
                size: p.size,
                parameters: (physics.parameters)(p.strength),
                same: same(*question),
            }),
            _ => key.outside = Some(physics.equation),
        }
    }
    key
}

/// Names that no analysis of the record can tell from the hidden one.
fn same(question: Question) -> &'static [&'static str] {
    match question {
        Question::EarlyForce => &["viscous_damping"],
        _ => indistinguishable(question.name(), question.channel()),
    }
}
