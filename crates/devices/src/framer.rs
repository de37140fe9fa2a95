//! The lines of one receiver in a stream of bytes: noise is skipped, damage is reported where it stands, and what follows is
//! read.

use crate::lines::{Lines, Piece};
use core::marker::PhantomData;

/// How a receiver writes its lines.
pub trait Grammar {
    /// A line that was read.
    type Line;
    /// Why one was not.
    type Damage;

    /// Begins a line wherever it is; bytes before it were noise, or a line that lost its end.
    const START: Option<u8>;
    /// The longest line that is kept (bytes).
    const LONGEST: usize;
    /// Another line begins, or the stream ends, before this one's end.
    const UNENDED: Self::Damage;
    /// It is longer than [`LONGEST`](Self::LONGEST).
    const TOO_LONG: Self::Damage;

    /// Reads one line, without its end.
    ///
    /// # Errors
    /// When it is damaged.
    fn read(text: &[u8]) -> Result<Self::Line, Self::Damage>;

    /// Whether the last line of a stream, with this damage, lacks no more than its end.
    fn is_unended(damage: &Self::Damage) -> bool;

    /// The part of noise before a start that can still be read.
    fn in_noise(_text: &[u8]) -> Option<Self::Line> {
        None
    }
}

/// Finds lines in a stream.
#[derive(Debug, Clone)]
pub struct Framer<G> {
    lines: Lines,
    grammar: PhantomData<G>,
}

impl<G: Grammar> Default for Framer<G> {
    fn default() -> Self {
        Self { lines: Lines::new(G::START, G::LONGEST), grammar: PhantomData }
    }
}

impl<G: Grammar> Framer<G> {
    /// Takes the next bytes and hands out each line, or why it is damaged, with the offset of its first byte in the stream.
    pub fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(u64, Result<G::Line, G::Damage>)) {
        self.lines.feed(bytes, |offset, piece| match piece {
            Piece::Line(text) if text.trim_ascii().is_empty() => {}
            Piece::Line(text) => take(offset, G::read(text)),
            Piece::Cut([first, rest @ ..]) if Some(*first) == G::START => {
                if !rest.is_empty() {
                    take(offset, Err(G::UNENDED));
                }
            }
            Piece::Cut(noise) => {
                if let Some(line) = G::in_noise(noise) {
                    take(offset, Ok(line));
                }
            }
            Piece::TooLong => take(offset, Err(G::TOO_LONG)),
        });
    }

    /// The stream is over: a last line that lacks only its end is read.
    pub fn end(&mut self, mut take: impl FnMut(u64, Result<G::Line, G::Damage>)) {
        self.lines.end(|offset, piece| {
            if let Piece::Cut(text) = piece
                && !text.trim_ascii().is_empty()
            {
                let told = |damage| if G::is_unended(&damage) { G::UNENDED } else { damage };
                take(offset, G::read(text).map_err(told));
            }
        });
    }

    /// Forgets the line at hand, as when a port was opened again.
    pub fn clear(&mut self) {
        self.lines.clear();
    }

    /// How many bytes of an unfinished line are kept; never more than the longest line.
    pub fn kept(&self) -> usize {
        self.lines.kept()
    }
}
