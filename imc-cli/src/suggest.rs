//! "Did you mean": messages by what people type.

use anyhow::anyhow;
use imc::catalogue::{self, MESSAGES, MessageDesc};

/// How alike two words must be to be offered for one another (Jaro-Winkler, 0 to 1).
const ALIKE: f64 = 0.82;
/// Most words offered.
const OFFERED: usize = 3;

/// The message that a name in any case, or an id, stands for.
///
/// # Errors
/// When there is none, naming those that look alike.
pub(crate) fn message(text: &str) -> anyhow::Result<&'static MessageDesc> {
    let by_name = || MESSAGES.iter().find(|message| message.abbrev.eq_ignore_ascii_case(text)).copied();
    let id = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u16::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    match id {
        Some(id) => catalogue::by_id(id).ok_or_else(|| anyhow!("no message has the id {text}")),
        None => by_name().ok_or_else(|| unknown(text)),
    }
}

fn unknown(text: &str) -> anyhow::Error {
    let alike = alike(text, MESSAGES.iter().map(|message| message.abbrev));
    if alike.is_empty() {
        anyhow!("no message is called `{text}`; `imc list TEXT` searches all {}", MESSAGES.len())
    } else {
        anyhow!("no message is called `{text}`; did you mean {}?", alike.join(", "))
    }
}

/// The words most like a text, best first.
pub(crate) fn alike<'w>(text: &str, words: impl Iterator<Item = &'w str>) -> Vec<&'w str> {
    let text = text.to_lowercase();
    let likeness = |word: &str| {
        let word = word.to_lowercase();
        let inside = if text.len() >= 3 && word.contains(&text) { 0.9 } else { 0.0 };
        strsim::jaro_winkler(&text, &word).max(inside)
    };
    let mut found: Vec<(f64, &str)> =
        words.map(|word| (likeness(word), word)).filter(|(likeness, _)| *likeness >= ALIKE).collect();
    found.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    found.into_iter().take(OFFERED).map(|(_, word)| word).collect()
}
