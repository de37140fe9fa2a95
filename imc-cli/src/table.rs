//! Text in columns.

use crate::style::Paint;

/// Rows under headings; columns are as wide as their widest cell.
#[derive(Debug)]
pub(crate) struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

#[derive(Debug)]
struct Column {
    heading: &'static str,
    right: bool,
}

impl Table {
    /// Without rows. A heading that starts with `>` is of a column of numbers, set to the right.
    pub(crate) fn new(headings: &[&'static str]) -> Self {
        let column = |heading: &&'static str| match heading.strip_prefix('>') {
            Some(heading) => Column { heading, right: true },
            None => Column { heading, right: false },
        };
        Self { columns: headings.iter().map(column).collect(), rows: Vec::new() }
    }

    /// Appends a row; missing cells are empty.
    pub(crate) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The table, `indent` spaces from the left. Columns without any text are left out.
    pub(crate) fn render(&self, indent: usize, paint: Paint) -> String {
        let cell = |row: &Vec<String>, at: usize| row.get(at).cloned().unwrap_or_default();
        let used: Vec<usize> = (0..self.columns.len())
            .filter(|&at| self.rows.iter().any(|row| !cell(row, at).is_empty()))
            .collect();
        let width = |at: usize| {
            let cells = self.rows.iter().map(|row| cell(row, at).chars().count());
            cells.chain([self.columns[at].heading.chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut out = String::new();
        let mut line = |text: &dyn Fn(usize) -> String, style: &dyn Fn(&str) -> String| {
            out.push_str(&" ".repeat(indent));
            for (place, &at) in used.iter().enumerate() {
                let last = place + 1 == used.len();
                out.push_str(&self.columns[at].padded(&text(at), widths[at], last, style));
                out.push_str(if last { "" } else { "  " });
            }
            out.push('\n');
        };
        line(&|at| self.columns[at].heading.to_owned(), &|text| paint.heading(text));
        for row in &self.rows {
            line(&|at| cell(row, at), &str::to_owned);
        }
        out
    }
}

impl Column {
    fn padded(&self, text: &str, width: usize, last: bool, style: &dyn Fn(&str) -> String) -> String {
        let space = " ".repeat(width - text.chars().count());
        match (self.right, last) {
            (true, _) => space + &style(text),
            (false, true) => style(text),
            (false, false) => style(text) + &space,
        }
    }
}
