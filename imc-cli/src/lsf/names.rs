//! Names of systems and entities from the log itself.

use super::scan::{Printing, scan};
use imc::lsf::LogItem;
use imc::names::Names;
use imc::{Address, PacketView};
use std::path::Path;
use units::UtcTime;

/// All names in a log.
///
/// # Errors
/// When the file cannot be read.
pub(crate) fn of_log(path: &Path) -> anyhow::Result<Names> {
    let mut names = Names::default();
    scan(path, Printing::AtTheEnd, |item| {
        if let LogItem::Packet { view, .. } = item {
            learn(&mut names, view);
        }
        Ok(())
    })?;
    Ok(names)
}

/// Learns names from a packet.
pub(crate) fn learn(names: &mut Names, view: &PacketView<'_>) {
    if imc::names::are_in(view.id()) {
        names.hear(view, time_us(view));
    }
}

/// The label that a packet's entity had then, or its number.
pub(crate) fn sender(names: &Names, view: &PacketView<'_>) -> String {
    let label = names.entity(view.src(), view.src_ent(), time_us(view));
    label.map_or_else(|| view.src_ent().to_string(), str::to_owned)
}

/// The label that an entity had last, or its number.
pub(crate) fn label_or_number(names: &Names, system: Address, number: u8) -> String {
    names.latest_entity(system, number).map_or_else(|| number.to_string(), str::to_owned)
}

/// All labels.
pub(crate) fn labels(names: &Names) -> impl Iterator<Item = &str> {
    names.entities.values().flat_map(|runs| runs.runs.values()).map(|run| run.name.as_str())
}

/// Time of a packet; packets without one come first.
pub(crate) fn time_us(view: &PacketView<'_>) -> i64 {
    view.header().time().map_or(i64::MIN, UtcTime::micros)
}
