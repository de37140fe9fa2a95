//! Messages by what people type: a name in any case, or an id.

use anyhow::anyhow;
use imc::catalogue::{self, MESSAGES, MessageDesc};

/// The message that `text` stands for.
///
/// # Errors
/// There is no such message; the error names similar ones.
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
    let alike = suggest::alike(text, MESSAGES.iter().map(|message| message.abbrev));
    if alike.is_empty() {
        anyhow!("no message is called `{text}`; `imc list TEXT` searches all {}", MESSAGES.len())
    } else {
        anyhow!("no message is called `{text}`; did you mean {}?", alike.join(", "))
    }
}
