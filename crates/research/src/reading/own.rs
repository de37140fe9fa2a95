//! Our own table, as the format `lutra` and the Parquet file have it. What comes of the register, and when the detection came
//! ashore there, is left: the register and the clock of this server decide these.

use super::row::{Row, empty, shown};
use super::{Carriers, Wrong};
use api::say;
use detections::{ClockState, Detection, Effort, Maker, Noise, Origin, Pose, Protocol, ReceiverClock};
use imc::Address;
use std::borrow::Cow;
use units::LatLon;

/// Columns that no other table has together.
pub(super) const KNOWN_BY: [&str; 6] =
    ["detection_id", "reported_utc", "clock_count", "clock", "protocol", "tag_id"];

/// The detection of a row.
pub(super) fn detection(row: &Row<'_>, carriers: &Carriers<'_>) -> Result<Detection, Wrong> {
    let system = match carriers.system {
        Some(system) => system,
        None => (carriers.address)(&row.needed("vessel")?)
            .map_err(|said| ("vessel".to_owned(), say("{text}").with_said("text", said)))?,
    };
    let origin = Origin {
        system: Address(system),
        entity: entity(row)?,
        reported: row.time("reported_utc")?.ok_or_else(|| empty("reported_utc"))?,
        received: None,
    };
    let protocol = row.needed("protocol")?;
    let detection = Detection {
        origin,
        receiver: row.whole("receiver")?.ok_or_else(|| empty("receiver"))?,
        maker: maker(&row.needed("detection_id")?),
        clock: clock(row)?,
        protocol: protocol.parse().map_or_else(|_| Protocol::named(&protocol), Protocol::numbered),
        tag_id: row.whole("tag_id")?.ok_or_else(|| empty("tag_id"))?,
        data: row.whole("sensor_value")?,
        // Earlier versions wrote 0 where it was not known.
        snr_db: row.whole("snr")?.filter(|snr_db| *snr_db != 0),
        frequency_khz: row.whole("frequency")?.filter(|khz| *khz != 0),
        line: row.whole("memory_address")?.unwrap_or_default(),
        pose: pose(row)?,
        effort: Effort {
            lines_lost: row.whole("lines_lost_before")?,
            noise: noise(row)?,
            propeller_rpm: row.real("propeller_speed")?,
        },
        raw: row.text("raw_line").map(Cow::into_owned),
    };
    let (named, found) = (row.needed("detection_id")?, detection.id());
    if named != found {
        let text = say(
            "`{named}` names another detection than the cells of its row, {found}: a spreadsheet has rounded or shifted them; export the file again",
        );
        let text = text.with("named", shown(&named)).with("found", found);
        return Err(("detection_id".to_owned(), text));
    }
    Ok(detection)
}

/// The maker of the receiver stands in the id alone.
fn maker(id: &str) -> Option<Maker> {
    id.split_once(':').and_then(|(word, _)| Maker::of_word(word))
}

/// The entity that reported it stands in the id alone.
fn entity(row: &Row<'_>) -> Result<u8, Wrong> {
    let id = row.needed("detection_id")?;
    id.rsplit('-').nth(1).and_then(|entity| entity.parse().ok()).ok_or_else(|| {
        let text = say("`{text}` is not an id such as 1024-1795248000.007-S256-7-2-1795248001000001; export the file again");
        ("detection_id".to_owned(), text.with("text", shown(&id)))
    })
}

fn clock(row: &Row<'_>) -> Result<ReceiverClock, Wrong> {
    let count = row.plain(&row.needed("clock_count")?);
    let (seconds, decimals) = count.split_once('.').unwrap_or((&count, "0"));
    let millis = Some(decimals).filter(|decimals| (1..=3).contains(&decimals.len()));
    let millis = millis.and_then(|decimals| format!("{decimals:0<3}").parse().ok());
    let (Some(seconds), Some(millis)) = (seconds.parse().ok(), millis) else {
        let text = say(
            "`{text}` is not seconds with three decimals; a spreadsheet has changed it: export the file again",
        );
        return Err(("clock_count".to_owned(), text.with("text", shown(&count))));
    };
    let word = row.needed("clock")?;
    let state = ClockState::of_word(&word).ok_or_else(|| {
        let text = say("`{text}` is not set, disciplined, lost or not set");
        ("clock".to_owned(), text.with("text", shown(&word)))
    })?;
    Ok(ReceiverClock { seconds, millis, state })
}

fn pose(row: &Row<'_>) -> Result<Option<Pose>, Wrong> {
    let Some((lat_deg, lon_deg)) = both(row, "latitude", "longitude")? else { return Ok(None) };
    let place = place(lat_deg, lon_deg).map_err(|text| ("latitude".to_owned(), text))?;
    Ok(Some(Pose { place, age_s: row.real("position_age")?, sigma_m: row.real("position_deviation")? }))
}

/// Latitude and longitude by their columns; a latitude without a longitude is not a place, nor the reverse.
pub(super) fn both(row: &Row<'_>, lat: &str, lon: &str) -> Result<Option<(f64, f64)>, Wrong> {
    let (lat_deg, lon_deg) = (row.real(lat)?, row.real(lon)?);
    if lat_deg.is_some() != lon_deg.is_some() {
        let name = if lat_deg.is_some() { lon } else { lat };
        return Err((name.to_owned(), say("empty beside the other half of the place; give both or neither")));
    }
    Ok(lat_deg.zip(lon_deg))
}

/// A place in degrees.
pub(super) fn place(lat_deg: f64, lon_deg: f64) -> Result<LatLon, api::Wording> {
    LatLon::from_deg(lat_deg, lon_deg).map_err(|error| {
        say("{error}; look at the signs and at the order of the columns").with("error", error)
    })
}

fn noise(row: &Row<'_>) -> Result<Option<Noise>, Wrong> {
    let (average, peak) = (row.whole("noise_average")?, row.whole("noise_peak")?);
    let both = average.zip(peak).zip(row.real("noise_age")?);
    Ok(both.map(|((average, peak), age_s)| Noise { average, peak, age_s }))
}
