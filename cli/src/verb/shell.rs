//! `outerloop completions` and `outerloop man`, both generated from the command line.

use experiment::failure::Failure;
use experiment::files::plain;
use std::io::Write;

/// Print a shell's completion script for `outerloop`
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
    pub fn run(&self, mut command: clap::Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut command, "outerloop", &mut text);
        print(&text)
    }
}

/// Print the man page
#[derive(clap::Args, Debug)]
pub struct ManPage;

impl ManPage {
    /// Prints it: the program, then each verb and its own verbs, such as `board identify`.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn run(&self, mut command: clap::Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        let cannot = |e: std::io::Error| Failure::input(format!("the man page: {e}"));
        command.build();
        let page = clap_mangen::Man::new(command.clone());
        page.render(&mut text).map_err(cannot)?;
        // The generator refers to each verb as a page of its own; here it is a section.
        let mut text = own_sections(&command, &String::from_utf8_lossy(&text)).into_bytes();
        verbs(&command, "outerloop", &mut text).map_err(cannot)?;
        print(&text)
    }
}

/// The page with `outerloop run` instead of the page `outerloop-run(1)`, and likewise for each verb.
fn own_sections(command: &clap::Command, page: &str) -> String {
    let verbs = command.get_subcommands().map(clap::Command::get_name);
    verbs.fold(page.to_owned(), |page, verb| {
        let verb = verb.replace('-', "\\-");
        page.replace(
            &format!("outerloop\\-{verb}(1)"),
            &format!("outerloop {verb}"),
        )
    })
}

/// A section for each verb of `command`, and for each verb below it.
fn verbs(command: &clap::Command, name: &str, text: &mut Vec<u8>) -> std::io::Result<()> {
    for verb in command.get_subcommands().filter(|v| v.get_name() != "help") {
        let name = format!("{name} {}", verb.get_name());
        writeln!(text, ".SH \"{}\"", name.to_uppercase())?;
        let page = clap_mangen::Man::new(verb.clone());
        let mut parts = Vec::new();
        page.render_synopsis_section(&mut parts)?;
        page.render_description_section(&mut parts)?;
        page.render_options_section(&mut parts)?;
        // These would be sections of a separate page; here they are subsections.
        let parts = String::from_utf8_lossy(&parts).replace(".SH ", ".SS ");
        text.write_all(parts.as_bytes())?;
        verbs(verb, &name, text)?;
    }
    Ok(())
}

fn print(text: &[u8]) -> Result<(), Failure> {
    std::io::stdout().write_all(text).map_err(|e| {
        Failure::input(format!(
            "standard output cannot be written: {}",
            plain::reason(&e)
        ))
    })
}
