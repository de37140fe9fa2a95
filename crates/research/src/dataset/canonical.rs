//! The canonical CSV of datasets: the format `lutra`, whose bytes are published by their SHA-256.

/// Its number. It changes with any byte that the format `lutra` writes otherwise for the same detections and register, so that a
/// file that another version of Lutra wrote is not taken for a changed archive.
///
/// 2: an unknown ratio of signal to noise, or carrier, is empty; 1 wrote 0 and 69.
pub const CANONICAL_FORMAT: u32 = 2;

/// The program that writes it.
pub const SOFTWARE: &str = concat!("Lutra ", env!("CARGO_PKG_VERSION"));

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::limits::tests::{detection, study};
    use crate::{LUTRA, Lag, Writer};

    #[test]
    fn the_canonical_bytes_change_only_with_their_number() {
        let mut writer = Writer::new(LUTRA, tables::Dialect::Plain);
        let study = study("temperature");
        let mut out = Vec::new();
        writer.header(&mut out).unwrap();
        let full = detection(63.432_123_4, 10.398_765_4);
        let mut bare = full.clone();
        (bare.pose, bare.data, bare.raw) = (None, None, None);
        (bare.snr_db, bare.frequency_khz) = (None, None);
        bare.tag_id = 102;
        for (one, lag) in [(&full, Lag::Seconds(61.5)), (&bare, Lag::Nothing), (&bare, Lag::Unknown)] {
            assert!(writer.row(&mut out, &study.heard(one, "otter, \"old\"", lag)).unwrap());
        }
        let text = String::from_utf8(out).unwrap();
        assert_eq!(
            (CANONICAL_FORMAT, text.as_str()),
            (2, include_str!("canonical-2.csv")),
            "give CANONICAL_FORMAT a new number"
        );
    }
}
