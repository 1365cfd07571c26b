//! How long a step of a test takes on this chip, before anything moves.

use outerloop_core::{Event, GroundMotion, OuterLoop, Rig, Sample, flag};

/// Solved steps that are timed, at the end of the rehearsal, when caches and predictors are warm.
const TIMED: usize = 16;

/// Steps of a rehearsal, 10 ms of them: the rehearsing task must show signs of life.
const STEPS: usize = 400;

/// Most control steps per solved step.
const LONGEST: usize = 50;

/// Runs solved steps and times them by `now`; returns the ticks of a long one, and leaves the loop as built.
///
/// A step takes at least the time of its instructions, and more if the control interrupt or one of the link falls into
/// it: one in ten or so. So the longest quarter is dropped. The longest of the rest is used, not the shortest, since
/// steps differ by themselves: a predictor that learns, a damping that acts.
#[inline(never)] // Inlined, the stack would hold the needs of every number of floors.
pub(super) fn rehearse<const N: usize, R: Rig<N>>(
    outer: &mut OuterLoop<N, R>,
    now: fn() -> u32,
) -> u32 {
    let (mut ticks, solved) = timed(outer, now);
    start_anew(outer);
    let ticks = &mut ticks[..solved.min(TIMED)];
    ticks.sort_unstable();
    // A test without a timed step does not keep its deadline.
    let place = ticks.len().saturating_sub(1) * 3 / 4;
    ticks.get(place).copied().unwrap_or(u32::MAX)
}

/// Only once, not inlined in two places: the parts that are put back are on the stack.
#[inline(never)]
fn start_anew<const N: usize, R: Rig<N>>(outer: &mut OuterLoop<N, R>) {
    outer.restart();
}

/// Ticks of the last solved steps, and how many there were.
fn timed<const N: usize, R: Rig<N>>(
    outer: &mut OuterLoop<N, R>,
    now: fn() -> u32,
) -> ([u32; TIMED], usize) {
    // A ground at rest that outlasts the rehearsal: at its end the test would be over, and nothing solved any more.
    let rest = [0.0; 2];
    let ground = GroundMotion::new(&rest, 1.0, 0.5 / STEPS as f64);
    let ground = ground.unwrap_or(GroundMotion::none());
    // Idle, the target follows the rig. With a transducer offset the approach from there would outlast the rehearsal:
    // it starts where the reading means zero, iterated once because of the transducer's gain.
    let mut at_m = [0.0_f32; N];
    for _ in 0..2 {
        let still = Sample::new(at_m, [0.0; N]);
        outer.step(&still, &ground);
        let idle_m = outer.step(&still, &ground).record.command_m;
        at_m = core::array::from_fn(|j| at_m[j] - idle_m[j]);
        start_anew(outer);
    }
    let (mut ticks, mut solved) = ([0; TIMED], 0);
    for step in 0..STEPS {
        // In a test with long integration steps nearly all the solving is at the start.
        if solved < step / LONGEST {
            start_anew(outer);
        }
        // An obstacle to arming must normally be gone for half a rehearsal; here it only has to be gone.
        if outer.obstacle().is_some_and(|(_, since)| since > 1) {
            outer.take_over(None, 0);
        }
        // As soon as each is valid; before that it is refused without effect.
        for event in [Event::Clear, Event::Arm, Event::Start] {
            let _ = outer.handle(event);
        }
        // A motion that reverses and a force unrelated to its stiffness: everything that a step may have to handle.
        let swing = [1.0_f32, 0.5, -0.5, -1.0][step / 8 % 4];
        at_m = at_m.map(|at_m| at_m + 1e-6 * swing);
        let sample = Sample::new(at_m, [10.0 * swing; N]);
        let begin = now();
        let record = outer.step(&sample, &ground).record;
        let took = now().wrapping_sub(begin);
        if record.flags & flag::SOLVED != 0 {
            ticks[solved % TIMED] = took;
            solved += 1;
        }
    }
    (ticks, solved)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicU32, Ordering};
    use outerloop_core::{Config, Design, Method, Mode, Prediction};

    /// A step takes 100 ticks; one in seven is interrupted.
    fn now() -> u32 {
        static CALLS: AtomicU32 = AtomicU32::new(0);
        let call = CALLS.fetch_add(1, Ordering::Relaxed);
        let interrupts = call.div_ceil(2) / 7;
        100 * call + 5000 * interrupts
    }

    fn outer<const N: usize>(method: Method, substeps: u16) -> OuterLoop<N> {
        let mut config = Config::shear_frame([1000.0; N], [1.58e3; N], [0.02; N]);
        config.structure.physical_storeys = Some(1);
        config.compensation.kind = method;
        config.timing.substeps = substeps;
        OuterLoop::new(Design::new(&config).unwrap())
    }

    fn solves<const N: usize>(method: Method) {
        let (_, solved) = timed(&mut outer::<N>(method, 20), || 0);
        assert_eq!(solved, STEPS.div_ceil(20), "{method}, {N} floors");
    }

    #[test]
    fn with_every_method_the_steps_that_are_timed_are_solved_ones() {
        let behind = Prediction::ALL[1..]
            .iter()
            .map(|&p| Method::Paper.behind(p));
        for method in Method::ALL.into_iter().chain(behind) {
            solves::<1>(method);
            solves::<2>(method);
            solves::<3>(method);
        }
    }

    #[test]
    fn a_transducer_that_reads_off_leaves_as_much_to_be_timed() {
        let mut config = Config::shear_frame([1000.0], [1.58e3], [0.02]);
        config.rig.displacement_offset_m = [2e-3].into_iter().collect();
        config.rig.displacement_gain = [1.1].into_iter().collect();
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        let (_, solved) = timed(&mut outer, || 0);
        assert!(
            solved > STEPS / config.timing.substeps as usize / 2,
            "{solved}"
        );
    }

    #[test]
    fn an_interrupt_in_some_of_the_steps_does_not_make_a_test_too_long() {
        for substeps in [1, 20, 60, 400] {
            let mut outer = outer::<1>(Method::Paper, substeps);
            assert_eq!(rehearse(&mut outer, now), 100, "{substeps} substeps");
            assert_eq!(outer.mode(), Mode::Idle);
        }
    }
}
