//! `outerloop completions` and `outerloop man`: what a shell and `man` know of the command line, made from it.

use crate::failure::Failure;
use std::io::Write;

/// What a shell completes after `outerloop`
#[derive(clap::Args, Debug)]
pub struct Completions {
    /// bash, zsh, fish, powershell or elvish
    shell: clap_complete::Shell,
}

impl Completions {
    /// Prints them.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn go(&self, mut command: clap::Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut command, "outerloop", &mut text);
        print(&text)
    }
}

/// The man page
#[derive(clap::Args, Debug)]
pub struct Man;

impl Man {
    /// Prints it: the program, then each verb.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn go(&self, mut command: clap::Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        let cannot = |e: std::io::Error| Failure::input(format!("the man page: {e}"));
        command.build();
        let page = clap_mangen::Man::new(command.clone());
        page.render(&mut text).map_err(cannot)?;
        for verb in command.get_subcommands() {
            let name = format!("outerloop {}", verb.get_name());
            let _ = writeln!(text, ".SH \"{}\"", name.to_uppercase());
            let page = clap_mangen::Man::new(verb.clone());
            page.render_synopsis_section(&mut text).map_err(cannot)?;
            page.render_description_section(&mut text).map_err(cannot)?;
            page.render_options_section(&mut text).map_err(cannot)?;
        }
        print(&text)
    }
}

fn print(text: &[u8]) -> Result<(), Failure> {
    std::io::stdout()
        .write_all(text)
        .map_err(|e| Failure::input(format!("standard output cannot be written: {e}")))
}
