//! Static checks of the flashed images: size, stack, and what the control interrupt can reach.

use host_tests::call_graph::CallGraph;
use host_tests::qemu::image::{image, on_target};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};
use outerloop_core::Method;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The images, the interrupt of each one's control period (with the chip's own converters, and with external ones), and the
/// flash that it may take.
const IMAGES: [(&str, &str, u64); 3] = [
    ("nucleo_f429zi", "ADC", MOST_FLASH),
    ("nucleo_f429zi_16", "TIM2", MOST_FLASH),
    ("nucleo_f429zi_3", "TIM2", MOST_FLASH + COUPLED_FLASH),
];

/// The flashed images, each with its control interrupt and its flash limit; none if there is no compiler for them. One that the
/// environment names, as for the emulated rig, replaces that of this tree: `scripts/mutants --images`.
fn images() -> impl Iterator<Item = (Vec<u8>, &'static str, u64)> {
    IMAGES.into_iter().filter_map(|(name, interrupt, flash)| {
        let coupled = if flash > MOST_FLASH { ",coupled" } else { "" };
        let named = std::env::var_os(name.replace("nucleo_f429zi", "OUTERLOOP_IMAGE"));
        let features = format!("nucleo-f429zi,winning-methods{coupled}");
        let _alone = alone();
        let path = named.map_or_else(|| image(name, &features), |path| Some(path.into()))?;
        println!("{name}, {}:", path.display());
        Some((std::fs::read(path).unwrap(), interrupt, flash))
    })
}

/// Held from building an image to reading it, since the test for the board builds the same files with other features.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Little more than a third of the flash's first bank (1024 KiB), which runs while the second is written. Most of it is three
/// sizes of loop with each method, each with its design in double precision. The rig watch takes some 64 KiB: its regressions
/// are unrolled for their sizes, and its instructions are processed in software double precision. Methods that are nowhere
/// the best are left out.
const MOST_FLASH: u64 = 384 * 1024;

/// The loop for two coupled actuators, which the image for three has in addition to those of 1 to 3 storeys: some 42 KiB,
/// mostly its step and its design.
const COUPLED_FLASH: u64 = 44 * 1024;

#[test]
fn sizes() {
    images().for_each(|(bytes, _, most)| {
        let [flash, ram] = flash_and_ram(&bytes);
        println!(
            "flash {:.1} KiB, RAM {:.1} KiB without the stack",
            kib(flash),
            kib(ram)
        );
        assert!(flash <= most, "{flash} of {most}");
    });
}

fn kib(bytes: u64) -> f64 {
    bytes as f64 / 1024.0
}

fn flash_and_ram(bytes: &[u8]) -> [u64; 2] {
    let file = object::File::parse(bytes).unwrap();
    let (mut flash, mut ram) = (0, 0);
    for section in file.sections() {
        match section.kind() {
            // Constants that include texts are a section kind of their own.
            SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::ReadOnlyString => {
                flash += section.size();
            }
            // Initialised variables are in both.
            SectionKind::Data => (flash, ram) = (flash + section.size(), ram + section.size()),
            SectionKind::UninitializedData => ram += section.size(),
            _ => {}
        }
    }
    [flash, ram]
}

/// How far a size in a document may be off, KiB: another release of the compiler makes other code.
const SIZE_OFF_KIB: f64 = 2.0;

/// A document in one line, up to `end` behind the first `begin`.
fn said(document: &str, begin: &str, end: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(document);
    let text = std::fs::read_to_string(path).unwrap();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let behind = line
        .split_once(begin)
        .and_then(|(_, behind)| behind.split_once(end));
    let (between, _) =
        behind.unwrap_or_else(|| panic!("{document} no longer says `{begin}`...`{end}`"));
    between.to_owned()
}

#[test]
fn the_documents_have_the_sizes_of_the_images() {
    let images: Vec<f64> = images()
        .map(|(bytes, ..)| kib(flash_and_ram(&bytes)[0]))
        .collect();
    let [internal, external, three] = images[..] else {
        return;
    };
    for (document, begin, end, takes_kib) in [
        (
            "README.md",
            "An image takes ",
            " KiB of flash",
            &[internal, three][..],
        ),
        (
            "docs/validation.md",
            "| size of the image | ",
            ";",
            &[internal, three],
        ),
        (
            "docs/firmware.md",
            "| flash, 12 bits / 16 bits / three actuators | ",
            " KiB",
            &images,
        ),
    ] {
        let said = said(document, begin, end);
        let numbers = said.split(' ').filter_map(|word| word.parse().ok());
        let numbers: Vec<f64> = numbers.collect();
        let off = |(said, takes): (&f64, &f64)| (said - takes).abs() > SIZE_OFF_KIB;
        let drifted = numbers.len() != takes_kib.len() || numbers.iter().zip(takes_kib).any(off);
        assert!(
            !drifted,
            "{document} says `{begin}{said}{end}`, and the images take {takes_kib:.0?} KiB: correct the page"
        );
    }
    println!("{internal:.1} {external:.1} {three:.1} KiB, as the documents say");
}

/// An image has a sentence of refusal for each method that it lacks.
#[test]
fn the_readme_lists_the_methods_that_are_in_the_images() {
    let listed = said("README.md", "of flash and has the methods `", "`. [Others]");
    let mut listed: Vec<&str> = listed.split('`').step_by(2).collect();
    listed.sort_unstable();
    for (bytes, ..) in images() {
        let lacks = |name: &str| {
            let sentence = format!(": {name} needs the cargo feature");
            bytes
                .windows(sentence.len())
                .any(|part| part == sentence.as_bytes())
        };
        let built = Method::ALL.iter().map(|method| method.name());
        let mut built: Vec<&str> = built.filter(|name| !lacks(name)).collect();
        built.sort_unstable();
        assert!(
            listed == built,
            "README.md lists {listed:?}, and an image has {built:?}: correct the list"
        );
    }
}

