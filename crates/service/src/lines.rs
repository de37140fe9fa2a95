//! Text from vessels and people in a log: it begins no line of its own and controls no terminal.

use std::fmt::Write as _;

/// Characters that would begin another line, reorder its text, or control a terminal.
pub fn is_forging(letter: char) -> bool {
    let turns = matches!(letter, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}');
    turns || (letter.is_control() && letter != '\t')
}

/// The text with each such character written out, at most about `most` bytes of it; what is cut off is counted at its end.
pub fn harmless(text: &str, most: usize) -> String {
    let mut safe = String::with_capacity(text.len().min(most) + 32);
    for (at, letter) in text.char_indices() {
        if safe.len() >= most {
            write!(safe, " … {} bytes more", text.len() - at).ok();
            break;
        }
        if is_forging(letter) { safe.extend(letter.escape_default()) } else { safe.push(letter) }
    }
    safe
}
