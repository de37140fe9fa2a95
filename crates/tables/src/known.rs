//! Looks up messages by what people type.

use imc::catalogue::{self, MESSAGES, MessageDesc};
use std::fmt;

/// Letters of the input that are repeated.
const SHOWN: usize = 60;

/// There is no such message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoMessage {
    given: String,
    alike: Vec<&'static str>,
}

impl fmt::Display for NoMessage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "IMC has no message `{}`; ", self.given)?;
        match self.alike.as_slice() {
            [] => write!(f, "`imc list TEXT` searches all {}", MESSAGES.len()),
            names => write!(f, "did you mean `{}`?", names.join("` or `")),
        }
    }
}

impl std::error::Error for NoMessage {}

/// The message that a text names: its name in any case, or its number, decimal or hexadecimal after `0x`.
///
/// # Errors
/// The catalogue has no such message; the error names similar ones.
pub fn message(text: &str) -> Result<&'static MessageDesc, NoMessage> {
    let text = text.trim();
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u16::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    let found = match number {
        Some(id) => catalogue::by_id(id),
        None => MESSAGES.iter().find(|message| message.abbrev.eq_ignore_ascii_case(text)).copied(),
    };
    found.ok_or_else(|| NoMessage {
        given: text.chars().take(SHOWN).collect(),
        alike: suggest::alike(text, MESSAGES.iter().map(|message| message.abbrev)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_found_by_name_and_number() {
        for text in ["EstimatedState", "estimatedstate", "350", "0x15e", "0X15E", " EstimatedState "] {
            assert_eq!(message(text).unwrap().abbrev, "EstimatedState", "{text}");
        }
        let told = |text| message(text).unwrap_err().to_string();
        assert_eq!(
            told("Voltag"),
            "IMC has no message `Voltag`; did you mean `Voltage` or `BmsCellVoltage`?"
        );
        assert_eq!(told("61234"), "IMC has no message `61234`; `imc list TEXT` searches all 351");
        assert!(told("0xfffff").starts_with("IMC has no message `0xfffff`"));
    }
}
