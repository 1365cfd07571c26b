//! Cases of every class can be made, are repeatable, have the requested size and are as quiet as their key says.

use exam::effect::LIST;
use exam::{Case, Channel, Class, Options, set};

fn rms(x: impl Iterator<Item = f64>) -> f64 {
    let (n, sum) = x.fold((0, 0.0), |(n, s), x| (n + 1, s + x * x));
    (sum / f64::from(n)).sqrt()
}

#[test]
fn the_same_seed_gives_the_same_case_and_another_seed_another() {
    let set = |seed| set(Class::Two, seed, &Options::default());
    let (a, b, c) = (set(11), set(11), set(12));
    assert_eq!(a.paper.train.force_n, b.paper.train.force_n);
    assert_eq!(a.paper.declared, b.paper.declared);
    assert_ne!(a.paper.train.force_n, c.paper.train.force_n);
}

#[test]
fn every_class_can_be_set_and_hides_what_it_says() {
    for class in Class::ALL {
        for seed in 0..8 {
            let Case { paper, key, .. } = set(class, seed, &Options::default());
            let hidden: usize = key.channels.iter().map(|c| c.hidden.len()).sum();
            let outside = key.channels.iter().filter(|c| c.outside.is_some()).count();
            let expected = match class {
                Class::Clean => (0, 0),
                Class::Outside => (0, 1),
                Class::Two => (2, 0),
                _ => (1, 0),
            };
            assert_eq!((hidden, outside), expected, "{class:?} {seed}");
            assert_eq!(paper.train.force_n.len(), 22_000);
            assert_eq!(paper.test.time_s.len(), 12_000);
            let all = [&paper.train, &paper.test];
            assert!(
                all.iter()
                    .flat_map(|r| r.force_n.iter().chain(&r.displacement_mm))
                    .all(|x| x.is_finite())
            );
        }
    }
}

#[test]
fn every_effect_of_the_list_can_be_hidden_at_the_wanted_size() {
    let options = Options::default();
    for class in [Class::Matched, Class::Unseen] {
        for (seed, (name, family, channel)) in LIST.iter().enumerate() {
            let key = set(class, seed as u64, &options).key;
            let hidden = &key.channels[*channel as usize].hidden[0];
            assert_eq!((hidden.name, hidden.family), (*name, *family));
            assert!(
                (3.0..80.0).contains(&hidden.size),
                "{name}: {} floors",
                hidden.size
            );
        }
    }
}

#[test]
fn at_rest_before_the_test_a_clean_record_holds_its_noise_and_nothing_else() {
    for seed in 0..6 {
        let Case { paper, key, .. } = set(Class::Clean, seed, &Options::default());
        let n = (0.9 * paper.test.rate_hz) as usize;
        for (channel, signal) in [
            (Channel::Actuator, &paper.test.displacement_mm),
            (Channel::Specimen, &paper.test.force_n),
        ] {
            let floor = key.channels[channel as usize].floor_rms;
            let mean = signal[..n].iter().sum::<f64>() / n as f64;
            let own = rms(signal[..n].iter().map(|y| y - mean));
            // The specimen's floor includes the displacement's noise.
            assert!(
                (0.3..1.5).contains(&(own / floor)),
                "{seed} {channel:?}: {own} of {floor}"
            );
        }
    }
}

#[test]
fn what_a_perfect_model_leaves_of_the_force_is_the_floor_of_the_key() {
    // For a spring alone, stiffness and offset by least squares on the measured displacement.
    let case = (0..200)
        .map(|seed| set(Class::Clean, seed, &Options::default()))
        .find(|c| {
            let s = &c.paper.declared.specimen;
            s.damping_n_s_per_mm.is_none() && s.mass_kg.is_none()
        })
        .expect("every third rig is a spring alone");
    let (x, f) = (&case.paper.test.displacement_mm, &case.paper.test.force_n);
    let n = x.len() as f64;
    let (mx, mf) = (x.iter().sum::<f64>() / n, f.iter().sum::<f64>() / n);
    let sxx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let sxf: f64 = x.iter().zip(f).map(|(x, f)| (x - mx) * (f - mf)).sum();
    let k = sxf / sxx;
    let left = rms(x.iter().zip(f).map(|(x, f)| f - mf - k * (x - mx)));
    let floor = case.key.channels[1].floor_rms;
    assert!((left / floor - 1.0).abs() < 0.02, "{left} N of {floor} N");
    let declared = case.paper.declared.specimen.stiffness_n_per_mm;
    assert!((k - declared.value).abs() < 2.1 * declared.tolerance);
}
