//! `chart sync`: which chart each vessel holds, and the chart for a vessel that no link reaches.

use crate::cli::say::say;
use crate::config::Config;
use anyhow::{Context as _, ensure};
use api::VesselChart;
use clap::Args;
use imc::Address;
use serde_json::json;
use shore::charts::{ChartPackage, ChartsAboard};
use shore::clock;
use shore::identity::{Connection, Fault, Request as _, vessels, with};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use units::UtcTime;

const FILE: &str = "chart.lutra-index";

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  lutra-server chart sync                        what each vessel said last, and what the server offers
  lutra-server chart sync --vessel otter-1
  lutra-server chart sync --to /media/stick      the chart for vessels that no link reaches

A running server offers its chart set to every vessel whose link stands; they fetch it by themselves with what the
link has to spare. A chart that was copied by --to goes into the folder `chart` of the agent's folder of data, and
is read when lutra-agent starts.")]
pub(super) struct SyncArguments {
    /// Only this vessel (name or IMC address).
    #[arg(long, value_name = "VESSEL")]
    vessel: Option<String>,
    /// Copy the chart into this folder, to be carried aboard.
    #[arg(long, value_name = "FOLDER")]
    to: Option<PathBuf>,
}

pub(super) fn sync(db: &Path, config: &Config, json: bool, arguments: &SyncArguments) -> anyhow::Result<()> {
    let loaded = chartdb::load_index(db)?;
    let package = ChartPackage::open(db, &loaded)
        .with_context(|| format!("{} cannot be read", chartdb::index_path(db).display()))?;
    let offer = package.offer();
    let vessels = vessels_of(config, &package, arguments.vessel.as_deref())?;
    let copied = arguments.to.as_deref().map(|folder| copy(&package, folder)).transpose()?;
    if json {
        let list: Vec<_> = vessels
            .iter()
            .map(|(address, (name, chart))| json!({"vessel": address, "name": name, "chart": chart}))
            .collect();
        say!(
            "{}",
            json!({"db": db, "digest": hex::encode(offer.digest), "bytes": offer.bytes,
                   "edition": offer.edition, "vessels": list, "copied": copied})
        );
        return Ok(());
    }
    say!("ashore: {}, {} bytes, SHA-256 {}", offer.edition, offer.bytes, hex::encode(offer.digest));
    for (address, (name, chart)) in &vessels {
        say!("{}", line(*address, name.as_deref(), chart));
    }
    if vessels.is_empty() {
        say!(
            "no vessel has reported its chart, and no vessel has a name; `lutra-server vessel add` names one"
        );
    }
    if let Some(path) = copied {
        say!(
            "{} is the chart for a vessel: put it into the folder `chart` of its agent's data",
            path.display()
        );
    }
    Ok(())
}

type Vessels = BTreeMap<u16, (Option<String>, VesselChart)>;

/// The vessels that have names, and those that reported their charts.
fn vessels_of(config: &Config, package: &ChartPackage, only: Option<&str>) -> anyhow::Result<Vessels> {
    // Without a database there are no names.
    let (named, only) = if config.data.join("app.db").exists() {
        with(&config.data, async |db| known(db, only).await)?
    } else {
        (Vec::new(), only.map(vessels::address).transpose().map_err(anyhow::Error::msg)?)
    };
    let aboard = ChartsAboard::open(&config.data);
    let names: BTreeMap<u16, String> = named.into_iter().map(|one| (one.address, one.name)).collect();
    let addresses = aboard.vessels().into_iter().chain(names.keys().copied()).chain(only);
    let told = addresses.filter(|address| only.is_none_or(|only| only == *address)).map(|address| {
        let chart = aboard.chart(Address(address), Some(package.digest()));
        (address, (names.get(&address).cloned(), chart))
    });
    Ok(told.collect())
}

/// The vessels that have names, and the address of `only`.
async fn known(db: &mut Connection, only: Option<&str>) -> Result<(Vec<api::Vessel>, Option<u16>), Fault> {
    let only = match only {
        Some(text) => Some(vessels::named(db, text).await?),
        None => None,
    };
    Ok((vessels::List.run(db).await?, only))
}

fn line(address: u16, name: Option<&str>, chart: &VesselChart) -> String {
    let name = name.map_or_else(|| Address(address).to_string(), str::to_owned);
    let holds = chart.edition.as_deref().unwrap_or("no chart");
    match chart.told_us {
        None => format!("{name}: {}", chart.text),
        Some(told_us) => {
            let at = clock::written(UtcTime::from_micros(told_us));
            format!("{name}: {}; holds {holds}, as it said at {at}", chart.text)
        }
    }
}

fn copy(package: &ChartPackage, folder: &Path) -> anyhow::Result<PathBuf> {
    ensure!(folder.is_dir(), "{} is not a folder; give one that is there by --to", folder.display());
    let path = folder.join(FILE);
    let same = path.canonicalize().ok().is_some_and(|path| package.path().canonicalize().ok() == Some(path));
    ensure!(!same, "{} is the server's own; give the folder of a medium by --to", path.display());
    package.copy(&path).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}
