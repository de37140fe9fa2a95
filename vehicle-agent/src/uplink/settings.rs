//! Settings from `[Transports.Lutra]`.

use super::filter::Filter;
use super::server::Server;
use super::spool::Bounds;
use super::ways::{Door, Leaves};
use anyhow::{Context as _, bail};
use config::schema::transport::{MESSAGES, RATES, lutra};
use config::{Config, Section};
use link::{MOST_WAY_NAME_BYTES, MOST_WAYS, WaySettings};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Settings of the uplink.
#[derive(Debug, Clone)]
pub(crate) struct UplinkSettings {
    /// IMC address of the vessel.
    pub(crate) address: u16,
    /// The vessel's name.
    pub(crate) name: String,
    /// The ways to the shore, one at least.
    pub(crate) ways: Vec<Door>,
    pub(crate) filter: Filter,
    /// Folder of the spool.
    pub(crate) spool: PathBuf,
    pub(crate) bounds: Bounds,
    /// Bytes a second over time; `None` for no bound.
    pub(crate) budget_bytes_per_s: Option<u32>,
    pub(crate) sync_every: Duration,
    /// The agent's data folder, for the shore's chart; `None` if that is not wanted.
    pub(crate) chart: Option<PathBuf>,
}

impl UplinkSettings {
    /// Reads the configuration; `None` if the uplink is off. Files without a path are beside the configuration `file`, the
    /// spool is in the folder `data`.
    ///
    /// # Errors
    /// When a value is not valid.
    pub(crate) fn read(
        config: &Config,
        file: &Path,
        data: &Path,
        doubts: &mut Vec<String>,
    ) -> anyhow::Result<Option<Self>> {
        let Some(section) = config.running(&lutra::LUTRA).next() else { return Ok(None) };
        let name = config.vehicle().to_owned();
        let address = config.address().with_context(|| format!("the vehicle `{name}` has no address"))?;
        let beside = |path: String| file.parent().unwrap_or(Path::new(".")).join(path);
        let server = server(section, beside).with_context(|| format!("[{}]", section.name()))?;
        let spool = section.get(&lutra::SPOOL_FOLDER);
        let mebibytes = section.get(&lutra::SPOOL_SIZE).unsigned_abs();
        let budget = section.get(&lutra::BYTE_BUDGET);
        Ok(Some(Self {
            address,
            ways: ways(config, server)?,
            filter: filter(section, doubts),
            spool: if spool.is_empty() { data.join("spool").join(&name) } else { PathBuf::from(spool) },
            bounds: Bounds::of(mebibytes << 20),
            budget_bytes_per_s: u32::try_from(budget).ok().filter(|budget| *budget > 0),
            sync_every: Duration::from_secs_f64(section.get(&lutra::SYNC_INTERVAL)),
            chart: crate::setup::takes_chart(config).then(|| data.to_owned()),
            name,
        }))
    }
}

fn server(section: &Section, beside: impl Fn(String) -> PathBuf) -> anyhow::Result<Server> {
    let url = section.get(&lutra::URL);
    let token_file = section.get(&lutra::TOKEN_FILE);
    let authority = section.get(&lutra::AUTHORITY);
    let path = beside(token_file);
    let token = fs::read_to_string(&path).with_context(|| {
        format!("Token File: reading {}; `lutra-server token create` makes one", path.display())
    })?;
    let token = token.trim().to_owned();
    if token.is_empty() || !token.bytes().all(|byte| byte.is_ascii_graphic()) {
        bail!("Token File: {} holds no token", path.display());
    }
    let authority = (!authority.is_empty()).then(|| beside(authority));
    Server::at(url, token, authority)
}

/// The enabled ways, in the order of their names; if there are none, a single one by the computer's routing table.
fn ways(config: &Config, server: Server) -> anyhow::Result<Vec<Door>> {
    let sections: Vec<&Section> = config.running(&lutra::WAY).collect();
    if sections.is_empty() {
        return Ok(vec![Door::only(server)]);
    }
    if sections.len() > MOST_WAYS {
        bail!("{} ways to the shore are enabled, and at most {MOST_WAYS} can be", sections.len());
    }
    sections
        .into_iter()
        .map(|section| way(section, &server).with_context(|| format!("[{}]", section.name())))
        .collect()
}

fn way(section: &Section, server: &Server) -> anyhow::Result<Door> {
    let name = section.label().unwrap_or_default().to_owned();
    if name.is_empty() || name.len() > MOST_WAY_NAME_BYTES || name.contains(char::is_control) {
        bail!("Entity Label: a way needs a name of at most {MOST_WAY_NAME_BYTES} bytes");
    }
    let url = section.get(&lutra::WAY_URL);
    let server = if url.is_empty() {
        server.clone()
    } else {
        Server::at(url, server.token.clone(), server.authority.clone())?
    };
    let interface = section.get(&lutra::INTERFACE);
    if interface.len() > 15 {
        bail!("Interface: `{interface}` is longer than a name of an interface (15 letters) can be");
    }
    let address = section.get(&lutra::SOURCE_ADDRESS);
    let address = (!address.is_empty()).then(|| {
        address
            .parse()
            .with_context(|| format!("Source Address: `{address}` is not an IP address, such as 192.0.2.7"))
    });
    let daily_bytes = Some(section.get(&lutra::DAILY_BUDGET).unsigned_abs() << 20).filter(|bytes| *bytes > 0);
    let metered = section.get(&lutra::METERED);
    if daily_bytes.is_some() && !metered {
        bail!("Daily Budget: only a way that is `Metered` has one");
    }
    let way = WaySettings { name, metered, daily_bytes, ..WaySettings::default() };
    let leaves =
        Leaves { interface: (!interface.is_empty()).then_some(interface), address: address.transpose()? };
    Ok(Door { way, server, leaves })
}

fn filter(section: &Section, doubts: &mut Vec<String>) -> Filter {
    let mut id = |key: &str, name: &str| {
        let found = imc::catalogue::by_abbrev(name).map(|message| message.id);
        if found.is_none() {
            doubts.push(format!("[{}] {key}: no message `{name}`", section.name()));
        }
        found
    };
    let listed = section.get(&MESSAGES);
    let carried =
        (!listed.is_empty()).then(|| listed.iter().filter_map(|name| id("Transports", name)).collect());
    let rates = section.get(&RATES);
    let most_per_s =
        rates.into_iter().filter_map(|(name, rate)| Some((id("Rate Limiters", &name)?, rate))).collect();
    let important = section.get(&lutra::KEPT_LONGEST);
    let important = important.iter().filter_map(|name| id("Kept Longest", name)).collect();
    Filter { carried, most_per_s, important }
}
