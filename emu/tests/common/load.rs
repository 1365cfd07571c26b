//! Processor load of the rig watch on an emulated board.

use link::Status;

/// Control steps in a block at 2 kHz.
const STEPS_IN_BLOCK: u8 = 4;

/// Mean and worst time to judge a block, for all actuators together and including interrupts, as a percentage of the block's
/// duration.
pub fn of_the_watch(status: &Status) -> [f64; 2] {
    let watch = status.watch.as_ref().expect("it is watched");
    let cycles = f64::from(status.timing.period_cycles) * f64::from(STEPS_IN_BLOCK);
    let shares = [watch.mean_cycles, watch.worst_cycles].map(|x| 100.0 * f64::from(x) / cycles);
    println!(
        "{} blocks; of the time of a block {:.2} % on average, {:.2} % at worst; control step {} cycles at worst; stack {} bytes",
        watch.blocks, shares[0], shares[1], status.timing.worst_step_cycles, status.stack_bytes
    );
    shares
}
