//! Cycles of a step on the board, by a model of its core and its flash, against the deadline.

use host_tests::qemu::cycles::Code;
use host_tests::qemu::dearest::dearest;
use host_tests::qemu::image::image;
use outerloop_core::{Method, Prediction};

/// From the sample to the command, 25 us at 168 MHz.
const DEADLINE: u64 = 4200;

/// What three storeys should take at most with any named method, and one storey with the default one.
const AIM: u64 = 3400;
const AIM_DEFAULT: u64 = 1500;

#[test]
fn cycles_of_a_step_with_every_method() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let code = Code::new(&std::fs::read(&image).unwrap()).unwrap();
    println!(
        "worst step, one storey in the laboratory   1 storey             2 storeys            3 storeys"
    );
    println!("instructions, cycles without waiting, cycles from the flash at 168 MHz");
    let (mut too_long, mut beyond_aim) = (Vec::new(), Vec::new());
    let behind = Prediction::ALL[1..]
        .iter()
        .map(|&p| Method::Paper.behind(p));
    for method in Method::ALL.into_iter().chain(behind) {
        let costs = [
            dearest::<1>(&image, &code, method),
            dearest::<2>(&image, &code, method),
            dearest::<3>(&image, &code, method),
        ]
        .map(|course| course.unwrap().cost);
        print!("{:28}", method.name());
        for c in costs {
            print!(
                "  {:5} {:5} {:5}",
                c.instructions, c.without_waiting, c.cycles
            );
        }
        let late = costs.iter().any(|c| c.cycles > DEADLINE);
        println!(
            "{}",
            if late {
                "  later than the deadline"
            } else {
                ""
            }
        );
        if late {
            too_long.push(method.name());
        }
        if method == Method::Paper {
            assert!(costs[0].cycles <= AIM_DEFAULT, "{} cycles", costs[0].cycles);
        }
        if costs[2].cycles > AIM && Method::ALL.contains(&method) {
            beyond_aim.push(method.name());
        }
    }
    // A board refuses at `Configure` what it has timed as too long.
    assert!(too_long.is_empty(), "more than {DEADLINE}: {too_long:?}");
    assert!(beyond_aim.is_empty(), "more than {AIM}: {beyond_aim:?}");
}
