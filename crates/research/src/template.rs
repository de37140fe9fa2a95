//! A template of a file of entries, with an example, for people who make one.

use crate::csv::header;
use crate::fields::columns;
use api::RegisterKind;

/// The header of a file, and its columns with what they mean.
pub fn template(kind: RegisterKind) -> (String, Vec<(&'static str, &'static str)>) {
    (header(kind), columns(kind).iter().map(|column| (column.name, column.about)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::{KINDS, kind_word};

    #[test]
    fn the_documentation_has_the_header_of_every_table() {
        let text = std::fs::read_to_string(testkit::repository().join("docs/detections.md")).unwrap();
        for kind in KINDS {
            let wanted = format!("`{}`:\n\n```\n{}```\n", kind_word(kind), template(kind).0);
            assert!(text.contains(&wanted), "docs/detections.md lacks\n{wanted}");
        }
        for format in crate::FORMATS {
            assert!(text.contains(&format!("`{}`", format.name)), "docs/detections.md lacks {}", format.name);
        }
    }
}
