//! Which vessels are known: those that people named, that were heard since the start, or of which something is recorded. And what
//! a reader probably meant by the name or address of another.
//!
//! The register of names and the hub's memory are asked first. The history on the disk is read only for what neither has.

use crate::identity::vessels;
use crate::{Error, ErrorKind, Result, Shore};
use api::say;
use imc::Address;
use std::collections::BTreeMap;

/// Most vessels that a refusal lists.
const LISTED: usize = 8;
/// The beginning of a reader's text, enough to find it by.
const SHOWN: usize = 60;

/// Vessels with what they are called: by people, by themselves, by the scheme of addresses.
type Names = BTreeMap<Address, Vec<String>>;

impl Shore {
    /// The address that a text gives, decimal or hexadecimal after `0x`, whether or not a vessel has it; or that of the vessel
    /// with this name, of those that `may` admits.
    ///
    /// # Errors
    /// No vessel can have that address, or no vessel has that name. The latter says what may have been meant.
    pub async fn address_of(&self, text: &str, may: &(impl Fn(u16) -> bool + Sync)) -> Result<Address> {
        if let Ok(address) = vessels::address(text) {
            return one_vessel(Address(address));
        }
        let mut names = self.named(may);
        if let Some(found) = called(&names, text) {
            return Ok(found);
        }
        self.add_heard(&mut names, may).await?;
        if let Some(found) = called(&names, text) {
            return Ok(found);
        }
        self.add_recorded(&mut names, may).await?;
        called(&names, text).ok_or_else(|| unknown(&names, text))
    }

    /// The address of the known vessel with this name or address.
    ///
    /// # Errors
    /// It is not known, or not one that `may` admits. The former says what may have been meant.
    pub async fn vessel(&self, text: &str, may: &(impl Fn(u16) -> bool + Sync)) -> Result<Address> {
        let address = self.address_of(text, may).await?;
        if !may(address.0) {
            let text = say("you may not see vessel {vessel}. Ask an admin.").with("vessel", address.0);
            return Err(Error::new(ErrorKind::Forbidden, text));
        }
        self.must_be_known(address, may).await?;
        Ok(address)
    }

    /// Checks that a vessel has this address.
    ///
    /// # Errors
    /// None is known that has. The error lists the nearest that `may` admits.
    pub async fn must_be_known(&self, vessel: Address, may: &(impl Fn(u16) -> bool + Sync)) -> Result<()> {
        if self.people.is_named(vessel) || self.fleet.is_heard(vessel).await? {
            return Ok(());
        }
        let mut names = self.named(may);
        self.add_heard(&mut names, may).await?;
        self.add_recorded(&mut names, may).await?;
        if names.contains_key(&vessel) {
            return Ok(());
        }
        Err(unknown(&names, &format!("{:#06x}", vessel.0)))
    }

    fn named(&self, may: &(impl Fn(u16) -> bool + Sync)) -> Names {
        let named = self.people.vessels();
        let seen = named.iter().filter(|vessel| may(vessel.address));
        seen.map(|vessel| (Address(vessel.address), vec![vessel.name.clone()])).collect()
    }

    async fn add_heard(&self, names: &mut Names, may: &(impl Fn(u16) -> bool + Sync)) -> Result<()> {
        for (address, name) in self.fleet.heard().await?.into_iter().filter(|(address, _)| may(address.0)) {
            let registered = address.name().map(str::to_owned);
            names.entry(address).or_default().extend(name.into_iter().chain(registered));
        }
        Ok(())
    }

    async fn add_recorded(&self, names: &mut Names, may: &(impl Fn(u16) -> bool + Sync)) -> Result<()> {
        let recorded = self.history.ask(store::Reader::systems).await?;
        for system in recorded.into_iter().filter(|system| may(system.address.0)) {
            let registered = system.address.name().map(str::to_owned);
            names.entry(system.address).or_default().extend(std::iter::once(system.name).chain(registered));
        }
        Ok(())
    }
}

/// Refuses the addresses that mean everyone.
///
/// # Errors
/// It is one of them.
pub(crate) fn one_vessel(address: Address) -> Result<Address> {
    if !address.is_everyone() {
        return Ok(address);
    }
    let text = say("{address} is not the address of one vessel: 0, 0xFFF0 and 0xFFFF mean all of them.")
        .with("address", format!("{:#06x}", address.0));
    Err(Error::new(ErrorKind::Malformed, text))
}

fn called(names: &Names, text: &str) -> Option<Address> {
    let text = text.trim();
    let is_called = |of: &[String]| of.iter().any(|name| name.eq_ignore_ascii_case(text));
    names.iter().find(|(_, of)| is_called(of)).map(|(address, _)| *address)
}

/// The refusal of a vessel that is not among those with `names`.
fn unknown(names: &Names, text: &str) -> Error {
    let addresses: Vec<String> = names.keys().map(|address| format!("{:#06x}", address.0)).collect();
    let words = names.values().flatten().chain(&addresses).map(String::as_str);
    let alike = suggest::alike(text, words);
    let shown: String = text.chars().take(SHOWN).collect();
    let said = if names.is_empty() {
        say("There is no vessel {vessel}, and no vessel is known here that you may see.")
    } else if alike.is_empty() {
        let listed = names.iter().take(LISTED).map(|(address, of)| match of.first() {
            Some(name) => format!("{name} ({:#06x})", address.0),
            None => format!("{:#06x}", address.0),
        });
        say("There is no vessel {vessel}; there are {vessels}.")
            .with("vessels", listed.collect::<Vec<_>>().join(", "))
    } else {
        say("There is no vessel {vessel}; did you mean {vessels}?").with("vessels", alike.join(", "))
    };
    Error::new(ErrorKind::NotFound, said.with("vessel", shown))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names() -> Names {
        let named = |address, name: &str| (Address(address), vec![name.to_owned()]);
        [named(0x0814, "otter-1"), named(0x0815, "otter-2"), named(0x2810, "ntnu-otter-01")].into()
    }

    #[test]
    fn an_unknown_vessel_is_refused_with_what_may_have_been_meant() {
        let told = |text| unknown(&names(), text).text.to_string();
        assert_eq!(told("oter-1"), "There is no vessel oter-1; did you mean otter-1?");
        assert_eq!(told("0x0816"), "There is no vessel 0x0816; did you mean 0x0814, 0x0815?");
        assert_eq!(
            told("catamaran"),
            "There is no vessel catamaran; there are otter-1 (0x0814), otter-2 (0x0815), ntnu-otter-01 (0x2810)."
        );
        let nothing = unknown(&Names::new(), "otter-1");
        assert_eq!(nothing.kind, ErrorKind::NotFound);
        assert!(nothing.text.contains("no vessel is known here"), "{nothing}");
    }

    #[test]
    fn a_vessel_is_found_by_any_of_its_names_in_any_case() {
        assert_eq!(called(&names(), " OTTER-2"), Some(Address(0x0815)));
        assert_eq!(called(&names(), "otter"), None);
    }

    #[test]
    fn an_address_of_all_vessels_is_that_of_none() {
        for address in [0, 0xFFF0, 0xFFFF] {
            assert_eq!(one_vessel(Address(address)).unwrap_err().kind, ErrorKind::Malformed, "{address}");
        }
        assert!(one_vessel(Address(0x0814)).is_ok());
    }
}
