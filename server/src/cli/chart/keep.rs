//! `chart import`, `list`, `info` and `remove`.

use crate::cli::data::Progress;
use crate::cli::say::{complain, counted, say};
use anyhow::ensure;
use chartdb::{Chart, ChartDb, ImportOptions, Imported, Outcome};
use charts::xyz::Vertical;
use clap::Args;
use serde_json::json;
use shore::clock;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  lutra-server chart import ENC_ROOT
  lutra-server chart import NO5H1620.000            its updates .001, .002 ... beside it come along
  lutra-server chart import --epsg 25833 survey.xyz
  lutra-server chart import --depth-column depth_min lakes.shp

A chart that is in the set already is not read again; a newer edition takes its place. What was read before a
failure is kept, so that importing again goes on from there.")]
pub(super) struct ImportArguments {
    /// S-57 cells and folders of them, soundings (.xyz), land (.geojson), lakes with depths (.shp, .gpkg).
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Coordinates of soundings and lakes: 258xx or 326xx for UTM, 4326 or 4258 for degrees.
    #[arg(long, value_name = "CODE")]
    epsg: Option<u32>,
    /// The z of soundings is a height, positive up.
    #[arg(long)]
    heights: bool,
    /// Column of the least depth of lakes (m).
    #[arg(long, value_name = "NAME")]
    depth_column: Option<String>,
    /// Column of the greatest depth of lakes (m).
    #[arg(long, value_name = "NAME")]
    deepest_column: Option<String>,
    /// Table of lakes in a GeoPackage.
    #[arg(long, value_name = "TABLE")]
    layer: Option<String>,
    /// Import complete charts although others cannot be read.
    #[arg(long)]
    keep_going: bool,
}

#[derive(Debug, Args)]
pub(super) struct InfoArguments {
    /// Charts by name. Without it: all.
    #[arg(value_name = "CHART")]
    charts: Vec<String>,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  lutra-server chart remove NO5H1620")]
pub(super) struct RemoveArguments {
    /// Charts by name.
    #[arg(required = true, value_name = "CHART")]
    charts: Vec<String>,
}

fn word(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Added => "new".to_owned(),
        Outcome::Replaced { before } => format!("replaces {before}"),
        Outcome::Unchanged => "there already".to_owned(),
        Outcome::Withdrawn => "withdrawn by its producer".to_owned(),
    }
}

fn skin_word(chart: &Imported) -> &'static str {
    match chart.skin.map(|check| check.holds()) {
        Some(true) => "; depth areas and land tile it without gap or overlap",
        Some(false) => "; DEPTH AREAS AND LAND DO NOT TILE IT, see below",
        None => "",
    }
}

pub(super) fn import(db: &Path, json: bool, arguments: &ImportArguments) -> anyhow::Result<()> {
    let options = ImportOptions {
        epsg: arguments.epsg,
        vertical: if arguments.heights { Vertical::HeightUp } else { Vertical::DepthDown },
        depth_column: arguments.depth_column.clone(),
        deepest_column: arguments.deepest_column.clone(),
        layer: arguments.layer.clone(),
        keep_going: arguments.keep_going,
        ..ImportOptions::new(clock::now())
    };
    shore::private::begin();
    let mut progress = Progress::new();
    let report = chartdb::import(db, &arguments.paths, &options, &mut |at| {
        progress.tell(|| format!("{} of {}: {}", at.done, at.of, at.name));
        true
    })?;
    drop(progress);
    if json {
        let charts: Vec<_> = report.charts.iter().map(described).collect();
        let failures: Vec<_> = report
            .failures
            .iter()
            .map(|failure| json!({"name": failure.name, "error": failure.error.to_string()}))
            .collect();
        say!(
            "{}",
            json!({"applied": report.applied, "digest": report.digest, "charts": charts, "failures": failures,
                   "notices": report.notices})
        );
    } else {
        for chart in &report.charts {
            let edition = if chart.edition.is_empty() {
                String::new()
            } else {
                format!(" edition {} update {},", chart.edition, chart.update)
            };
            let outcome = word(&chart.outcome);
            say!(
                "{} ({}):{edition} {} features, {outcome}{}",
                chart.name,
                chart.kind,
                chart.features,
                skin_word(chart)
            );
            chart.notices.iter().for_each(|notice| complain!("  {notice}"));
        }
        report.notices.iter().for_each(|notice| complain!("{notice}"));
        report.failures.iter().for_each(|failure| complain!("{}: {}", failure.name, failure.error));
        if report.applied {
            say!("{} holds the charts; digest {}", db.display(), report.digest);
        }
    }
    let failed = report.failures.len();
    ensure!(
        report.applied,
        "not readable: {}; the set stays as it was. Repair it or leave it out, or add --keep-going",
        counted(failed, "chart")
    );
    ensure!(failed == 0, "left out: {}", counted(failed, "chart"));
    Ok(())
}

