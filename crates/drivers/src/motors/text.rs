//! Text of the card, which comes eight characters at a time without an end.

use super::outbox::Outbox;
use crate::Note;
use devices::torqeedo::TEXT_LEN;

/// A line of the card is passed on when it is so long.
const MOST_TEXT: usize = 80;

/// The text that has begun.
#[derive(Debug, Clone, Default)]
pub(super) struct CardText {
    bytes: Vec<u8>,
}

impl CardText {
    /// Takes the characters of one frame. A line ends at a line feed, in a frame that is not full, or when it is long.
    pub(super) fn take(&mut self, characters: &[u8], out: &mut Outbox) {
        for &byte in characters {
            match byte {
                b'\n' | b'\r' => self.pass_on(out),
                _ => self.bytes.push(byte),
            }
        }
        if characters.len() < TEXT_LEN || self.bytes.len() >= MOST_TEXT {
            self.pass_on(out);
        }
    }

    fn pass_on(&mut self, out: &mut Outbox) {
        let text = String::from_utf8_lossy(&std::mem::take(&mut self.bytes)).into_owned();
        let text: String = text.chars().map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
        if !text.is_empty() {
            out.note(Note { warning: false, text: format!("the card says: {text}") });
        }
    }
}
