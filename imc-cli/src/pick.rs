//! Which packets are wanted, by message and source.

use crate::messages;
use imc::{Address, PacketView};

/// Flags that choose packets by their header.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Pick {
    /// Only this message, by abbreviation or id; may be given several times
    #[arg(long = "message", short = 'm', value_name = "MESSAGE", value_parser = message_id)]
    pub(crate) messages: Vec<u16>,
    /// Only from this system, by name or number (0x...); may be given several times
    #[arg(long = "src", short = 's', value_name = "SYSTEM")]
    pub(crate) sources: Vec<Address>,
}

impl Pick {
    /// Whether a packet is wanted.
    pub(crate) fn admits(&self, view: &PacketView<'_>) -> bool {
        (self.messages.is_empty() || self.messages.contains(&view.id()))
            && (self.sources.is_empty() || self.sources.contains(&view.src()))
    }
}

/// The id that a message's name stands for; any number is one, also of messages that are not listed.
pub(crate) fn message_id(text: &str) -> Result<u16, String> {
    text.parse().or_else(|_| match messages::message(text) {
        Ok(message) => Ok(message.id),
        Err(error) => Err(error.to_string()),
    })
}
