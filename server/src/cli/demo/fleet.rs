//! The Otters of a demo: names, addresses, places, and the configuration of each one's agent.

use anyhow::Context as _;
use imc::Address;
use std::fmt::Write as _;
use std::fs;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use units::{LatLon, LocalFrame, LocalPoint, UtcTime};

/// The configuration that comes with lutra-agent.
const OTTER_INI: &str = include_str!("../../../../vehicle-agent/etc/otter.ini");
/// The first Otter's address: an unused one of surface vehicles, in the range for users other than LSTS.
const FIRST: u16 = 0x28D1;
/// Where the first Otter starts, north and east (degrees): in the fjord off Trondheim.
const PLACE_DEG: (f64, f64) = (63.446, 10.345);
/// The Otter of which only a log exists; the address before the first, also unused.
const YESTERDAY: u16 = FIRST - 1;
/// Otters in a row, and how far they are apart (m).
const IN_A_ROW: u16 = 3;
const APART_M: f64 = 250.0;
/// So many fit at that distance; more are placed closer, in the same deep water.
const WITH_ROOM: u16 = 12;
/// Tagged fish, within so far from the middle of the first row (m).
pub(super) const FISH: u32 = 3;
const FISH_RADIUS_M: f64 = 250.0;

/// What an Otter does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    /// Around a square.
    Square,
    /// Over an area in rows.
    Rows,
    /// Around a circle, then drifting in its middle.
    Circle,
}

impl Pattern {
    /// In the order in which they are assigned to Otters.
    pub(super) const ALL: [Self; 3] = [Self::Square, Self::Rows, Self::Circle];

    /// In words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Square => "around a square",
            Self::Rows => "rows over an area",
            Self::Circle => "a circle and keeps its station, in turn,",
        }
    }
}

/// One Otter.
#[derive(Debug, Clone)]
pub(super) struct Otter {
    pub(super) name: String,
    pub(super) address: Address,
    pub(super) start: LatLon,
    pub(super) pattern: Pattern,
}

/// This many Otters.
pub(super) fn otters(count: u16) -> Vec<Otter> {
    let frame = frame();
    let otter = |index: u16| {
        let (in_a_row, apart_m) =
            if count > WITH_ROOM { (2 * IN_A_ROW - 1, APART_M / 2.0) } else { (IN_A_ROW, APART_M) };
        let (row, column) = (index / in_a_row, index % in_a_row);
        let (north_m, east_m) = (f64::from(row) * apart_m, f64::from(column) * apart_m);
        Otter {
            name: format!("otter-{}", index + 1),
            address: Address(FIRST + index),
            start: frame.to_place(LocalPoint { north_m, east_m }),
            pattern: Pattern::ALL[usize::from(index) % Pattern::ALL.len()],
        }
    };
    (0..count).map(otter).collect()
}

/// The Otter that sailed yesterday, where the others sail today.
pub(super) fn of_yesterday() -> Otter {
    Otter {
        name: "otter-0".to_owned(),
        address: Address(YESTERDAY),
        start: frame().to_place(LocalPoint { north_m: 0.0, east_m: APART_M }),
        pattern: Pattern::Rows,
    }
}

/// Address and token of an Otter's link.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub(super) server: SocketAddr,
    pub(super) token: String,
}

/// The environment of all Otters.
#[derive(Debug, Clone, Copy)]
pub(super) struct World<'a> {
    /// The chart's depth index.
    pub(super) chart: &'a Path,
    /// When the fish begin to swim.
    pub(super) since: UtcTime,
    /// Whether there are fish.
    pub(super) fish: bool,
}

fn frame() -> LocalFrame {
    let (north, east) = PLACE_DEG;
    LocalFrame::new(LatLon::from_deg(north, east).expect("invariant: the place is on Earth"))
}

/// Writes the common part of all agents' configurations, before any of them reads it.
///
/// # Errors
/// The folder cannot be written.
pub(super) fn prepare(folder: &Path) -> anyhow::Result<()> {
    put(&folder.join("otter.ini"), OTTER_INI)
}

fn put(path: &Path, text: &str) -> anyhow::Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Writes the files of an agent: its own configuration, and its link's token.
///
/// # Errors
/// The folder cannot be written.
pub(super) fn write(
    folder: &Path,
    world: World<'_>,
    otter: &Otter,
    link: Option<&Link>,
) -> anyhow::Result<()> {
    if let Some(link) = link {
        put(&folder.join(format!("{}.token", otter.name)), &link.token)?;
    }
    put(&otter.ini(folder), &otter.configuration(world, link))
}

impl Otter {
    /// Its configuration's file.
    pub(super) fn ini(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.ini", self.name))
    }

    /// Where its agent keeps plans, logs and spool.
    pub(super) fn data(&self, folder: &Path) -> PathBuf {
        folder.join(&self.name)
    }

