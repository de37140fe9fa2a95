//! Payloads for any message, made from a string of random bytes.
//!
//! Taking them from bytes rather than from a generator lets proptest shrink what it finds.

#![allow(dead_code, reason = "each test takes the part that it needs")]

use imc::catalogue::{self, FieldDesc, FieldKind, MessageDesc};
use imc::{Body, ByteOrder, Header, Packet};

/// Random bytes to be used up; zeros when they are.
pub(crate) struct Entropy<'a>(pub(crate) &'a [u8]);

impl Entropy<'_> {
    pub(crate) fn byte(&mut self) -> u8 {
        match self.0.split_first() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => 0,
        }
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        (usize::from(self.byte()) << 8 | usize::from(self.byte())) % bound.max(1)
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.byte())
    }
}

/// A packet of the message with random values; nested messages are of the kind asked for, of any kind or
/// null.
pub(crate) fn packet(desc: &MessageDesc, entropy: &mut Entropy<'_>) -> Packet {
    let mut payload = Vec::new();
    fields(desc, entropy, 0, &mut payload);
    let header = Header {
        timestamp: f64::from(u32::from_le_bytes(entropy.bytes())) / 16.0,
        src: imc::Address(u16::from_le_bytes(entropy.bytes())),
        src_ent: entropy.byte(),
        dst: imc::Address(u16::from_le_bytes(entropy.bytes())),
        dst_ent: entropy.byte(),
    };
    Packet {
        header,
        body: Body::Unknown { id: desc.id, payload },
        order: ByteOrder::Little,
        trailing: Vec::new(),
        fields_sent: None,
    }
}

fn fields(desc: &MessageDesc, entropy: &mut Entropy<'_>, depth: u8, out: &mut Vec<u8>) {
    for field in desc.fields {
        value(field, entropy, depth, out);
    }
}

fn value(field: &FieldDesc, entropy: &mut Entropy<'_>, depth: u8, out: &mut Vec<u8>) {
    match field.kind {
        FieldKind::Raw => {
            let count = entropy.below(20);
            out.extend_from_slice(&(count as u16).to_le_bytes());
            out.extend((0..count).map(|_| entropy.byte()));
        }
        FieldKind::Text => {
            let texts: [&[u8]; 6] = [
                b"",
                b"Motor - Port",
                "Ørret på 12 °C 🦦".as_bytes(),
                b"a;b=\"c\\\n\0",
                &[0xFF, 0xC3],
                b"NaN",
            ];
            let text = texts[entropy.below(texts.len())];
            out.extend_from_slice(&(text.len() as u16).to_le_bytes());
            out.extend_from_slice(text);
        }
        FieldKind::Message => message(field, entropy, depth, out),
        FieldKind::List => {
            let count = if depth < 3 { entropy.below(4) } else { 0 };
            out.extend_from_slice(&(count as u16).to_le_bytes());
            for _ in 0..count {
                message(field, entropy, depth, out);
            }
        }
        FieldKind::F32 => {
            let bits = match entropy.below(8) {
                0 => 0x7FC0_0000,
                1 => 0x7F80_0000,
                2 => 0x8000_0000,
                3 => 0x7F80_0001,
                _ => u32::from_le_bytes(entropy.bytes()),
            };
            out.extend_from_slice(&bits.to_le_bytes());
        }
        FieldKind::F64 => {
            let bits = match entropy.below(8) {
                0 => f64::NAN.to_bits(),
                1 => f64::NEG_INFINITY.to_bits(),
                2 => (-0.0_f64).to_bits(),
                3 => 0x7FF0_0000_0000_0001,
                4 => 0.1_f64.to_bits(),
                _ => u64::from_le_bytes(entropy.bytes()),
            };
            out.extend_from_slice(&bits.to_le_bytes());
        }
        kind => out.extend((0..kind.width().unwrap_or(0)).map(|_| entropy.byte())),
    }
}

fn message(field: &FieldDesc, entropy: &mut Entropy<'_>, depth: u8, out: &mut Vec<u8>) {
    let group = |name: &str| catalogue::GROUPS.iter().find(|(group, _)| *group == name);
    let wanted = field.message_type.and_then(|name| match group(name) {
        Some((_, members)) => catalogue::by_abbrev(members[entropy.below(members.len())]),
        None => catalogue::by_abbrev(name),
    });
    let desc = match (entropy.below(4), depth) {
        (0, _) | (_, 3) => None,
        (1, _) => Some(catalogue::MESSAGES[entropy.below(catalogue::MESSAGES.len())]),
        _ => wanted.or_else(|| catalogue::by_abbrev("Goto")),
    };
    match desc {
        None => out.extend_from_slice(&65535_u16.to_le_bytes()),
        Some(desc) => {
            out.extend_from_slice(&desc.id.to_le_bytes());
            fields(desc, entropy, depth + 1, out);
        }
    }
}

/// The Rust name of a field.
pub(crate) fn snake(abbrev: &str) -> String {
    let letters: Vec<char> = abbrev.chars().collect();
    let mut out = String::new();
    for (at, letter) in letters.iter().enumerate() {
        let follows = at > 0 && letters[at - 1] != '_';
        let word = follows && letter.is_uppercase() && !letters[at - 1].is_uppercase();
        let acronym_ends = follows
            && letter.is_uppercase()
            && letters[at - 1].is_uppercase()
            && letters.get(at + 1).is_some_and(|next| next.is_lowercase());
        if word || acronym_ends {
            out.push('_');
        }
        out.extend(letter.to_lowercase());
    }
    out
}
