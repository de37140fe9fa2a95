//! The lines of the Thelma Biotel hydrophone, byte for byte.
//!
//! Layout: facts/onboard.md section 2.3 and facts/acoustics.md section 1.3. Lines begin with `$`, end in a
//! carriage return alone and have no checksum. The data field of a coding without data is empty. The running
//! number counts both kinds of line and wraps at 16 bits.

use crate::fish::TagProtocol;

/// A detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TagLine {
    /// Serial number of the receiver.
    pub serial: u32,
    /// The receiver's clock: Unix time once it is set, else seconds since power-up (s).
    pub clock_s: u32,
    /// Thousandths of a second of the same clock.
    pub millis: u16,
    /// Coding of the tag.
    pub protocol: TagProtocol,
    /// Number of the tag.
    pub tag_id: u32,
    /// The value sent, where the coding has one.
    pub data: Option<u16>,
    /// Signal to noise (dB).
    pub snr_db: u8,
    /// Carrier (kHz).
    pub frequency_khz: u8,
    /// Running number of the line.
    pub counter: u16,
}

/// A regular report of the water.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SensorLine {
    /// Serial number of the receiver.
    pub serial: u32,
    /// The receiver's clock (s).
    pub clock_s: u32,
    /// Temperature in tenths of a degree above -5 °C.
    pub temperature_raw: u16,
    /// Mean noise (receiver counts, dB-like).
    pub noise_average: u8,
    /// Peak noise (receiver counts, dB-like).
    pub noise_peak: u8,
    /// Frequency listened to (kHz).
    pub frequency_khz: u8,
    /// Running number of the line.
    pub counter: u16,
}

/// Anything the receiver sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HydrophoneLine {
    /// A detection.
    Tag(TagLine),
    /// A report of the water.
    Sensor(SensorLine),
}

impl HydrophoneLine {
    /// The whole line, from `$` to the carriage return.
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Tag(t) => {
                let data = t.data.map_or_else(String::new, |data| data.to_string());
                format!(
                    "${:06},{:010},{:03},{},{},{data},{},{},{}\r",
                    t.serial,
                    t.clock_s,
                    t.millis,
                    t.protocol.name(),
                    t.tag_id,
                    t.snr_db,
                    t.frequency_khz,
                    t.counter
                )
            }
            Self::Sensor(s) => format!(
                "${:06},{:010},TBR Sensor,{},{},{},{},{}\r",
                s.serial,
                s.clock_s,
                s.temperature_raw,
                s.noise_average,
                s.noise_peak,
                s.frequency_khz,
                s.counter
            ),
        }
        .into_bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_a_real_receiver() {
        // data/onboard/thelma_tblive_native_lines.txt, the ends of line apart.
        let tag = |clock_s, millis, protocol, tag_id, data, snr_db, counter| {
            let serial = 1_000_042;
            HydrophoneLine::Tag(TagLine {
                serial,
                clock_s,
                millis,
                protocol,
                tag_id,
                data,
                snr_db,
                frequency_khz: 69,
                counter,
            })
        };
        let sensor = HydrophoneLine::Sensor(SensorLine {
            serial: 1_000_042,
            clock_s: 600,
            temperature_raw: 297,
            noise_average: 15,
            noise_peak: 29,
            frequency_khz: 69,
            counter: 6,
        });
        for (line, expected) in [
            (sensor, "$1000042,0000000600,TBR Sensor,297,15,29,69,6\r"),
            (
                tag(2185, 897, TagProtocol::R64K, 1023, None, 24, 9),
                "$1000042,0000002185,897,R64K,1023,,24,69,9\r",
            ),
            (
                tag(1_623_050_485, 615, TagProtocol::S64K, 1285, Some(12), 24, 11),
                "$1000042,1623050485,615,S64K,1285,12,24,69,11\r",
            ),
        ] {
            assert_eq!(String::from_utf8(line.encode()).unwrap(), expected);
        }
    }
}
