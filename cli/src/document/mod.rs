//! The result of a verb, written once: sentences, tables, plots and figures. One [`Document`] is printed on the terminal,
//! written as the page, and gives the JSON; what terminal and page can both show appears in both.
//!
//! Texts may contain `**bold**` words; text between backticks is code on the page.

mod grade;
pub mod plot;
mod scale;
pub mod table;
mod text;

pub use grade::Grade;
pub use table::{Table, table};

use crate::provenance::Provenance;
use askama::Template;
use experiment::failure::Failure;
use serde::Serialize;
use text::{html, plain, written};

/// Where a part is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    Everywhere,
    OnPage,
    OnTerminal,
}

/// A piece of an answer.
#[derive(Clone, Debug)]
enum Content {
    Heading(u8, String),
    Verdict(Grade, String),
    Paragraph(String),
    Items(Vec<String>),
    Tiles(Vec<(String, String)>),
    Table(Table),
    Figure { svg: String, caption: String },
    Pair(Vec<Content>),
    File(String),
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Document {
    title: String,
    lead: String,
    with_page: bool,
    parts: Vec<(Shown, Content)>,
    /// Name of their file, and the figures as JSON.
    figures: Option<(&'static str, String)>,
}

#[derive(Template)]
#[template(path = "page.html")]
struct Page<'a> {
    document: &'a Document,
    origin: &'a Provenance,
}

#[derive(Template)]
#[template(path = "content.html")]
struct OnPage<'a> {
    content: &'a Content,
}

impl Content {
    fn html(&self) -> String {
        written(OnPage { content: self }.render())
    }

    fn terminal(&self) -> String {
        match self {
            Self::Heading(_, text) | Self::Verdict(_, text) | Self::Paragraph(text) => plain(text),
            Self::Items(items) => {
                let lines: Vec<String> =
                    items.iter().map(|i| format!("    {}", plain(i))).collect();
                lines.join("\n")
            }
            Self::Table(table) => table.to_string(),
            Self::File(text) => text.clone(),
            Self::Tiles(_) | Self::Figure { .. } | Self::Pair(_) => String::new(),
        }
    }
}

impl Document {
    /// An empty document; `with_page`: the page is requested, so plots are drawn.
    pub fn new(title: impl Into<String>, lead: impl Into<String>, with_page: bool) -> Self {
        Self {
            title: title.into(),
            lead: lead.into(),
            with_page,
            parts: Vec::new(),
            figures: None,
        }
    }

    /// The same with the figures of the answer, which `file` will have as JSON. Their shape is the verb's schema.
    ///
    /// # Errors
    /// Figures that cannot be written as JSON.
    pub fn with_figures(
        mut self,
        file: &'static str,
        figures: &impl Serialize,
    ) -> Result<Self, Failure> {
        self.figures = Some((file, json(figures)?));
        Ok(self)
    }

    /// True if a page is requested.
    pub const fn has_page(&self) -> bool {
        self.with_page
    }

    fn push(&mut self, shown: Shown, content: Content) {
        self.parts.push((shown, content));
    }

    /// A heading, only on the page.
    pub fn heading(&mut self, text: impl Into<String>) {
        self.push(Shown::OnPage, Content::Heading(2, text.into()));
    }

    /// A heading below another one.
    pub fn subheading(&mut self, text: impl Into<String>) {
        self.push(Shown::OnPage, Content::Heading(3, text.into()));
    }

    /// The verdict in a sentence.
    pub fn verdict(&mut self, grade: impl Into<Grade>, text: impl Into<String>) {
        self.push(
            Shown::Everywhere,
            Content::Verdict(grade.into(), text.into()),
        );
    }

    /// A sentence before all others, only on the page.
    pub fn warn_first(&mut self, text: impl Into<String>) {
        let warning = Content::Verdict(Grade::Fair, text.into());
        self.parts.insert(0, (Shown::OnPage, warning));
    }

    /// A sentence.
    pub fn say(&mut self, text: impl Into<String>) {
        self.push(Shown::Everywhere, Content::Paragraph(text.into()));
    }

    /// A sentence before all others, only on the terminal.
    pub fn tell_first(&mut self, text: impl Into<String>) {
        let sentence = Content::Paragraph(text.into());
        self.parts.insert(0, (Shown::OnTerminal, sentence));
    }

    /// A sentence with more detail, only on the page.
    pub fn explain(&mut self, text: impl Into<String>) {
        self.push(Shown::OnPage, Content::Paragraph(text.into()));
    }

