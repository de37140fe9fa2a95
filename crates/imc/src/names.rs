//! The names that systems and entities announce, each with the time from which it holds.
//!
//! Numbers of entities are assigned when a system starts, so after a restart the same number can be another part. A label
//! therefore holds from its announcement until the next one; before the first announcement the first label holds.

use crate::address::Address;
use crate::entities;
use crate::header::PacketView;
use crate::messages::{Announce, EntityInfo, EntityList, EntityListOp, Payload as _};
use crate::packet::decode;
use crate::runs::Runs;
use std::collections::BTreeMap;

/// A system's name and kind, as it announces them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SystemName {
    /// The name.
    pub name: String,
    /// Its kind, by IMC's enumeration `SystemType`.
    pub kind: u8,
}

/// One name in a packet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Told {
    /// Of its sender.
    System(SystemName),
    /// Of an entity of its sender.
    Entity(u8, String),
}

/// The names of everything.
#[derive(Debug, Default, Clone)]
pub struct Names {
    /// Of systems, by address.
    pub systems: BTreeMap<u16, Runs<SystemName>>,
    /// Of entities, by the system's address and their number.
    pub entities: BTreeMap<(u16, u8), Runs<String>>,
}

/// Whether a message carries names.
pub fn are_in(id: u16) -> bool {
    [EntityInfo::ID, EntityList::ID, Announce::ID].contains(&id)
}

/// The names in a packet.
pub fn told(view: &PacketView<'_>) -> Vec<Told> {
    match view.id() {
        Announce::ID => decode::<Announce>(view).ok().flatten().map_or_else(Vec::new, |announce| {
            let name = announce.sys_name.to_str_lossy().into_owned();
            vec![Told::System(SystemName { name, kind: announce.sys_type.value() })]
        }),
        EntityInfo::ID => decode::<EntityInfo>(view).ok().flatten().map_or_else(Vec::new, |info| {
            vec![Told::Entity(info.id, info.label.to_str_lossy().into_owned())]
        }),
        EntityList::ID => match decode::<EntityList>(view) {
            Ok(Some(list)) if list.op == EntityListOp::Report => {
                let told = |(label, entity): (&str, u8)| Told::Entity(entity, label.to_owned());
                entities::parse(&list.list.to_str_lossy()).map(told).collect()
            }
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

impl Names {
    /// Takes the names in a packet of this time.
    pub fn hear(&mut self, view: &PacketView<'_>, time_us: i64) {
        for one in told(view) {
            match one {
                Told::System(name) => self.systems.entry(view.src().0).or_default().hear(time_us, &name),
                Told::Entity(entity, label) => {
                    self.entities.entry((view.src().0, entity)).or_default().hear(time_us, &label)
                }
            };
        }
    }

    /// A system's name: as it announced itself last, or as it is registered, or its address.
    pub fn system(&self, address: Address) -> String {
        let announced = self.systems.get(&address.0).and_then(Runs::latest);
        announced.map_or_else(|| address.to_string(), |name| name.name.clone())
    }

    /// An entity's label at a time.
    pub fn entity(&self, address: Address, entity: u8, time_us: i64) -> Option<&str> {
        self.entities.get(&(address.0, entity))?.at(time_us).map(String::as_str)
    }

    /// The label that an entity had last.
    pub fn latest_entity(&self, address: Address, entity: u8) -> Option<&str> {
        self.entities.get(&(address.0, entity))?.latest().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Header, Packet};

    #[test]
    fn a_label_holds_from_when_it_was_told() {
        let mut names = Names::default();
        let mut tell = |time_us: i64, list: &str| {
            let header = Header { src: Address(7), ..Header::default() };
            let list = EntityList { op: EntityListOp::Report, list: list.into() };
            let bytes = Packet::new(header, list).encode().unwrap();
            names.hear(&PacketView::new(&bytes).unwrap(), time_us);
        };
        tell(10, "Port=1;Starboard=2");
        tell(20, "Starboard=1;Port=2");
        let label = |time_us| [1, 2].map(|entity| names.entity(Address(7), entity, time_us).unwrap());
        assert_eq!(
            [label(0), label(19), label(20)],
            [["Port", "Starboard"], ["Port", "Starboard"], ["Starboard", "Port"]]
        );
        assert_eq!(names.latest_entity(Address(7), 1), Some("Starboard"));
        assert_eq!(names.entity(Address(7), 3, 0), None);
    }
}
