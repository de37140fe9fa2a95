//! "Did you mean": the known names nearest to a misspelt one, by one rule for configuration, command lines and the API.
//!
//! Case, blanks, `_` and `-` do not count. It knows words only.

/// The longest name compared; longer ones are not slips of the pen.
const MAX_CHARS: usize = 80;
/// Most words that [`alike`] offers.
const OFFERED: usize = 3;
/// A part of a word counts from so many characters on.
const PART_CHARS: usize = 3;

/// The word nearest to `name`, if any is near enough to have been meant.
pub fn nearest<'w>(name: &str, words: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    let allowed = allowed(name);
    let near = words.map(|word| (distance(name, word), word)).filter(|(distance, _)| *distance <= allowed);
    near.min().map(|(_, word)| word)
}

/// Up to three words that may have been meant, best first: near ones, then those that contain `text`.
pub fn alike<'w>(text: &str, words: impl Iterator<Item = &'w str>) -> Vec<&'w str> {
    let (allowed, part) = (allowed(text), folded(text));
    let is_part = |word: &str| part.chars().count() >= PART_CHARS && folded(word).contains(&part);
    let mut found: Vec<(usize, &str)> = words
        .filter_map(|word| match distance(text, word) {
            near if near <= allowed => Some((near, word)),
            _ if is_part(word) => Some((allowed + word.len(), word)),
            _ => None,
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found.into_iter().take(OFFERED).map(|(_, word)| word).collect()
}

/// How many letters must be exchanged, added, taken out or swapped with the next (optimal string alignment).
pub fn distance(left: &str, right: &str) -> usize {
    let (left, right) = (folded(left), folded(right));
    if left.chars().count().max(right.chars().count()) > MAX_CHARS {
        return usize::MAX;
    }
    strsim::osa_distance(&left, &right)
}

/// A quarter of the letters may be wrong.
fn allowed(name: &str) -> usize {
    (folded(name).chars().count() / 4).clamp(1, 4)
}

/// Small letters without blanks, so that case and spacing do not count.
fn folded(name: &str) -> String {
    name.chars().filter(|letter| !matches!(letter, ' ' | '_' | '-')).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_slips_of_the_pen() {
        let names = ["Entity Label", "Local Port", "Control Frequency"];
        for (given, meant) in [
            ("Entity Lable", Some("Entity Label")),
            ("local port", Some("Local Port")),
            ("ControlFrequency", Some("Control Frequency")),
            ("Wheel Count", None),
        ] {
            assert_eq!(nearest(given, names.into_iter()), meant, "{given}");
        }
    }

    #[test]
    fn near_words_come_before_those_that_contain_it() {
        let words = ["EstimatedState", "StateReport", "Stats", "State", "NavState"];
        assert_eq!(alike("state", words.into_iter()), ["State", "Stats", "NavState"]);
        assert_eq!(alike("Temprature", ["Temperature", "Pressure"].into_iter()), ["Temperature"]);
        assert_eq!(alike("xy", ["xyz", "EntityXy"].into_iter()), ["xyz"], "two letters are part of anything");
    }

    #[test]
    fn counts_the_least_edits() {
        for (left, right, edits) in [("", "", 0), ("abc", "abc", 0), ("abc", "acb", 1), ("abc", "", 3)] {
            assert_eq!(distance(left, right), edits, "{left} {right}");
        }
        assert_eq!(distance(&"x".repeat(100), ""), usize::MAX);
    }
}
