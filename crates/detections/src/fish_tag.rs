//! The Otters' TBRFishTag (2007), of which those of 2019 have no position.

use crate::detection::{Detection, Effort, Origin, Pose, ReceiverClock};
use crate::protocol::Protocol;
use imc::messages::{TBRFishTag, TBRFishTagTransProtocol};
use units::LatLon;

impl Detection {
    /// The detection in a TBRFishTag.
    ///
    /// The message always has a data field: 0 means no data where the coding carries none. So it has the ratio of signal to noise
    /// and the carrier, where 0 means that the receiver does not say it: a tag that is not above the noise is not heard. Latitude
    /// and longitude 0/0 mean that the sender did not know its position. Whether the receiver's clock is set follows from its
    /// time stamp.
    pub fn from_fish_tag(origin: Origin, message: &TBRFishTag) -> Self {
        let protocol = Protocol::numbered(message.trans_protocol.value());
        let data = Some(message.trans_data).filter(|data| *data != 0 || !protocol.is_id_only());
        let place = message.lat.zip(message.lon).filter(|place| *place != (0.0, 0.0));
        let place = place.and_then(|(lat_rad, lon_rad)| LatLon::from_rad(lat_rad, lon_rad).ok());
        Self {
            origin,
            receiver: message.serial_no,
            maker: None,
            clock: ReceiverClock::read(message.unix_timestamp, message.millis),
            protocol,
            tag_id: message.trans_id,
            data,
            snr_db: Some(message.snr).filter(|snr_db| *snr_db != 0),
            frequency_khz: Some(message.trans_freq).filter(|khz| *khz != 0),
            line: message.recv_mem_addr,
            pose: place.map(|place| Pose { place, age_s: None, sigma_m: None }),
            effort: Effort::default(),
            raw: None,
        }
    }

    /// As a TBRFishTag; `None` where that would be false: IMC has no number for the coding, the clock was not set, or the
    /// receiver is of another maker than a file of our own vessels has.
    pub fn fish_tag(&self) -> Option<TBRFishTag> {
        let number = self.protocol.number()?;
        self.clock.utc()?;
        if self.maker.is_some() {
            return None;
        }
        let place = self.pose.map(|pose| pose.place);
        Some(TBRFishTag {
            serial_no: self.receiver,
            unix_timestamp: self.clock.seconds,
            millis: self.clock.millis,
            trans_protocol: TBRFishTagTransProtocol::from(number),
            trans_id: self.tag_id,
            trans_data: self.data.unwrap_or(0),
            snr: self.snr_db.unwrap_or(0),
            trans_freq: self.frequency_khz.unwrap_or(0),
            recv_mem_addr: self.line,
            lat: place.map(LatLon::lat_rad),
            lon: place.map(LatLon::lon_rad),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ClockState;
    use imc::Address;
    use units::UtcTime;

    fn told(message: &TBRFishTag) -> Detection {
        let reported = UtcTime::from_micros(1_795_248_004_000_000);
        Detection::from_fish_tag(
            Origin { system: Address(0x2810), entity: 9, reported, received: None },
            message,
        )
    }

    #[test]
    fn what_a_message_does_not_carry_is_absent() {
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: 1_795_248_000,
            millis: 250,
            trans_protocol: TBRFishTagTransProtocol::R64K,
            trans_id: 77,
            snr: 30,
            ..TBRFishTag::default()
        };
        let one = told(&tag);
        assert_eq!((one.data, one.pose, one.effort, &one.raw), (None, None, Effort::default(), &None));
        assert_eq!(one.clock.utc(), Some(UtcTime::from_micros(1_795_248_000_250_000)));
        assert_eq!(one.fish_tag().unwrap(), tag, "what it says is what it said");
        assert_eq!((one.snr_db, one.frequency_khz, one.maker), (Some(30), None, None), "0 is no carrier");
        assert_eq!(told(&TBRFishTag { snr: 0, ..tag.clone() }).snr_db, None, "as a VR2C aboard has it");
        let nowhere = TBRFishTag { lat: Some(0.0), lon: Some(0.0), ..tag.clone() };
        assert_eq!(told(&nowhere).pose, None);
        let no_place = TBRFishTag { lat: Some(f64::NAN), lon: Some(1.0), ..tag.clone() };
        assert_eq!(told(&no_place).pose, None);
        let somewhere = TBRFishTag { lat: Some(1.0), lon: Some(0.0), ..tag.clone() };
        let pose = told(&somewhere).pose.unwrap();
        assert_eq!((pose.place.lat_rad(), pose.age_s, pose.sigma_m), (1.0, None, None));
    }

    #[test]
    fn zero_is_a_measurement_only_of_a_tag_that_measures() {
        let data = |trans_protocol, trans_data| {
            told(&TBRFishTag { trans_protocol, trans_data, ..TBRFishTag::default() }).data
        };
        assert_eq!(data(TBRFishTagTransProtocol::S256, 0), Some(0));
        assert_eq!(data(TBRFishTagTransProtocol::R04K, 0), None);
        assert_eq!(data(TBRFishTagTransProtocol::R04K, 3), Some(3), "it was sent");
        assert_eq!(data(TBRFishTagTransProtocol::Unlisted(9), 0), Some(0), "nobody knows");
    }

    #[test]
    fn a_clock_that_was_never_set_gives_no_time_of_day() {
        let one = told(&TBRFishTag { unix_timestamp: 600, ..TBRFishTag::default() });
        assert_eq!((one.clock.state, one.clock.utc(), one.fish_tag()), (ClockState::NotSet, None, None));
        // 2000-01-01, where these receivers begin to count.
        let reset = told(&TBRFishTag { unix_timestamp: 946_684_800, ..TBRFishTag::default() });
        assert_eq!(reset.clock.state, ClockState::NotSet);
    }
}
