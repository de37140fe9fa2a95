//! The log book as CSV: RFC 4180, times in UTC by ISO 8601, one row for each note.

use api::LogNote;
use tables::Format;
use units::UtcTime;

/// The header line.
pub const CSV_HEAD: &str = "time_utc,vessel,latitude [deg],longitude [deg],text,author,written_utc,corrected_utc,\
                            corrected_by,withdrawn_utc,withdrawn_by,photo,note\n";

/// Appends the row of a note.
pub fn csv_row(out: &mut Vec<u8>, note: &LogNote) {
    let LogNote { corrected, withdrawn, .. } = note;
    let time = |us: i64| UtcTime::from_micros(us).to_string();
    let degrees = |angle: Option<f64>| angle.map_or_else(String::new, |angle| format!("{angle:.8}"));
    let vessel = note.vessel_name.clone().or_else(|| note.vessel.map(|vessel| format!("0x{vessel:04X}")));
    let when =
        |word: &Option<api::LogWord>| word.as_ref().map_or_else(String::new, |word| time(word.time_us));
    let who = |word: &Option<api::LogWord>| word.as_ref().map_or_else(String::new, |word| word.by.clone());
    // A spreadsheet must not run people's text as a formula. Only such text is escaped; numbers stay numbers.
    let cells = [
        (time(note.time_us), false),
        (vessel.unwrap_or_default(), true),
        (degrees(note.lat_deg), false),
        (degrees(note.lon_deg), false),
        (note.text.clone(), true),
        (note.by.clone(), true),
        (time(note.written_us), false),
        (when(corrected), false),
        (who(corrected), true),
        (when(withdrawn), false),
        (who(withdrawn), true),
        (note.photo.clone().unwrap_or_default(), false),
        (note.id.to_string(), false),
    ];
    for (at, (cell, guard)) in cells.iter().enumerate() {
        if at > 0 {
            out.push(b',');
        }
        tables::text(out, cell.as_bytes(), Format { guard: *guard, ..Format::default() });
    }
    out.push(b'\n');
}