/// Then nothing in the tasks can delay the control interrupt, and it is computed in single precision.
#[test]
fn the_control_interrupt_calls_no_log_no_critical_section_and_no_double_precision() {
    images().for_each(|(bytes, interrupt, _)| calls(&bytes, interrupt));
}

fn calls(bytes: &[u8], interrupt: &str) {
    let graph = CallGraph::new(bytes).unwrap();
    let reach = graph.reach(interrupt, "rust_begin_unwind").unwrap();
    let with = |part: &str| -> Vec<&String> {
        reach
            .functions
            .iter()
            .filter(|f| f.contains(part))
            .collect()
    };
    assert_eq!(reach.unknown, [0; 0], "calls through registers");
    for absent in [
        "defmt",
        "critical_section",
        "embassy",
        "__aeabi_d",
        "__aeabi_f2d",
    ] {
        assert_eq!(with(absent), [""; 0]);
    }
    assert!(!with("OuterLoop").is_empty(), "the loop is in it");
    // The queues' length is a variable to heapless, which divides by it; it is not zero.
    let panics = with("panicking");
    assert!(
        panics
            .iter()
            .all(|p| p.contains("panic_fmt") || p.contains("panic_const_rem_by_zero")),
        "{panics:?}"
    );
    println!("{} functions", reach.functions.len());

    // The search finds them where they are used.
    let tasks = graph.reach("main", "rust_begin_unwind").unwrap().functions;
    for present in ["defmt", "critical_section", "__aeabi_d"] {
        assert!(tasks.iter().any(|f| f.contains(present)), "{present}");
    }
}

/// One stack serves the start, the tasks and the interrupts; at worst a background interrupt and the control interrupt are on
/// top of the deepest task. Calls through registers are few and known: the executor's to its tasks, which are added here, and
/// those of formatting, which only a panic reaches.
#[test]
fn the_stack_is_deep_enough() {
    images().for_each(|(bytes, interrupt, _)| depth(&bytes, interrupt));
}

fn depth(bytes: &[u8], interrupt: &str) {
    let graph = CallGraph::new(bytes).unwrap();
    let stack = |name: &str| {
        let found = graph.stack(name, &["rust_begin_unwind", "drill"]);
        let (depth, way) = found.unwrap();
        println!("{depth} bytes: {way:?}");
        depth
    };
    let deepest = |part: &str| graph.names(part).map(stack).max().unwrap();
    let start = stack("main");
    // The start ends in the executor, which does not return, and the tasks are on top of both.
    let tasks =
        graph.frames("cortex_m_rt_main") + graph.frames("Executor") + deepest("TaskStorage");
    let interrupts = ["TIM3", "USART3", "DMA1_STREAM1", "DMA1_STREAM3", "FLASH"];
    let background = interrupts.map(stack).into_iter().max().unwrap();
    let control = stack(interrupt);
    // Registers pushed by an exception, including the floating-point ones.
    let frame = 104 + 4;
    let worst = start.max(tasks) + frame + background + frame + control;
    let file = object::File::parse(bytes).unwrap();
    let address = |name: &str| {
        let symbol = file.symbols().find(|s| s.name() == Ok(name)).unwrap();
        symbol.address() as u32
    };
    let room = address("_stack_start") - address("_stack_end");
    println!("stack: {worst} of {room} bytes at worst");
    assert!(worst + 1024 <= room, "{worst} of {room}");
    let (largest, which) = graph.largest_frame();
    println!("largest frame: {largest} bytes: {which}");
    // No frame can skip the protected 32 KiB below the stack: `stack_guard`.
    assert!(largest < 16 * 1024, "{largest}: {which}");
}

/// On every fatal path PERMIT is low before the reason is formatted: four instructions that read no memory and call nothing
/// precede the first call. In a panic they come once more, with interrupts masked.
#[test]
fn permit_drops_before_anything_is_called_on_every_way_out() {
    images().for_each(|(bytes, _, _)| ways_out(&bytes));
}

fn ways_out(bytes: &[u8]) {
    let graph = CallGraph::new(bytes).unwrap();
    // As assembled: movw r1, #0x1018; movt r1, #0x4002; mov.w r2, #0x2000000; str r2, [r1].
    let drop_permit = [
        0x41, 0xf2, 0x18, 0x01, 0xc4, 0xf2, 0x02, 0x01, 0x4f, 0xf0, 0x00, 0x72, 0x0a, 0x60,
    ];
    for way_out in [
        "HardFault",
        "__cortex_m_rt_NonMaskableInt",
        "PVD",
        "rust_begin_unwind",
    ] {
        let before = graph.before_first_call(way_out).unwrap();
        let drops = before.windows(drop_permit.len()).any(|w| w == drop_permit);
        assert!(drops, "{way_out}: {before:02x?}");
    }
    let first = graph.before_first_call("HardFault").unwrap();
    assert!(first.starts_with(&drop_permit), "{first:02x?}");
    // The control interrupt comes between the instructions of a panic alone, and a step of it may have raised PERMIT again.
    let panic = graph.before_first_call("rust_begin_unwind").unwrap();
    let mask = [0x72, 0xb6]; // cpsid i
    let masked = panic.windows(2).position(|w| w == mask);
    let after = masked
        .map(|at| &panic[at..])
        .expect("interrupts are masked");
    let drops = after.windows(drop_permit.len()).any(|w| w == drop_permit);
    assert!(drops, "not dropped again: {panic:02x?}");
}

#[test]
fn the_test_on_the_board_builds() {
    let _alone = alone();
    let Some(built) = on_target() else {
        return;
    };
    built.unwrap();
}
