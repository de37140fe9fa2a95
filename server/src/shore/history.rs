//! The fleet as it was: the store's reader, in the words of the API.
//!
//! Each question opens a reader of its own, which costs little and shares nothing, so that a long export holds up
//! no page.

use super::History;
use api::{ExportQuery, Recorded, TrackPoint, TrackQuery};
use imc::Address;
use std::io::Write;
use std::path::PathBuf;
use store::{Angles, CsvOptions, Reader, Selection, TimeRange};
use units::UtcTime;

/// Points of a track that nobody asked for more of.
const POINTS: u32 = 2_000;

/// The history of a data folder.
pub(crate) struct Stored {
    data: PathBuf,
}

impl Stored {
    pub(crate) fn new(data: PathBuf) -> Self {
        Self { data }
    }
}

impl History for Stored {
    fn recorded(&self) -> anyhow::Result<Vec<Recorded>> {
        let mut all = std::collections::BTreeMap::<(u16, String), Recorded>::new();
        for series in Reader::open(&self.data)?.series(None)? {
            let abbrev = series.message.map_or_else(|| series.group.id.to_string(), str::to_owned);
            let (first_us, last_us) = (series.extent.first_us, series.extent.last_us);
            let system = series.group.src;
            let entry = all.entry((system, abbrev.clone()));
            let known = entry.or_insert_with(|| Recorded { system, abbrev, count: 0, first_us, last_us });
            known.count += series.extent.count;
            known.first_us = known.first_us.min(first_us);
            known.last_us = known.last_us.max(last_us);
        }
        Ok(all.into_values().collect())
    }

    fn track(&self, vessel: u16, query: &TrackQuery) -> anyhow::Result<Vec<TrackPoint>> {
        let range = TimeRange::new(
            Some(UtcTime::from_micros(query.from_us)),
            Some(UtcTime::from_micros(query.to_us)),
        );
        let points = query.points.unwrap_or(POINTS) as usize;
        let track = Reader::open(&self.data)?.track(Address(vessel), range, points, 0.0)?;
        let point = |point: &store::TrackPoint| TrackPoint {
            time_us: point.time.micros(),
            lat_deg: point.place.lat_deg(),
            lon_deg: point.place.lon_deg(),
        };
        Ok(track.points.iter().map(point).collect())
    }

    fn export(
        &self,
        query: &ExportQuery,
        may: &dyn Fn(u16) -> bool,
        out: &mut dyn Write,
    ) -> anyhow::Result<()> {
        let systems: Vec<Address> = match query.vessel {
            Some(vessel) => vec![Address(vessel)],
            None => Reader::open(&self.data)?.systems()?.into_iter().map(|system| system.address).collect(),
        };
        let systems: Vec<Address> = systems.into_iter().filter(|system| may(system.0)).collect();
        // The store takes an empty list for all; here it means that there is nothing this person may have.
        anyhow::ensure!(!systems.is_empty(), "nothing is recorded that you may export");
        let selection = Selection {
            messages: vec![query.message.clone()],
            systems,
            range: TimeRange::new(time(query.from.as_deref())?, time(query.to.as_deref())?),
            ..Selection::default()
        };
        let angles = if query.angles.as_deref() == Some("deg") { Angles::Degrees } else { Angles::Radians };
        store::export_csv(&self.data, &selection, &CsvOptions { angles, ..CsvOptions::default() }, out)?;
        Ok(())
    }
}

/// ISO 8601 UTC; nothing for no bound.
fn time(text: Option<&str>) -> anyhow::Result<Option<UtcTime>> {
    let Some(text) = text.map(str::trim).filter(|text| !text.is_empty()) else { return Ok(None) };
    let time = text.parse().map_err(|error| anyhow::anyhow!("`{text}`: {error}"))?;
    Ok(Some(time))
}
