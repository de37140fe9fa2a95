//! The entities of a system as `EntityList` gives them: `Label=number;Label=number`.
//!
//! Numbers are assigned at start and differ between configurations: keep series by label.

use std::fmt::Write as _;

/// Suffix of a parameter's name for its value from the next start, reported beside its present one. DUNE likewise
/// reports a parameter's properties (`Active - Scope`) to a requester with visibility `developer`.
pub const SAVED_SUFFIX: &str = " - Saved";

/// Labels and numbers, in the order of the text. Pairs without a number from 0 to 255 are passed over.
pub fn parse(list: &str) -> impl Iterator<Item = (&str, u8)> {
    list.split(';').filter_map(|pair| {
        // A label may hold anything but `;`, so the number is after the last `=`.
        let (label, number) = pair.rsplit_once('=')?;
        Some((label.trim(), number.trim().parse().ok()?))
    })
}

/// The text of labels and numbers. A `;` in a label would end it, so it becomes a blank.
pub fn build<'a>(entities: impl IntoIterator<Item = (&'a str, u8)>) -> String {
    let mut list = String::new();
    for (label, number) in entities {
        let separator = if list.is_empty() { "" } else { ";" };
        write!(list, "{separator}{}={number}", label.replace(';', " ")).ok();
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_and_builds_the_list() {
        let list = "Daemon=0;Heading & Speed Controller=1;Motor - Port=48";
        let entities: Vec<(&str, u8)> = parse(list).collect();
        assert_eq!(entities, [("Daemon", 0), ("Heading & Speed Controller", 1), ("Motor - Port", 48)]);
        assert_eq!(build(entities), list);
        assert_eq!(build([("a;b", 1)]), "a b=1");
    }

    #[test]
    fn passes_over_what_is_no_entity() {
        assert_eq!(parse("a=1;b;c=x;d=256;=2;e=f=3;").collect::<Vec<_>>(), [("a", 1), ("", 2), ("e=f", 3)]);
        assert_eq!(parse("").count(), 0);
    }
}
