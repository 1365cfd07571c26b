//! What a fourth reading found beside the single faults: a port without its clock, a load cell that is not dead and tells no force, and
//! an input converter that is late or does not come back.

use crate::desk::{Bench, Desk};
use crate::single_faults::PHASES;
use emu::InjectedFault::PortWithoutClock;
use emu::{LoggedEvent, PlannedFault};

/// PERMIT cannot be dropped by a port that hears nothing: the watchdog has to, which lets the pins go.
#[test]
fn a_port_without_its_clock_keeps_permit_no_longer_than_the_watchdogs_time() {
    for after_steps in [PHASES[1], 300] {
        let mut desk = Desk::with(Bench {
            plan: Some(PlannedFault {
                after_steps,
                fault: PortWithoutClock,
            }),
            ..Bench::default()
        });
        desk.start();
        for _ in 0..1500 {
            desk.turn();
        }
        let log = desk.log();
        let fault_ns = log.seen.iter().find(|s| s.1 == LoggedEvent::Fault);
        let fault_ns = fault_ns.expect("it came").0;
        let since = log.seen.iter().filter(|s| s.0 >= fault_ns);
        let permit: Vec<_> = since
            .filter_map(|(at, seen)| match seen {
                LoggedEvent::Permit(high) => Some((*high, (at - fault_ns) / 1_000_000)),
                _ => None,
            })
            .collect();
        println!("{after_steps} steps: PERMIT and ms {permit:?}");
        assert!(
            matches!(permit[..], [(false, after_ms)] if after_ms <= 50),
            "{permit:?}"
        );
    }
}