fn described(chart: &Imported) -> serde_json::Value {
    json!({"name": chart.name, "kind": chart.kind, "outcome": chart.outcome, "edition": chart.edition,
           "update": chart.update, "features": chart.features, "notices": chart.notices,
           "skin": chart.skin.map(|check| json!({"holds": check.holds(), "skin_deg2": check.skin_deg2,
               "coverage_deg2": check.coverage_deg2, "unreadable": check.unreadable, "amiss_deg2": check.amiss_deg2,
               "amiss_at": check.amiss_at.map(|at| [at.lat_deg, at.lon_deg])}))})
}

pub(super) fn list(db: &Path, json: bool) -> anyhow::Result<()> {
    let set = ChartDb::open(db)?;
    let charts = set.charts()?;
    let digest = hex::encode(set.digest()?);
    if json {
        say!("{}", json!({"db": db, "digest": digest, "charts": charts}));
        return Ok(());
    }
    for chart in &charts {
        say!("{}", line(chart));
    }
    say!("{} in {}; digest {digest}", counted(charts.len(), "chart"), db.display());
    Ok(())
}

fn line(chart: &Chart) -> String {
    let Chart { name, kind, edition, update, scale, band, issued, features, .. } = chart;
    let torn = if chart.skin_holds == Some(false) {
        "; its depths and land have GAPS OR OVERLAPS (chart info tells where)"
    } else {
        ""
    };
    if kind == "cell" {
        format!(
            "{name}  edition {edition} update {update} of {issued}, 1:{scale}, band {band}, {features} features{torn}"
        )
    } else {
        format!("{name}  {kind}, {features} features")
    }
}

pub(super) fn info(db: &Path, json: bool, arguments: &InfoArguments) -> anyhow::Result<()> {
    let set = ChartDb::open(db)?;
    let mut all = Vec::new();
    for chart in set.charts_named(&arguments.charts)? {
        let (classes, log) = (set.counts(&chart)?, set.log(&chart)?);
        if json {
            all.push(json!({"chart": chart, "classes": classes, "log": log}));
            continue;
        }
        say!("{}", line(&chart));
        if let Some([west, south, east, north]) = chart.bounds_deg {
            say!("  from {south:.4}, {west:.4} to {north:.4}, {east:.4}; {} vertices", chart.vertices);
        }
        let counts: Vec<String> = classes.iter().map(|(class, count)| format!("{class} {count}")).collect();
        say!("  {}", counts.join(", "));
        for entry in log {
            let record = entry.record.map_or(String::new(), |record| format!(", record {record}"));
            say!("  {} {} {}{record}: {}", entry.time, entry.what, entry.file, entry.text);
        }
    }
    if json {
        say!("{}", json!({"db": db, "digest": hex::encode(set.digest()?), "charts": all}));
    }
    Ok(())
}

pub(super) fn remove(db: &Path, json: bool, arguments: &RemoveArguments) -> anyhow::Result<()> {
    let digest = chartdb::remove(db, &arguments.charts, clock::now())?;
    if json {
        say!("{}", json!({"removed": arguments.charts, "digest": digest}));
    } else {
        say!("removed {}; digest {digest}", arguments.charts.join(", "));
    }
    Ok(())
}
