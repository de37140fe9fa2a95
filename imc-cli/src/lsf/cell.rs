//! Cells of CSV (RFC 4180) that spreadsheets take for what they are.

use imc::Text;
use std::fmt::Write as _;

/// How cells are written.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct Style {
    /// Angles in degrees instead of radians
    #[arg(long)]
    pub(crate) degrees: bool,
    /// Names of values, such as MANEUVER or PATH|SPEED, instead of their numbers
    #[arg(long)]
    pub(crate) labels: bool,
    /// Leave text that looks like a formula as it is
    #[arg(long)]
    pub(crate) raw_text: bool,
}

/// One line of cells.
#[derive(Debug, Default)]
pub(crate) struct Row {
    text: String,
    cells: usize,
}

impl Row {
    /// Appends an empty cell.
    pub(crate) fn empty(&mut self) {
        self.start();
    }

    /// Appends something that needs no care: numbers and names of the catalogue.
    pub(crate) fn plain(&mut self, value: impl std::fmt::Display) {
        self.start();
        write!(self.text, "{value}").ok();
    }

    /// Appends a double; NaN is an empty cell.
    pub(crate) fn double(&mut self, value: f64) {
        match value.abs() {
            _ if value.is_nan() => self.empty(),
            0.0 | 1e-5..1e17 => self.plain(value),
            _ if value.is_infinite() => self.plain(value),
            _ => self.plain(format_args!("{value:e}")),
        }
    }

    /// Appends a single, as short as it is; NaN is an empty cell.
    pub(crate) fn single(&mut self, value: f32) {
        match value.abs() {
            _ if value.is_nan() => self.empty(),
            0.0 | 1e-5..1e17 => self.plain(value),
            _ if value.is_infinite() => self.plain(value),
            _ => self.plain(format_args!("{value:e}")),
        }
    }

    /// Appends text from outside. A spreadsheet runs what starts with `=`, `+`, `-` or `@` as a formula, so
    /// such text gets a `'` in front unless it is wanted raw.
    pub(crate) fn text(&mut self, text: &str, style: Style) {
        self.start();
        let mark =
            if !style.raw_text && text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
        if text.contains(['"', ',', '\n', '\r']) {
            write!(self.text, "\"{mark}{}\"", text.replace('"', "\"\"")).ok();
        } else {
            write!(self.text, "{mark}{text}").ok();
        }
    }

    /// Appends text as it travels.
    pub(crate) fn wire_text(&mut self, text: &[u8], style: Style) {
        self.text(&Text::from_bytes(text).to_str_lossy(), style);
    }

    /// The line, with its end.
    pub(crate) fn finish(&mut self) -> &str {
        self.text.push('\n');
        &self.text
    }

    /// Begins the next line.
    pub(crate) fn clear(&mut self) {
        self.text.clear();
        self.cells = 0;
    }

    fn start(&mut self) {
        if self.cells > 0 {
            self.text.push(',');
        }
        self.cells += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_and_marks_what_spreadsheets_would_misread() {
        let style = |raw_text| Style { degrees: false, labels: false, raw_text };
        let mut row = Row::default();
        for text in ["plain", "a,b", "say \"hi\"", "=1+1", "-x", "@y", "+z,1"] {
            row.text(text, style(false));
        }
        row.text("=1+1", style(true));
        row.double(f64::NAN);
        row.double(-0.5);
        row.single(0.1);
        row.single(6.6e-8);
        row.double(f64::NEG_INFINITY);
        row.double(1.5e300);
        row.plain(7);
        let expected =
            "plain,\"a,b\",\"say \"\"hi\"\"\",'=1+1,'-x,'@y,\"'+z,1\",=1+1,,-0.5,0.1,6.6e-8,-inf,1.5e300,7\n";
        assert_eq!(row.finish(), expected);
    }
}
