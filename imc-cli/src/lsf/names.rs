//! What a log itself says its systems and entities are called.

use super::scan::{Printing, scan};
use imc::lsf::LogItem;
use imc::messages::{Announce, EntityInfo, EntityList, EntityListOp};
use imc::{Address, PacketView, Payload as _, entities};
use std::collections::BTreeMap;
use std::path::Path;

/// Labels by number. Numbers differ between configurations, so these hold for one log only.
#[derive(Debug, Default)]
pub(crate) struct Names {
    entities: BTreeMap<(Address, u8), String>,
    systems: BTreeMap<Address, String>,
}

impl Names {
    /// All that a log says.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn of_log(path: &Path) -> anyhow::Result<Self> {
        let mut names = Self::default();
        scan(path, Printing::AtTheEnd, |item| {
            if let LogItem::Packet { view, .. } = item {
                names.learn(view);
            }
            Ok(())
        })?;
        Ok(names)
    }

    /// Whether a message tells names.
    pub(crate) fn are_in(id: u16) -> bool {
        [EntityInfo::ID, EntityList::ID, Announce::ID].contains(&id)
    }

    /// Takes note of what a packet says about names.
    pub(crate) fn learn(&mut self, view: &PacketView<'_>) {
        if !Self::are_in(view.id()) {
            return;
        }
        if let Ok(Some(info)) = imc::decode::<EntityInfo>(view) {
            self.entity(view.src(), info.id, &info.label.to_str_lossy());
        } else if let Ok(Some(list)) = imc::decode::<EntityList>(view)
            && list.op == EntityListOp::Report
        {
            for (label, number) in entities::parse(&list.list.to_str_lossy()) {
                self.entity(view.src(), number, label);
            }
        } else if let Ok(Some(announce)) = imc::decode::<Announce>(view) {
            self.systems.insert(view.src(), announce.sys_name.to_str_lossy().into_owned());
        }
    }

    fn entity(&mut self, system: Address, number: u8, label: &str) {
        if !label.is_empty() {
            self.entities.insert((system, number), label.to_owned());
        }
    }

    /// The label of an entity, empty where the log does not tell.
    pub(crate) fn label(&self, system: Address, number: u8) -> &str {
        self.entities.get(&(system, number)).map_or("", String::as_str)
    }

    /// The label of an entity, or its number.
    pub(crate) fn label_or_number(&self, system: Address, number: u8) -> String {
        match self.label(system, number) {
            "" => number.to_string(),
            label => label.to_owned(),
        }
    }

    /// The registered name of a system, else what it announced, else its number.
    pub(crate) fn system(&self, system: Address) -> String {
        match (system.name(), self.systems.get(&system)) {
            (None, Some(announced)) => announced.clone(),
            _ => system.to_string(),
        }
    }

    /// All labels.
    pub(crate) fn labels(&self) -> impl Iterator<Item = &str> {
        self.entities.values().map(String::as_str)
    }
}
