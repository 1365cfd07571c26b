//! Where the cycles of a control step go with a method of compensation: the most expensive step of a test, by the model of the
//! board's core and flash.
//!
//!     cargo run -p host-tests --release --bin step-cycles -- paper+afp --storeys 3

use clap::Parser;
use comfy_table::{Table, presets};
use host_tests::qemu::cycles::{Code, Course};
use host_tests::qemu::image::image;
use host_tests::qemu::most_expensive::{most_expensive, most_expensive_watched};
use host_tests::qemu::spent::{Grain, Share, places};
use outerloop_core::Method;
use outerloop_core::watch::Actions;
use std::error::Error;
use std::path::Path;

/// Cycles of the most expensive step, by function and by line of core.
#[derive(Parser)]
struct Arguments {
    /// Method of compensation, as in a test file.
    #[arg(value_parser = method)]
    method: Method,
    /// Storeys, of which the lowest stands in the laboratory.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=3))]
    storeys: u8,
    /// With the rig watch, and an actuator at each storey.
    #[arg(long)]
    watched: bool,
    /// Rows of each table.
    #[arg(long, default_value_t = 25)]
    rows: usize,
}

fn method(name: &str) -> Result<Method, String> {
    Method::from_name(name).ok_or_else(|| format!("no method has the name {name}"))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let image = image("qemu", "qemu").ok_or("the image cannot be built or run here")?;
    let code = Code::new(&std::fs::read(&image)?)?;
    let method = arguments.method;
    let watched = arguments.watched.then(Actions::default);
    let course = match arguments.storeys {
        1 if watched.is_some() => most_expensive_watched::<1>(&image, &code, method, watched)?,
        2 if watched.is_some() => most_expensive_watched::<2>(&image, &code, method, watched)?,
        _ if watched.is_some() => most_expensive_watched::<3>(&image, &code, method, watched)?,
        1 => most_expensive::<1>(&image, &code, method)?,
        2 => most_expensive::<2>(&image, &code, method)?,
        _ => most_expensive::<3>(&image, &code, method)?,
    };
    let cost = course.cost;
    println!(
        "{method}: {} instructions, {} cycles, {} of them waiting for the flash",
        cost.instructions,
        cost.cycles,
        cost.cycles - cost.without_waiting
    );
    for (title, grain) in [("function", Grain::Function), ("line", Grain::Line)] {
        print(title, &image, &course, grain, arguments.rows)?;
    }
    Ok(())
}

fn print(
    title: &str,
    image: &Path,
    course: &Course,
    grain: Grain,
    rows: usize,
) -> Result<(), Box<dyn Error>> {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN);
    table.set_header([title, "cycles", "waiting", "instructions"]);
    for (place, share) in places(image, course, grain)?.into_iter().take(rows) {
        let Share {
            instructions,
            cycles,
            waited,
        } = share;
        table.add_row([
            place,
            cycles.to_string(),
            waited.to_string(),
            instructions.to_string(),
        ]);
    }
    println!("\n{table}");
    Ok(())
}
