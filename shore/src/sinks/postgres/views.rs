//! What people ask: each detection once, with the vessel's name and its place, as a geometry where PostGIS is there.

use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;

/// What any of the reports may say.
const FUSED: [&str; 7] =
    ["data", "lines_lost", "noise_average", "noise_peak", "noise_age_s", "propeller_rpm", "raw"];

/// Makes the view `detections` of a schema. Of several reports of one detection it has what they say together, by the rules of
/// [`detections::fused`]: a clock that is known to be bad counts as bad, and a place with its age or deviation goes before one
/// without. With the schema that PostGIS is installed in, it has the place as a point in WGS 84 as well.
pub(super) fn detections(schema: &str, postgis: Option<&str>) -> String {
    let mut fused = String::new();
    for column in FUSED {
        write!(fused, ", max({column}) AS {column}").ok();
    }
    // The place of the report that says most of it.
    for column in ["lat_deg", "lon_deg", "pose_age_s", "pose_sigma_m"] {
        write!(
            fused,
            ", (array_agg({column} ORDER BY lat_deg IS NULL, pose_age_s IS NULL AND pose_sigma_m IS NULL, hash))[1] AS {column}"
        )
        .ok();
    }
    // A packet without a time counts as said when it came, as on the pages.
    let time = "CASE WHEN time = '-infinity' THEN received ELSE time END";
    let place = postgis.map_or_else(String::new, |postgis| {
        format!(
            ", \"{postgis}\".ST_SetSRID(\"{postgis}\".ST_MakePoint(lon_deg, lat_deg), 4326)::\"{postgis}\".geometry(Point,4326) AS place"
        )
    });
    format!(
        "CREATE OR REPLACE VIEW \"{schema}\".detections AS SELECT d.time, CASE WHEN clock >= 2 THEN clock_time END AS heard, \
         protocol || '-' || tag AS tag_name, protocol, tag, data, snr_db, frequency_khz, receiver, line, \
         (ARRAY['not set', 'lost', 'set', 'disciplined'])[clock + 1] AS clock, v.name AS vessel, d.src, src_ent, received, \
         lat_deg, lon_deg, pose_age_s, pose_sigma_m, lines_lost, noise_average, noise_peak, noise_age_s, propeller_rpm, raw{place}, maker \
         FROM (SELECT {time} AS time, src, src_ent, receiver, maker, clock_time, protocol, tag, min(received) AS received, \
         NULLIF(max(snr_db), 0) AS snr_db, NULLIF(max(frequency_khz), 0) AS frequency_khz, min(line) AS line, \
         CASE WHEN min(clock_state) < 2 THEN min(clock_state) ELSE max(clock_state) END AS clock{fused} \
         FROM \"{schema}\".detection_reports GROUP BY {time}, src, src_ent, receiver, maker, clock_time, protocol, tag) d \
         LEFT JOIN \"{schema}\".vessels v ON v.src = d.src"
    )
}

/// With these words begins the comment of a view that Lutra made, of any version.
pub(super) const OWN: &str = "Each detection of a tag once";

/// What people read of it in the database, and by which definition it was made: so a later version of Lutra knows whether it has
/// another.
pub(super) fn comment(schema: &str, definition: &str) -> String {
    format!(
        "COMMENT ON VIEW \"{schema}\".detections IS '{OWN}: time when the vessel reported it, heard by the \
         receiver''s clock where that was set ({})'",
        mark(definition)
    )
}

/// What stands in the comment of a view that was made by this definition.
pub(super) fn mark(definition: &str) -> String {
    format!("definition {}", &hex::encode(Sha256::digest(definition))[..16])
}
