//! `imc address`: systems by name and number.

use crate::outcome::Outcome;
use crate::output::Output;
use crate::style::Paint;
use imc::Address;
use imc::catalogue::ADDRESSES;
use serde_json::json;
use std::io::Write as _;

const EXAMPLES: &str = "\
Examples:
  imc address ntnu-otter-01        0x2810
  imc address 0x4001               what kind of system that would be
  imc address 10256                decimal will do
  imc address my-boat              not registered: the address that DUNE makes of the name
  imc address lauv-noptilus-1 --json";

/// Translates between the names and numbers of systems.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Lookup {
    /// A system's name, or its number: decimal, or hexadecimal after 0x
    #[arg(value_name = "NAME|ID")]
    system: String,
    /// One JSON object for programs
    #[arg(long)]
    json: bool,
}

impl Lookup {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let found = Found::of(&self.system)?;
        if self.json {
            let line = json!({
                "name": found.names.first(), "names": found.names, "id": found.address.0,
                "hex": format!("{:#06x}", found.address.0), "kind": found.address.kind().to_string(),
                "lsts": found.address.is_lsts(), "registered": found.registered,
            });
            writeln!(out, "{line}")?;
        } else {
            write!(out, "{}", found.text(Paint::stdout()))?;
        }
        Ok(Outcome::Sound)
    }
}

struct Found {
    address: Address,
    names: Vec<String>,
    registered: bool,
    /// Registered names that look like the one given.
    alike: Vec<&'static str>,
}

impl Found {
    fn of(system: &str) -> anyhow::Result<Self> {
        let name = system.trim();
        let exact = ADDRESSES.iter().find(|(listed, _)| listed.eq_ignore_ascii_case(name));
        if let Some((_, number)) = exact {
            return Ok(Self::numbered(Address(*number)));
        }
        if name.is_empty() || name.starts_with(|first: char| first.is_ascii_digit()) {
            return Ok(Self::numbered(name.parse()?));
        }
        Ok(Self {
            address: Address::for_unlisted_name(name),
            names: vec![name.to_owned()],
            registered: false,
            alike: suggest::alike(name, ADDRESSES.iter().map(|(listed, _)| *listed)),
        })
    }

    fn numbered(address: Address) -> Self {
        let names: Vec<String> = ADDRESSES
            .iter()
            .filter(|(_, number)| *number == address.0)
            .map(|(name, _)| (*name).to_owned())
            .collect();
        Self { address, registered: !names.is_empty(), names, alike: Vec::new() }
    }

    fn text(&self, paint: Paint) -> String {
        let name = match self.names.as_slice() {
            [] => "(not registered)".to_owned(),
            names => names.join(", "),
        };
        let number = format!("{:#06x} ({})", self.address.0, self.address.0);
        let whose = match self.address.is_lsts() {
            Some(true) => " of LSTS",
            Some(false) => " of another institute than LSTS",
            None => "",
        };
        let mut text = format!("{}  {number}  {}{whose}\n", paint.title(&name), self.address.kind());
        if !self.registered && !self.names.is_empty() {
            text += &paint.aside("not registered: DUNE makes this address of the name\n");
        }
        if !self.alike.is_empty() {
            text += &paint.aside(&format!("registered names like it: {}\n", self.alike.join(", ")));
        }
        text
    }
}