    /// A sentence only on the terminal.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.push(Shown::OnTerminal, Content::Paragraph(text.into()));
    }

    /// A list below the last sentence.
    pub fn items(&mut self, items: Vec<String>) {
        if !items.is_empty() {
            self.push(Shown::Everywhere, Content::Items(items));
        }
    }

    /// Figures side by side, each with its meaning; only on the page.
    pub fn tiles(&mut self, tiles: Vec<(String, String)>) {
        self.push(Shown::OnPage, Content::Tiles(tiles));
    }

    /// A table.
    pub fn table(&mut self, table: Table) {
        self.push(Shown::Everywhere, Content::Table(table));
    }

    /// What `add` adds, only on the page.
    pub fn on_page(&mut self, add: impl FnOnce(&mut Self)) {
        self.shown(Shown::OnPage, add);
    }

    /// What `add` adds, only on the terminal.
    pub fn on_terminal(&mut self, add: impl FnOnce(&mut Self)) {
        self.shown(Shown::OnTerminal, add);
    }

    fn shown(&mut self, shown: Shown, add: impl FnOnce(&mut Self)) {
        let before = self.parts.len();
        add(self);
        for (on, _) in &mut self.parts[before..] {
            *on = shown;
        }
    }

    /// A plot; drawn only if there is a page.
    pub fn figure(&mut self, caption: impl Into<String>, plot: impl FnOnce() -> String) {
        if self.with_page {
            let (svg, caption) = (plot(), caption.into());
            self.push(Shown::OnPage, Content::Figure { svg, caption });
        }
    }

    /// What `draw` adds, side by side.
    pub fn pair(&mut self, draw: impl FnOnce(&mut Self)) {
        let before = self.parts.len();
        draw(self);
        let inner = self.parts.drain(before..).map(|(_, content)| content);
        let inner = inner.collect();
        self.push(Shown::OnPage, Content::Pair(inner));
    }

    /// A file, verbatim; only on the page.
    pub fn file(&mut self, text: &str) {
        self.push(Shown::OnPage, Content::File(text.trim().to_owned()));
    }

    /// The test file at the end of a page.
    pub fn test_file(&mut self, text: &str) {
        self.heading("The test file, with what --set changed");
        self.file(text);
    }

    /// One HTML file that needs no other files.
    pub fn page(&self) -> String {
        let origin = Provenance::of_this_run();
        written(
            Page {
                document: self,
                origin,
            }
            .render(),
        )
    }

    /// Its files: the page and the figures.
    pub fn files(&self) -> Vec<(&'static str, Vec<u8>)> {
        let page = ("report.html", self.page().into_bytes());
        let figures = self
            .figures
            .iter()
            .map(|(name, text)| (*name, text.clone().into_bytes()));
        std::iter::once(page).chain(figures).collect()
    }

    /// The figures as JSON; empty if there are none.
    pub fn json(&self) -> &str {
        self.figures.as_ref().map_or("", |(_, text)| text)
    }

    /// The same in one line.
    pub fn json_line(&self) -> String {
        self.json().lines().map(str::trim_start).collect()
    }

    /// The text for a terminal: a blank line around each table, none between sentences.
    pub fn terminal(&self) -> String {
        let shown = self.parts.iter().filter(|(on, _)| *on != Shown::OnPage);
        let mut text = String::new();
        let mut after_table = false;
        for (_, content) in shown {
            let is_table = matches!(content, Content::Table(_));
            // A list below a table explains it.
            let apart = is_table || after_table && !matches!(content, Content::Items(_));
            if !text.is_empty() {
                text += if apart { "\n\n" } else { "\n" };
            }
            text += &content.terminal();
            after_table = is_table;
        }
        text
    }
}

/// The JSON of a result.
///
/// # Errors
/// A value that JSON cannot express.
pub fn json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map_err(|e| Failure::test(format!("the result cannot be written as JSON: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_once_stands_on_both() {
        let mut d = Document::new("A < B", "Lead.", true);
        d.verdict(Grade::Fair, "**paper** comes near `a<b`.");
        d.explain("Only here.");
        d.tell("Only there.");
        let mut t = table(&["name", "value"]);
        t.add_row(["a", "1 mm"]);
        d.table(t);
        d.pair(|d| d.figure("A caption.", || "<svg></svg>".into()));
        let text = d.terminal();
        assert!(
            text.starts_with("paper comes near `a<b`.\nOnly there.\n\n"),
            "{text}"
        );
        assert!(
            text.contains("1 mm") && !text.contains("Only here"),
            "{text}"
        );
        let page = d.page();
        for part in [
            "<title>A &#60; B</title>",
            "<p class=\"verdict fair\"><b>paper</b> comes near <code>a&lt;b</code>.</p>",
            "<p>Only here.</p>",
            "<td>1 mm</td>",
            "<div class=\"pair\"><figure><svg></svg><figcaption>A caption.</figcaption></figure></div>",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        assert!(!page.contains("Only there"));
    }
}
