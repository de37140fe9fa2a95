//! `chart check`: checks a plan against the chart, as server and vessels do.

use super::ask::{index, place};
use crate::cli::say::say;
use crate::config::Config;
use anyhow::{Context as _, anyhow, bail, ensure};
use api::PlanDocument;
use clap::Args;
use imc::messages::{Message, PlanSpecification};
use mission::check_plan;
use shore::charts::{Limits, told};
use shore::identity::{self, Request as _};
use shore::plans;
use std::fs;
use std::path::Path;
use units::LatLon;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  lutra-server chart check survey.json
  lutra-server chart check 12 --from 63.4402,10.3951

It ends with a failure when the plan is refused.")]
pub(super) struct CheckArguments {
    /// A file (JSON of an IMC PlanSpecification, a plan document of /api/v1/plans, GeoJSON or GPX), or the number of a
    /// plan that the server keeps.
    #[arg(value_name = "PLAN")]
    plan: String,
    /// Where the vessel is when the plan starts, in degrees. Without it the way to the first place is not checked.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    from: Option<LatLon>,
}

pub(super) fn check(
    db: &Path,
    config: &Config,
    json: bool,
    arguments: &CheckArguments,
) -> anyhow::Result<()> {
    let CheckArguments { plan: name, from } = arguments;
    let specification = find(config, name)?;
    let plan = plans::understood(&specification)
        .map_err(|problem| anyhow!("{name}: no vessel would take this plan: {problem}"))?;
    let limits = Limits { demanded: config.charts.limits(), of_vessel: false };
    let guard = told(&check_plan(&plan, *from, &index(db)?, &limits.demanded), &limits);
    if json {
        say!("{}", serde_json::to_string(&guard)?);
    } else {
        guard.reasons.iter().for_each(|reason| say!("refused: {}", reason.text));
        guard.warnings.iter().for_each(|warning| say!("warning: {}", warning.text));
        say!("{}: {}", guard.outcome, guard.text);
    }
    ensure!(guard.outcome != "refused", "{name}: the chart shows danger");
    Ok(())
}

fn find(config: &Config, name: &str) -> anyhow::Result<PlanSpecification> {
    let path = Path::new(name);
    if !path.exists() {
        let Ok(id) = name.parse() else {
            bail!("{name}: there is no such file, and it is not a number of a plan");
        };
        let load = plans::Load { id, revision: None };
        let row = identity::with(&config.data, async |db| load.run(db).await)?.filter(|row| !row.deleted);
        let row =
            row.with_context(|| format!("the server keeps no plan {id} in {}", config.data.display()))?;
        return of_document(name, &row.plan);
    }
    let bytes = fs::read(path).with_context(|| name.to_owned())?;
    if let Ok(document) = serde_json::from_slice::<PlanDocument>(&bytes) {
        return of_document(name, &document);
    }
    // Maneuvers that plan documents do not have, such as drifting with the motors off, are checked too.
    if let Ok(mut value) = serde_json::from_slice::<serde_json::Value>(&bytes)
        && let Some(object) = value.as_object_mut().filter(|object| object.contains_key("abbrev"))
    {
        // The header of a whole packet.
        object.retain(|key, _| !matches!(key.as_str(), "header" | "endian"));
        match imc::json::message_from_value(&value).with_context(|| name.to_owned())? {
            Message::PlanSpecification(plan) => return Ok(*plan),
            other => bail!("{name}: it holds a {}, not a PlanSpecification", other.abbrev()),
        }
    }
    let file = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let (document, _) = plans::read(&bytes, &file).map_err(|text| anyhow!("{name}: {text}"))?;
    of_document(name, &document)
}

fn of_document(name: &str, plan: &PlanDocument) -> anyhow::Result<PlanSpecification> {
    plans::specification(plan).map_err(|troubles| {
        let texts: Vec<&str> = troubles.iter().map(|one| one.text.as_str()).collect();
        anyhow!("{name}: {}", texts.join("; "))
    })
}
