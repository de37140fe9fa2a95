//! `SUMMARY.md`, mdBook's list of contents: parts as headings, chapters as links.

/// A chapter as the contents name it.
pub(crate) struct Entry {
    pub(crate) title: String,
    pub(crate) file: String,
    /// The part of the book that begins here; empty for none.
    pub(crate) part: String,
}

impl Entry {
    /// Its name in addresses.
    pub(crate) fn name(&self) -> String {
        self.file.trim_end_matches(".md").to_owned()
    }
}

/// The chapters of a summary, and the lines that are not understood.
pub(crate) fn read(text: &str) -> (Vec<Entry>, Vec<String>) {
    let (mut entries, mut wrong) = (Vec::new(), Vec::new());
    let mut part = String::new();
    for (number, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line == "# Summary" {
            continue;
        }
        if let Some(title) = line.strip_prefix("# ") {
            title.trim().clone_into(&mut part);
            continue;
        }
        match entry(line) {
            Some((title, file)) => entries.push(Entry { title, file, part: std::mem::take(&mut part) }),
            None => wrong.push(format!(
                "SUMMARY.md, line {}: neither `# Part` nor `- [Title](file.md)`: {line}",
                number + 1
            )),
        }
    }
    (entries, wrong)
}

/// Chapters stand in the folder itself and in no chapter: addresses have one name.
fn entry(line: &str) -> Option<(String, String)> {
    let link = line.strip_prefix("- ").unwrap_or(line);
    let (title, file) = link.strip_prefix('[')?.strip_suffix(')')?.split_once("](")?;
    let is_name = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
    let fits = file.strip_suffix(".md").is_some_and(|name| !name.is_empty() && name.chars().all(is_name));
    fits.then(|| (title.to_owned(), file.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_not_understood_is_named_with_its_number() {
        let (entries, wrong) = read("# Summary\n\n- [A](a.md)\n  - [B](b.md)\n- [C](../c.md)\nwords\n");
        assert_eq!(entries.len(), 1);
        assert_eq!(wrong.len(), 3);
        assert!(wrong[0].contains("line 4"), "{wrong:?}");
    }
}
