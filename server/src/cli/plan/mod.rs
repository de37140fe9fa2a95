//! `lutra-server plan`: plans without a running server.

mod classic;
mod objective;
mod route;
mod zones;

use super::Common;
use clap::{Args, Subcommand};

#[derive(Debug, Args)]
pub(super) struct PlanArguments {
    #[command(subcommand)]
    command: PlanCommand,
}

#[derive(Debug, Subcommand)]
enum PlanCommand {
    /// The shortest route on the sea chart that keeps to deep water and clear of dangers, or the best by time or energy.
    Route(route::RouteArguments),
}

/// Runs the subcommand.
pub(super) fn plan(common: &Common, arguments: &PlanArguments) -> anyhow::Result<()> {
    match &arguments.command {
        PlanCommand::Route(arguments) => route::route(common, arguments),
    }
}
