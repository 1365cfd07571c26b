//! The PC tool with our method in it: every verb of `outerloop`, the tests on a board included, knows `kind = "own"`.

/// The boards' images are the other binaries.
#[cfg(target_os = "none")]
fn main() {}

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    if let Err(why) = lab::METHODS.register() {
        eprintln!("lab: {why}");
        return std::process::ExitCode::from(2);
    }
    outerloop_cli::program::main()
}
