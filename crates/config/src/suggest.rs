//! "Did you mean": the known name nearest to a misspelt one.

/// The longest name compared; longer ones are no slips of the pen.
const MAX_CHARS: usize = 80;

/// The candidate nearest to `name`, if any is near enough to have been meant.
pub(crate) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = folded(name);
    let allowed = (plain.len() / 4).clamp(1, 4);
    candidates
        .map(|candidate| (distance(&plain, &folded(candidate)), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate)
}

/// Small letters without blanks, so that case and spacing do not count.
fn folded(name: &str) -> String {
    name.chars().filter(|letter| !matches!(letter, ' ' | '_' | '-')).flat_map(char::to_lowercase).collect()
}

/// How many letters must be exchanged, added, taken out or swapped with the next (optimal string alignment).
pub(crate) fn distance(left: &str, right: &str) -> usize {
    let (left, right): (Vec<char>, Vec<char>) = (left.chars().collect(), right.chars().collect());
    if left.len().max(right.len()) > MAX_CHARS {
        return usize::MAX;
    }
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=right.len()).collect();
    for (row, letter) in left.iter().enumerate() {
        let mut current = vec![row + 1];
        for (column, other) in right.iter().enumerate() {
            let exchanged = above[column] + usize::from(letter != other);
            let mut best = exchanged.min(above[column + 1] + 1).min(current[column] + 1);
            let swapped = row > 0 && column > 0 && *letter == right[column - 1] && left[row - 1] == *other;
            if swapped {
                best = best.min(before[column - 1] + 1);
            }
            current.push(best);
        }
        before = std::mem::replace(&mut above, current);
    }
    above[right.len()]
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
    fn counts_the_least_edits() {
        for (left, right, edits) in [("", "", 0), ("abc", "abc", 0), ("abc", "acb", 1), ("abc", "", 3)] {
            assert_eq!(distance(left, right), edits, "{left} {right}");
        }
        assert_eq!(distance(&"x".repeat(100), ""), usize::MAX);
    }
}
