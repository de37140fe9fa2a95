//! `lutra-server chart`: the chart set and questions to it.

mod ask;
mod check;
mod export;
mod keep;
mod sync;

pub(super) use ask::{index, place};

use super::Common;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Options of all subcommands: the chart set is in the data folder by default.
#[derive(Debug, Args)]
pub(super) struct Set {
    /// The chart set, a GeoPackage [default: charts.set of the configuration].
    #[arg(long, global = true, value_name = "FILE")]
    db: Option<PathBuf>,
    /// Answer in JSON, for scripts.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Debug, Args)]
pub(super) struct ChartArguments {
    #[command(flatten)]
    set: Set,
    #[command(subcommand)]
    command: ChartCommand,
}

#[derive(Debug, Subcommand)]
enum ChartCommand {
    /// Bring charts into the set: all of them, or, where one cannot be read, none.
    Import(keep::ImportArguments),
    /// The charts of the set.
    List,
    /// What the set holds by class and chart, and what was dropped or repaired.
    Info(keep::InfoArguments),
    /// How deep it is at a place.
    Depth(ask::DepthArguments),
    /// What is shallowest on the way from one place to another.
    Corridor(ask::CorridorArguments),
    /// Whether a plan keeps to deep water.
    Check(check::CheckArguments),
    /// Take charts out of the set.
    Remove(keep::RemoveArguments),
    /// Write depths on a grid, fixed or fine where it is shallow.
    ExportGrid(export::GridArguments),
    /// Write the borders of depth areas as dense points.
    ExportVertices(export::VerticesArguments),
    /// Which chart each vessel holds; and the chart on a medium, for one that no link reaches.
    Sync(sync::SyncArguments),
}

impl Set {
    fn path(&self, common: &Common) -> anyhow::Result<PathBuf> {
        match &self.db {
            Some(path) => Ok(path.clone()),
            None => Ok(common.load_to_write()?.chart_set()),
        }
    }
}

/// Runs the subcommand.
pub(super) fn chart(common: &Common, arguments: &ChartArguments) -> anyhow::Result<()> {
    let db = arguments.set.path(common)?;
    let json = arguments.set.json;
    match &arguments.command {
        ChartCommand::Import(arguments) => keep::import(&db, json, arguments),
        ChartCommand::List => keep::list(&db, json),
        ChartCommand::Info(arguments) => keep::info(&db, json, arguments),
        ChartCommand::Depth(arguments) => ask::depth(&db, json, arguments),
        ChartCommand::Corridor(arguments) => ask::corridor(&db, json, arguments),
        ChartCommand::Check(arguments) => check::check(&db, &common.load_to_write()?, json, arguments),
        ChartCommand::Remove(arguments) => keep::remove(&db, json, arguments),
        ChartCommand::ExportGrid(arguments) => export::grid(&db, json, arguments),
        ChartCommand::ExportVertices(arguments) => export::vertices(&db, json, arguments),
        ChartCommand::Sync(arguments) => sync::sync(&db, &common.load(Vec::new())?, json, arguments),
    }
}
