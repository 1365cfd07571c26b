//! The error in a command line, in one sentence: what, which value, what would be accepted.

use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use experiment::nearest::nearest;

/// The sentence; `None` for requests that are no error, such as `--help`. `verbs` are all verbs.
pub fn sentence(error: &Error, verbs: &[String]) -> Option<String> {
    let context = ErrorContext(error);
    let argument = context.text(ContextKind::InvalidArg);
    let value = context.text(ContextKind::InvalidValue);
    Some(match error.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => return None,
        ErrorKind::InvalidValue => {
            let names = context.text(ContextKind::ValidValue);
            let accepted = match names.is_empty() {
                true => "a value".to_owned(),
                false => names,
            };
            match value.is_empty() {
                true => format!("{argument} has no value: accepted are {accepted}"),
                // The nearest name is added to every refusal of a name.
                false => format!("{argument}: `{value}` is unknown: accepted are {accepted}"),
            }
        }
        ErrorKind::ValueValidation => match std::error::Error::source(error) {
            // A sentence of our own states the value, the error and what is accepted.
            Some(own) if own.to_string().starts_with('`') => format!("{argument} {own}"),
            _ => format!(
                "{argument}: `{value}` is refused: accepted are {}",
                context.accepted()
            ),
        },
        ErrorKind::UnknownArgument => format!(
            "`{argument}` is unknown here{}: accepted is {}, and `--help` explains each part",
            in_question(&context.text(ContextKind::SuggestedArg)),
            context.usage()
        ),
        ErrorKind::InvalidSubcommand => {
            let verb = context.text(ContextKind::InvalidSubcommand);
            let usage = context.usage();
            format!(
                "`{verb}` is no verb{}: accepted is {usage}, and `--help` lists the verbs",
                in_question(meant_verb(&verb, verbs, &usage)),
            )
        }
        ErrorKind::MissingRequiredArgument => {
            format!("{argument} is missing: accepted is {}", context.usage())
        }
        ErrorKind::ArgumentConflict => {
            let other = context.text(ContextKind::PriorArg);
            match other == argument || other.is_empty() {
                true => format!("{argument} is given twice: accepted is once"),
                false => format!("{argument} and {other} exclude each other: accepted is one"),
            }
        }
        _ => {
            let text = error.to_string();
            let line = text.lines().next().unwrap_or_default();
            line.trim_start_matches("error: ").to_owned()
        }
    })
}

/// The verb that may have been meant, searched first among those that continue the line, then among all: the last word of
/// each is compared.
fn meant_verb<'a>(typed: &str, verbs: &'a [String], usage: &str) -> &'a str {
    let words = usage.trim_matches('`').split(' ').skip(1);
    let before: Vec<&str> = words.take_while(|w| !w.starts_with(['[', '<'])).collect();
    let last = |verb: &'a str| verb.rsplit(' ').next().unwrap_or(verb);
    let goes_on = |verb: &&String| {
        let words: Vec<&str> = verb.split(' ').collect();
        words.len() == before.len() + 1 && words.starts_with(&before)
    };
    let (near, far): (Vec<&String>, Vec<&String>) = verbs.iter().partition(goes_on);
    let meant = [near, far].into_iter().find_map(|level| {
        let name = nearest(typed, level.iter().map(|verb| last(verb)))?;
        level.into_iter().find(|verb| last(verb) == name)
    });
    meant.map_or("", String::as_str)
}

/// A suggested name, as a question.
fn in_question(name: &str) -> String {
    match name.is_empty() {
        true => String::new(),
        false => format!(" (`{name}`?)"),
    }
}

/// The parser's error.
struct ErrorContext<'a>(&'a Error);

impl ErrorContext<'_> {
    fn text(&self, kind: ContextKind) -> String {
        match self.0.get(kind) {
            Some(ContextValue::String(text)) => text.clone(),
            Some(ContextValue::Strings(texts)) => texts.join(", "),
            Some(ContextValue::StyledStr(text)) => text.to_string(),
            _ => String::new(),
        }
    }

    /// The usage of the verb.
    fn usage(&self) -> String {
        let text = self.text(ContextKind::Usage);
        let words: Vec<&str> = text.split_whitespace().collect();
        let call = words.strip_prefix(&["Usage:"]).unwrap_or(&words).join(" ");
        match call.is_empty() {
            true => "what `outerloop --help` lists".to_owned(),
            false => format!("`{call}`"),
        }
    }

    /// The accepted values.
    fn accepted(&self) -> String {
        let why = std::error::Error::source(self.0).map(ToString::to_string);
        let why = why.unwrap_or_default();
        if let Some((low, high)) = why
            .rsplit_once(" is not in ")
            .and_then(|(_, range)| range.split_once("..="))
        {
            return format!("{low} to {high}");
        }
        match why.as_str() {
            "invalid float literal" | "cannot parse float from empty string" => "numbers".into(),
            "invalid digit found in string" | "cannot parse integer from empty string" => {
                "whole numbers from 0".into()
            }
            "number too large to fit in target type" => "smaller whole numbers".into(),
            "invalid socket address syntax" => "addresses such as 127.0.0.1:8090".into(),
            _ => format!("other values ({why})"),
        }
    }
}
