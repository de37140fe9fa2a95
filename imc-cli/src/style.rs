//! Colour for people at a terminal.

use anstyle::{AnsiColor, Style};
use std::io;

/// Colours text, or leaves it unchanged where colour is not wanted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    on: bool,
}

impl Paint {
    /// For standard output: only on a terminal, and as NO_COLOR, CLICOLOR and TERM say.
    pub(crate) fn stdout() -> Self {
        Self { on: anstream::AutoStream::choice(&io::stdout()) != anstream::ColorChoice::Never }
    }

    /// A highlighted name.
    pub(crate) fn title(self, text: &str) -> String {
        self.paint(Style::new().bold(), text)
    }

    /// A column's heading.
    pub(crate) fn heading(self, text: &str) -> String {
        self.paint(Style::new().underline(), text)
    }

    /// Secondary text.
    pub(crate) fn aside(self, text: &str) -> String {
        self.paint(Style::new().dimmed(), text)
    }

    /// Something that needs attention.
    pub(crate) fn alert(self, text: &str) -> String {
        self.paint(AnsiColor::Red.on_default().bold(), text)
    }

    fn paint(self, style: Style, text: &str) -> String {
        if self.on { format!("{style}{text}{style:#}") } else { text.to_owned() }
    }
}

/// Text from outside for a terminal: control characters are shown, not obeyed.
pub(crate) fn plain(text: &str) -> String {
    text.chars()
        .flat_map(|char| {
            let escaped = char.is_control().then(|| char.escape_default());
            let kept = escaped.is_none().then_some(char);
            escaped.into_iter().flatten().chain(kept)
        })
        .collect()
}
