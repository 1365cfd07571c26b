//! The lower end of the memory: every access that leaves it, even in part, is a fault, and one that just stays inside is none.
//! Otherwise a stack overflow on the emulated chip goes unnoticed.

use emu::Wire;
use emu::nucleo::{Nucleo, RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ};
use rigless::emulator::{Driver, Host, Stop};
use rigless::image::Image;
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

const FLASH: u64 = 0x0800_0000;
const MEMORY: i64 = 0x2000_0000;

/// Where the program stores its outcome.
const NOTE: u64 = 0x2000_1000;
const PASSED: u64 = 1;
const FAULTED: u64 = 2;

/// Halfwords of an instruction, and the bytes that it accesses, from the stack pointer: first, and end (exclusive).
struct Case {
    name: &'static str,
    code: [u16; 2],
    touches: [i64; 2],
}

const NOP: u16 = 0xbf00;

const fn case(name: &'static str, code: [u16; 2], touches: [i64; 2]) -> Case {
    Case {
        name,
        code,
        touches,
    }
}

const CASES: [Case; 16] = [
    case("push {r4-r7, lr}", [0xb5f0, NOP], [-20, 0]),
    case("stmdb sp!, {r4-r11}", [0xe92d, 0x0ff0], [-32, 0]),
    case("strd r0, r1, [sp, #4]", [0xe9cd, 0x0101], [4, 12]),
    case("str r0, [sp, #4]", [0x9001, NOP], [4, 8]),
    case("str r0, [sp, #-4]!", [0xf84d, 0x0d04], [-4, 0]),
    case("strb r0, [sp, #3]", [0xf88d, 0x0003], [3, 4]),
    case("strh r0, [sp, #2]", [0xf8ad, 0x0002], [2, 4]),
    case("vpush {d8}", [0xed2d, 0x8b02], [-8, 0]),
    case("vpush {s16}", [0xed2d, 0x8a01], [-4, 0]),
    case("vstr d8, [sp]", [0xed8d, 0x8b00], [0, 8]),
    case("ldr r0, [sp]", [0x9800, NOP], [0, 4]),
    case("ldrd r0, r1, [sp]", [0xe9dd, 0x0100], [0, 8]),
    case("ldrb r0, [sp]", [0xf89d, 0x0000], [0, 1]),
    case("pop {r4, r5}", [0xbc30, NOP], [0, 8]),
    case("vldr d8, [sp]", [0xed9d, 0x8b00], [0, 8]),
    // Exception entry pushes eight registers.
    case("svc 0", [0xdf00, NOP], [-32, 0]),
];

/// A program that executes one instruction with a stack pointer and stores whether it passed.
fn program(stack_pointer: u32, code: [u16; 2]) -> Vec<u8> {
    // The vectors, of which reset, HardFault and SVCall have a handler.
    const START: usize = 16 * 4;
    const PASSES: usize = START + 13 * 2;
    const FAULTS: usize = PASSES + 2 * 2;
    let mut words = [0_u32; 16];
    words[0] = stack_pointer;
    for (exception, handler) in [(1, START), (3, FAULTS), (11, PASSES)] {
        words[exception] = FLASH as u32 + handler as u32 + 1;
    }
    let begin = [
        0xf64e, 0x5088, // movw r0, #0xed88: the coprocessors' access control
        0xf2ce, 0x0000, // movt r0, #0xe000
        0xf44f, 0x0170, // mov r1, #0xf00000: the floating-point unit is on
        0x6001, // str r1, [r0]
        0xf3bf, 0x8f4f, // dsb
        0xf3bf, 0x8f6f, // isb
    ];
    let passes = [
        0x2501, // movs r5, #1
        0xe000, // b past the next
    ];
    let faults = [
        0x2502, // movs r5, #2
    ];
    let end = [
        0xf241, 0x0400, // movw r4, #0x1000
        0xf2c2, 0x0400, // movt r4, #0x2000
        0x6025, // str r5, [r4]
        0xe7fe, // b here
    ];
    let vectors = words.iter().flat_map(|word| word.to_le_bytes());
    let halves = begin.into_iter().chain(code).chain(passes).chain(faults);
    let halves = halves.chain(end).flat_map(|half: u16| half.to_le_bytes());
    vectors.chain(halves).collect()
}

/// Reads the outcome after a while.
struct Reader {
    note: Arc<AtomicU64>,
}

impl Driver<Nucleo> for Reader {
    fn on_stop(
        &mut self,
        _: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let enough = VirtualNanos(10_000);
        if stop.at < enough {
            return Some(enough);
        }
        let noted = host.read(NOTE, Width::W32).expect("memory");
        self.note.store(noted, SeqCst);
        None
    }
}

fn outcome(stack_pointer: i64, case: &Case) -> u64 {
    let bytes = program(stack_pointer as u32, case.code);
    let image = Image::new(Path::new("edge"), bytes, Some(FLASH)).unwrap();
    let board = Nucleo::new(RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ, Wire::default()).unwrap();
    let note = Arc::new(AtomicU64::new(0));
    let reader = Reader {
        note: Arc::clone(&note),
    };
    emu::run(board, &[image], reader).unwrap();
    note.load(SeqCst)
}

#[test]
fn what_leaves_the_memory_is_a_fault_and_what_does_not_is_none() {
    for case in &CASES {
        let [first, behind] = case.touches;
        // From wholly below to wholly inside, in the stack pointer's steps of 4.
        let (mut faults, mut passes) = (0, 0);
        for place in (-behind - 8..=-first + 8).filter(|place| place % 4 == 0) {
            let leaves = place + first < 0;
            let expected = if leaves { FAULTED } else { PASSED };
            let sp = MEMORY + place;
            assert_eq!(outcome(sp, case), expected, "{} at {sp:#x}", case.name);
            (faults, passes) = (faults + i32::from(leaves), passes + i32::from(!leaves));
        }
        assert!(faults >= 2 && passes >= 2, "{}", case.name);
    }
}
