//! Prints docs/proof-table.md, or what is missing in it.

use clap::Parser;
use host_tests::proof::page::Proofs;
use std::process::ExitCode;

/// Which test proves what the firmware promises.
#[derive(Parser)]
struct Arguments {
    /// Print the page; left out: print what is missing
    #[arg(long)]
    markdown: bool,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let missing = match Proofs::read() {
        Ok(proofs) if arguments.markdown => {
            print!("{}", proofs.page());
            return ExitCode::SUCCESS;
        }
        Ok(proofs) => proofs.gaps(),
        Err(wrong) => wrong,
    };
    for line in &missing {
        eprintln!("proof-table: {line}");
    }
    ExitCode::from(u8::from(!missing.is_empty()))
}
