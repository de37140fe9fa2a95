//! The search: sections that have all the words that are asked for.

use crate::{Chapter, Section};

/// Words of a question that count.
const MOST_WORDS: usize = 8;
/// Sections that are given; of more, the first.
const MOST_FOUND: usize = 40;
/// Letters of an excerpt before the word that was found.
const BEFORE: usize = 50;
/// Letters of an excerpt.
const EXCERPT: usize = 180;

/// A section that has what was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found<'a> {
    /// Its chapter.
    pub chapter: &'a str,
    /// As the contents call the chapter.
    pub title: &'a str,
    /// Where a link leads to.
    pub anchor: &'a str,
    /// Its heading.
    pub heading: &'a str,
    /// Some words around the first word that was asked for; empty where only the heading has it.
    pub excerpt: String,
}

/// Sections with all words of `wanted`: first those whose heading has them, then the others in the order of the book.
pub(crate) fn search<'a>(chapters: &'a [Chapter], wanted: &str) -> Vec<Found<'a>> {
    let wanted: Vec<_> = wanted.split_whitespace().take(MOST_WORDS).map(str::to_lowercase).collect();
    let Some(first) = wanted.first() else { return Vec::new() };
    let (mut by_heading, mut by_text) = (Vec::new(), Vec::new());
    for chapter in chapters {
        for section in &chapter.sections {
            let heading = section.heading.to_lowercase();
            let text = section.text.to_lowercase();
            let has = |word: &String| heading.contains(word.as_str()) || text.contains(word.as_str());
            if wanted.iter().all(|word| heading.contains(word.as_str())) {
                by_heading.push(found(chapter, section, first));
            } else if wanted.iter().all(has) {
                by_text.push(found(chapter, section, first));
            }
        }
    }
    by_heading.extend(by_text);
    by_heading.truncate(MOST_FOUND);
    by_heading
}

fn found<'a>(chapter: &'a Chapter, section: &'a Section, word: &str) -> Found<'a> {
    let Section { anchor, heading, text, .. } = section;
    Found { chapter: &chapter.name, title: &chapter.title, anchor, heading, excerpt: excerpt(text, word) }
}

/// Some words of `text` around `word`, which is in small letters.
fn excerpt(text: &str, word: &str) -> String {
    let letters: Vec<char> = text.split_whitespace().collect::<Vec<_>>().join(" ").chars().collect();
    let small: Vec<char> =
        letters.iter().map(|letter| letter.to_lowercase().next().unwrap_or(*letter)).collect();
    let wanted: Vec<char> = word.chars().collect();
    let Some(at) = small.windows(wanted.len().max(1)).position(|part| part == wanted) else {
        return String::new();
    };
    let mut begin = at.saturating_sub(BEFORE);
    while begin > 0 && begin < at && letters[begin - 1] != ' ' {
        begin += 1;
    }
    let mut end = (begin + EXCERPT).min(letters.len());
    while end < letters.len() && end > at + wanted.len() && letters[end] != ' ' {
        end -= 1;
    }
    let words: String = letters[begin..end].iter().collect();
    format!("{}{words}{}", if begin > 0 { "… " } else { "" }, if end < letters.len() { " …" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn chapters() -> Vec<Chapter> {
        let section = |anchor: &str, heading: &str, text: &str| Section {
            anchor: anchor.to_owned(),
            level: 2,
            heading: heading.to_owned(),
            text: text.to_owned(),
        };
        let sections = vec![
            section("home", "Coming home", "When the battery is low the vessel sails home."),
            section("battery", "Battery low", "Bring it home."),
        ];
        let (name, title) = ("trip".to_owned(), "A trip".to_owned());
        vec![Chapter { name, title, part: String::new(), html: String::new(), sections }]
    }

    #[test]
    fn headings_come_before_text_and_all_words_must_be_there() {
        let chapters = chapters();
        let anchors = |wanted: &str| -> Vec<String> {
            search(&chapters, wanted).iter().map(|one| one.anchor.to_owned()).collect()
        };
        assert_eq!(anchors("BATTERY"), ["battery", "home"]);
        assert_eq!(anchors("battery sails"), ["home"]);
        assert_eq!(anchors("zeppelin"), [] as [&str; 0]);
        assert_eq!(anchors("  "), [] as [&str; 0]);
    }

    #[test]
    fn an_excerpt_shows_the_word_between_whole_words() {
        let text = format!("{} battery {}", "before ".repeat(30), "after ".repeat(60));
        let shown = excerpt(&text, "battery");
        assert!(
            shown.starts_with("… before") && shown.contains(" battery after") && shown.ends_with("after …")
        );
        assert!(shown.chars().count() < EXCERPT + 5);
    }

    proptest! {
        #[test]
        fn no_text_and_no_word_breaks_an_excerpt(text in ".{0,400}", word in "\\PC{1,9}") {
            let _ = excerpt(&text, &word.to_lowercase());
        }
    }
}
