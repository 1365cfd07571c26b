//! `outerloop`: runs and judges fast pseudodynamic tests.

fn main() -> std::process::ExitCode {
    outerloop_cli::program::main()
}