    /// Log of its agent.
    pub(super) fn log(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.log", self.name))
    }

    /// Its differences from the common configuration.
    fn configuration(&self, world: World<'_>, link: Option<&Link>) -> String {
        let Self { name, address, start, .. } = self;
        let link = link.map_or_else(
            || "Enabled = Never".to_owned(),
            |link| format!("Enabled = Always\nURL = ws://{}/link\nToken File = {name}.token", link.server),
        );
        let text = format!(
            "# Written by `lutra-server demo`.\n[Require otter.ini]\n\n\
             [General]\nVehicle = {name}\n\
             # Whatever else keeps this computer busy is no reason to stop a simulated vessel.\n\
             CPU Usage - Maximum = 100\n\n\
             [IMC Addresses]\n{name} = {:#06x}\n\n\
             # Nobody but the server shall talk to it, and nothing else on this computer be disturbed.\n\
             [Transports.Announce]\nEnabled = Never\n\n\
             [Transports.UDP]\nEnabled = Never\n\n\
             [Transports.TCP.Server]\nEnabled = Never\n\n\
             [Transports.Lutra]\n{link}\n\n\
             [Supervisors.Grounding]\nChart = {}\n\n\
             [Simulators.GPS]\nInitial Position = {:.7}, {:.7}\n\n\
             [Simulators.StreamVelocity]\nDefault Speed North = 0.05\nDefault Speed East = 0.1\n",
            address.0,
            world.chart.display(),
            start.lat_deg(),
            start.lon_deg(),
        );
        if world.fish { text + &fish(world.since) } else { text }
    }
}

/// The sections of all fish.
fn fish(since: UtcTime) -> String {
    let middle = frame().to_place(LocalPoint { north_m: 60.0, east_m: APART_M });
    let (lat_deg, lon_deg, since_s) = (middle.lat_deg(), middle.lon_deg(), since.micros() / 1_000_000);
    let mut text = String::new();
    for fish in 1..=FISH {
        // Writing to a text cannot fail.
        let _ = write!(
            text,
            "\n[Simulators.Fish/{fish}]\nEnabled = Simulation\nEntity Label = Tagged Fish {fish}\n\
             Tag Number = {}\nBeginning = {since_s}\nArea -- Centre = {lat_deg:.7}, {lon_deg:.7}\n\
             Area -- Radius = {FISH_RADIUS_M}\nTag Interval = 10, 25\n",
            100 + fish,
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::config::schema::{simulate, transport};
    use ::config::{Config, Disk};
    use imc::AddressKind;
    use std::collections::BTreeSet;

    #[test]
    fn addresses_are_of_surface_vehicles_that_nobody_has() {
        let mut otters = otters(11);
        otters.push(of_yesterday());
        for otter in &otters {
            assert_eq!(otter.address.kind(), AddressKind::Asv, "{}", otter.address);
            assert_eq!((otter.address.name(), otter.address.is_lsts()), (None, Some(false)));
        }
        assert_eq!(otters.iter().map(|otter| otter.address).collect::<BTreeSet<_>>().len(), 12);
        assert!(otters.iter().all(|otter| (63.4..63.5).contains(&otter.start.lat_deg())));
    }

    #[test]
    fn every_agent_gets_a_configuration_free_of_problems() {
        let folder = tempfile::tempdir().unwrap();
        let link = Link { server: "127.0.0.1:8081".parse().unwrap(), token: "lutra_link_x".to_owned() };
        let since = UtcTime::from_micros(1_790_000_000_000_000);
        let chart = folder.path().join("chart.lutra-index");
        prepare(folder.path()).unwrap();
        let load = |otter: &Otter, link: Option<&Link>, fish: bool| {
            write(folder.path(), World { chart: &chart, since, fish }, otter, link).unwrap();
            let config = Config::load(&Disk, &otter.ini(folder.path()), &["Simulation"]);
            assert_eq!(config.report().counts(), ::config::Counts::default(), "{}", config.report());
            assert_eq!((config.vehicle(), config.address()), (&*otter.name, Some(otter.address.0)));
            let open = [&transport::udp::UDP, &transport::tcp::SERVER, &transport::announce::ANNOUNCE];
            assert!(open.into_iter().all(|transport| config.running(transport).next().is_none()));
            config
        };
        for otter in &otters(3) {
            let config = load(otter, Some(&link), true);
            let only = config.running(&transport::lutra::LUTRA).next().unwrap();
            assert_eq!(only.get(&transport::lutra::URL), "ws://127.0.0.1:8081/link");
            assert_eq!(config.running(&simulate::fish::FISH).count(), 3);
        }
        let config = load(&of_yesterday(), None, false);
        assert!(config.running(&transport::lutra::LUTRA).next().is_none());
        assert!(config.running(&simulate::fish::FISH).next().is_none());
    }
}
