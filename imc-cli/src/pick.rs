//! Which packets are wanted, by message and source.

use imc::catalogue::ADDRESSES;
use imc::{Address, PacketView};

/// Flags that choose packets by their header.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Pick {
    /// Only this message, by name or number (0x...); may be given several times
    #[arg(long = "message", short = 'm', value_name = "MESSAGE", value_parser = message_id)]
    pub(crate) messages: Vec<u16>,
    /// Only from this system, by name or number (0x...); may be given several times
    #[arg(long = "src", short = 's', value_name = "SYSTEM", value_parser = system)]
    pub(crate) sources: Vec<Address>,
}

impl Pick {
    /// Whether a packet is wanted.
    pub(crate) fn admits(&self, view: &PacketView<'_>) -> bool {
        (self.messages.is_empty() || self.messages.contains(&view.id()))
            && (self.sources.is_empty() || self.sources.contains(&view.src()))
    }
}

/// The id that a message's name stands for; any number is one, decimal or hexadecimal, also of messages that are not listed.
pub(crate) fn message_id(text: &str) -> Result<u16, String> {
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => u16::from_str_radix(digits, 16),
        None => text.parse(),
    };
    number.or_else(|_| tables::message(text).map(|message| message.id).map_err(|error| error.to_string()))
}

/// A system's address by its registered name, in any case, or its number.
fn system(text: &str) -> Result<Address, String> {
    let by_name = ADDRESSES.iter().find(|(name, _)| name.eq_ignore_ascii_case(text));
    if let Some((_, address)) = by_name {
        return Ok(Address(*address));
    }
    text.parse().map_err(|error: imc::AddressError| {
        let alike = suggest::alike(text, ADDRESSES.iter().map(|(name, _)| *name));
        if alike.is_empty() {
            error.to_string()
        } else {
            format!("{error}; did you mean {}?", alike.join(" or "))
        }
    })
}
