//! Grids of currents from files, as routes are asked for in them.

use super::objective::{MOST_CROSSINGS, grid};
use crate::error::{Error, ErrorKind, Result, slow};
use api::{Said, SeaRouteCurrentGrid, say};
use geofile::currents::{self, COLUMNS, CurrentField, CurrentsError, LineTrouble};

/// Currents are given in so many parts of a m/s: a question takes less room then.
const PARTS: f64 = 10_000.0;

/// The grid of currents in a file, CSV or NetCDF-3.
///
/// # Errors
/// What is wrong with the file, where, and what to do.
pub async fn currents_of_file(file: Vec<u8>) -> Result<SeaRouteCurrentGrid> {
    slow(move || of_file(&file)).await?.map_err(|text| Error::new(ErrorKind::Malformed, text))
}

fn of_file(file: &[u8]) -> std::result::Result<SeaRouteCurrentGrid, Said> {
    let field = currents::read(file).map_err(|error| said(&error))?;
    if field.east_mps.len() > MOST_CROSSINGS {
        let text = say(
            "The file makes {count} crossings of times, latitudes and longitudes; up to {most} are taken. Cut it to the area and the time of the route.",
        );
        return Err(text.with("count", field.east_mps.len()).with("most", MOST_CROSSINGS).into());
    }
    let of = asked(field);
    // What a question with it would be refused for.
    grid(&of)?;
    Ok(of)
}

fn asked(field: CurrentField) -> SeaRouteCurrentGrid {
    let CurrentField { times_s, lats_deg, lons_deg, east_mps, north_mps } = field;
    // Saturates beyond all times.
    let times_us = times_s.iter().map(|time_s| (time_s * 1e6).round() as i64).collect();
    let rounded = |mps: f32| ((f64::from(mps) * PARTS).round() / PARTS) as f32;
    let values =
        |values: Vec<f32>| values.into_iter().map(|mps| mps.is_finite().then(|| rounded(mps))).collect();
    SeaRouteCurrentGrid {
        times_us,
        lats_deg,
        lons_deg,
        east_mps: values(east_mps),
        north_mps: values(north_mps),
    }
}

/// Why a file is not a grid, in words that pages can translate; what is wrong with NetCDF is said in English.
fn said(error: &CurrentsError) -> Said {
    match error {
        CurrentsError::Text => {
            say("The file is neither NetCDF nor text in UTF-8. Give CSV or NetCDF-3.").into()
        }
        CurrentsError::Line { line, trouble } => line_said(*line, trouble),
        CurrentsError::TooFew { .. } => {
            say("A grid has two latitudes and two longitudes or more.").into()
        }
        CurrentsError::Scattered { crossings, lines, .. } => say(
            "The times, latitudes and longitudes make {crossings} crossings, and the file has {lines} lines. Give points on a grid of latitudes and longitudes.",
        )
        .with("crossings", crossings)
        .with("lines", lines)
        .into(),
        CurrentsError::NetCdf(_) => Said::as_is(error.to_string()),
    }
}

fn line_said(line: usize, trouble: &LineTrouble) -> Said {
    let text = match trouble {
        LineTrouble::TooMany { most } => {
            say("Line {line}: the file has more than {most} lines. Cut it to the area and the time.")
                .with("most", most)
        }
        LineTrouble::NoColumn { name } => {
            say("Line {line}: there is no column {name}. Begin the file with {columns}.")
                .with("name", name)
                .with("columns", COLUMNS.join(","))
        }
        LineTrouble::Short { name, .. } => {
            say("Line {line}: it ends before {name}. Write a value for each column of the heading.")
                .with("name", name)
        }
        LineTrouble::NoTime { text } => {
            say("Line {line}: \"{text}\" is not a time such as 2026-11-21T07:00:00Z.").with("text", text)
        }
        LineTrouble::NoDegrees { name, text, least, most } => {
            say("Line {line}: {name} \"{text}\" is not within {least} to {most} degrees.")
                .with("name", name)
                .with("text", text)
                .with("least", least)
                .with("most", most)
        }
        LineTrouble::NoSpeed { name, text } => {
            say("Line {line}: {name} \"{text}\" is not a speed in m/s. Leave it empty where it is not known.")
                .with("name", name)
                .with("text", text)
        }
        LineTrouble::Twice { first } => {
            say("Line {line}: the same time and place as in line {first}. Remove one.").with("first", first)
        }
    };
    text.with("line", line).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(lines: &[&str]) -> std::result::Result<SeaRouteCurrentGrid, String> {
        let text = format!("{}\n{}", COLUMNS.join(","), lines.join("\n"));
        of_file(text.as_bytes()).map_err(|said| said.to_string())
    }

    #[test]
    fn speeds_are_rounded_and_what_is_not_known_stays_so() {
        let line = |lat: i32, lon: i32, flow: &str| format!("2026-11-21T07:00+01:00,{lat},{lon},{flow}");
        let lines = [
            line(63, 10, "0.123456,0"),
            line(63, 11, ",0"),
            line(64, 10, "nan,-0.00004"),
            line(64, 11, "1,2"),
        ];
        let of = csv(&lines.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
        assert_eq!(of.times_us, [1_795_240_800_000_000]);
        assert_eq!(of.east_mps, [Some(0.1235), None, None, Some(1.0)]);
        assert_eq!(of.north_mps[2], Some(0.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let one = "2026-11-21T06:00:00Z,63,10,0,0";
        for (lines, why) in [
            (&["now,63,10,0,0"][..], "Line 2: \"now\" is not a time"),
            (&["", "2026-11-21T06:00:00Z,93,10,0,0"], "Line 3: lat \"93\" is not within -90 to 90 degrees"),
            (&["2026-11-21T06:00:00Z,63,10,fast,0"], "Line 2: east_mps \"fast\" is not a speed"),
            (&["2026-11-21T06:00:00Z,63,10,0"], "Line 2: it ends before north_mps"),
            (&[one], "two latitudes"),
        ] {
            let text = csv(lines).unwrap_err();
            assert!(text.contains(why), "{text}");
        }
        let heading = of_file(b"time,lat,lon,u,v\n").unwrap_err().to_string();
        assert!(
            heading.starts_with("Line 1: there is no column east_mps. Begin the file with time,"),
            "{heading}"
        );
        let corners = ["63,10", "63,11", "64,10", "64,11"];
        let rows: Vec<String> = corners.map(|at| format!("2026-11-21T06:00Z,{at},0,0")).into();
        let twice: Vec<&str> = rows.iter().map(String::as_str).chain([rows[2].as_str()]).collect();
        assert!(csv(&twice).unwrap_err().contains("Line 6: the same time and place as in line 4"));
        let large: Vec<String> = (0..160_000)
            .map(|n| {
                format!("2026-11-21T06:00Z,{},{},0,0", f64::from(n / 400) / 10.0, f64::from(n % 400) / 10.0)
            })
            .collect();
        let text = csv(&large.iter().map(String::as_str).collect::<Vec<_>>()).unwrap_err();
        assert!(text.contains("160000 crossings"), "{text}");
        assert!(of_file(b"\x89HDF\r\n").unwrap_err().to_string().contains("nccopy -k classic"));
    }
}
