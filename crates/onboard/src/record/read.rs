//! Bytes to inputs and outputs.

use crate::entity::Entity;
use crate::grounding::ChartFile;
use crate::input::{DeviceState, HostReading, Input, Reachable};
use crate::lease::{Lease, Mandate};
use crate::peer::Peer;
use crate::routing::{FoundRoute, RouteAnswer};
use crate::states::Condition;
use charts::depth_index::DepthIndex;
use devices::{
    BatteryReading, ClockState, GnssFix, GnssReading, GroundVelocity, MotorReading, Part,
    PowerChannelReading, PulseReading, Quality, RailReading, Reading, ReceiverReading, Side, TagReading,
    TroubleReading, WaterReading,
};
use mission::Ticket;
use std::net::SocketAddrV4;
use std::time::Duration;
use units::{LatLon, MonoTime, Now, UtcTime};

/// Bytes that are not a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the recording is damaged or of another version")]
pub struct Garbled;

struct Take<'a>(&'a [u8]);

impl<'a> Take<'a> {
    fn slice(&mut self, length: usize) -> Result<&'a [u8], Garbled> {
        let (head, rest) = self.0.split_at_checked(length).ok_or(Garbled)?;
        self.0 = rest;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Garbled> {
        self.slice(N)?.try_into().map_err(|_| Garbled)
    }

    fn u8(&mut self) -> Result<u8, Garbled> {
        self.array::<1>().map(|bytes| bytes[0])
    }

    fn flag(&mut self) -> Result<bool, Garbled> {
        match self.u8()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Garbled),
        }
    }

    fn u16(&mut self) -> Result<u16, Garbled> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Garbled> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Garbled> {
        self.array().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, Garbled> {
        self.array().map(u64::from_le_bytes).map(f64::from_bits)
    }

    fn utc(&mut self) -> Result<UtcTime, Garbled> {
        self.array().map(i64::from_le_bytes).map(UtcTime::from_micros)
    }

    fn bytes(&mut self) -> Result<&'a [u8], Garbled> {
        let length = self.u32()?;
        self.slice(usize::try_from(length).map_err(|_| Garbled)?)
    }

    fn text(&mut self) -> Result<String, Garbled> {
        String::from_utf8(self.bytes()?.to_vec()).map_err(|_| Garbled)
    }

    fn option<T>(
        &mut self,
        take: impl FnOnce(&mut Self) -> Result<T, Garbled>,
    ) -> Result<Option<T>, Garbled> {
        if self.flag()? { take(self).map(Some) } else { Ok(None) }
    }

    fn place(&mut self) -> Result<LatLon, Garbled> {
        LatLon::from_rad(self.f64()?, self.f64()?).map_err(|_| Garbled)
    }

    fn socket(&mut self) -> Result<SocketAddrV4, Garbled> {
        let ip: [u8; 4] = self.array()?;
        Ok(SocketAddrV4::new(ip.into(), self.u16()?))
    }

    fn sockets(&mut self) -> Result<Vec<SocketAddrV4>, Garbled> {
        (0..self.u32()?).map(|_| self.socket()).collect()
    }

    fn peer(&mut self) -> Result<Peer, Garbled> {
        match self.u8()? {
            0 => self.socket().map(Peer::Udp),
            1 => self.u32().map(Peer::Tcp),
            _ => Err(Garbled),
        }
    }
}

/// Reads one input and its moment, and the whole of `bytes` with it.
///
/// # Errors
/// When the bytes are not a record of this version.
pub fn read_input(bytes: &[u8]) -> Result<(Now, Input), Garbled> {
    let mut take = Take(bytes);
    let now = Now { mono: MonoTime::from_micros(take.array().map(u64::from_le_bytes)?), utc: take.utc()? };
    let input = input(&mut take)?;
    if take.0.is_empty() { Ok((now, input)) } else { Err(Garbled) }
}

fn input(take: &mut Take<'_>) -> Result<Input, Garbled> {
    Ok(match take.u8()? {
        0 => Input::Timer,
        kind @ (1..=5 | 19 | 20 | 22 | 24 | 25) => {
            let at = MonoTime::from_micros(take.u64()?);
            Input::Reading(at, reading(take, kind)?)
        }
        21 => Input::Device(DeviceState {
            entity: Entity::from_number(take.u8()?).ok_or(Garbled)?,
            condition: condition(take.u8()?)?,
            text: take.text()?,
        }),
        23 => Input::Warning(Entity::from_number(take.u8()?).ok_or(Garbled)?, take.text()?),
        6 => Input::Host(HostReading {
            cpu_percent: take.f64()?,
            disk_free_mib: take.f64()?,
            disk_free_percent: take.f64()?,
            memory_mib: take.f64()?,
            computer_cpu_percent: take.option(Take::f64)?,
            memory_free_percent: take.option(Take::f64)?,
            temperature_c: take.option(Take::f64)?,
        }),
        7 => Input::Packet(take.peer()?, take.bytes()?.to_vec()),
        8 => Input::Connected(take.peer()?),
        9 => Input::Disconnected(take.peer()?),
        10 => Input::Reachable(Reachable { udp: take.sockets()?, tcp: take.sockets()? }),
        11 => Input::LogOpened(if take.flag()? { Ok(take.text()?) } else { Err(take.text()?) }),
        12 => Input::NotKept(take.text()?),
        13 => Input::Shutdown,
        14 => {
            let ticket = Ticket(take.array().map(u64::from_le_bytes)?);
            let ok = take.flag()?;
            let text = take.text()?;
            Input::Stored(ticket, if ok { Ok(()) } else { Err(text) })
        }
        15 => {
            let (peer, lease, command) = (take.peer()?, take.u64()?, take.u64()?);
            Input::Order(peer, Mandate { lease, command }, take.bytes()?.to_vec())
        }
        16 => {
            let (epoch, lasts) = (take.u64()?, Duration::from_micros(take.u64()?));
            Input::Lease(Lease { epoch, lasts, holder: take.text()? })
        }
        17 => {
            let label = take.text()?;
            let ok = take.flag()?;
            let text = take.text()?;
            Input::ParametersKept(label, if ok { Ok(()) } else { Err(text) })
        }
        18 => {
            let (name, digest) = (take.text()?, take.array()?);
            let index = DepthIndex::from_bytes(take.bytes()?).map_err(|_| Garbled)?;
            Input::Chart(ChartFile::whole(name, digest, index))
        }
        26 => Input::Route(route(take)?),
        _ => return Err(Garbled),
    })
}

fn route(take: &mut Take<'_>) -> Result<RouteAnswer, Garbled> {
    let (number, found) = (take.u32()?, take.flag()?);
    let outcome = if found {
        let places = (0..take.u32()?).map(|_| take.place()).collect::<Result<_, _>>()?;
        Ok(FoundRoute { places, length_m: take.f64()?, start_moved: take.flag()? })
    } else {
        Err(take.text()?)
    };
    Ok(RouteAnswer { number, outcome })
}

fn condition(number: u8) -> Result<Condition, Garbled> {
    let all = [Condition::Boot, Condition::Normal, Condition::Fault, Condition::Error, Condition::Failure];
    all.into_iter().find(|condition| *condition as u8 == number).ok_or(Garbled)
}

/// A reading, by the kinds 1 to 5, 19, 20 and from 22 on of inputs.
fn reading(take: &mut Take<'_>, kind: u8) -> Result<Reading, Garbled> {
    Ok(match kind {
        1 => Reading::Gnss(gnss(take)?),
        2 => {
            let side = if take.flag()? { Side::Starboard } else { Side::Port };
            let reading =
                MotorReading { propeller_rpm: take.f64()?, power_w: take.f64()?, temperature_c: take.f64()? };
            Reading::Motor(side, reading)
        }
        3 => Reading::Battery(BatteryReading {
            number: take.u8()?,
            voltage_v: take.f64()?,
            current_a: take.f64()?,
            charge_percent: take.f64()?,
            temperature_c: take.f64()?,
        }),
        4 => Reading::Tag(TagReading {
            serial: take.u32()?,
            clock_s: take.u32()?,
            millis: take.u16()?,
            protocol: take.text()?,
            tag_id: take.u32()?,
            data: take.option(Take::u16)?,
            snr_db: take.u8()?,
            frequency_khz: take.u8()?,
            counter: take.u16()?,
            raw: take.option(Take::text)?,
            lines_lost: take.option(Take::u16)?,
        }),
        19 => Reading::Rail(RailReading {
            number: take.u8()?,
            voltage_v: take.f64()?,
            current_a: take.f64()?,
            fuse_a: take.f64()?,
            flags: take.u8()?,
        }),
        20 => Reading::PowerChannel(PowerChannelReading {
            rail: take.u8()?,
            name: take.text()?,
            on: take.flag()?,
        }),
        24 => Reading::Pulse(PulseReading { utc: take.utc()?, sequence: take.u32()? }),
        25 => {
            let part = match (take.u8()?, take.u8()?) {
                (0, 0) => Part::Motor(Side::Port),
                (0, 1) => Part::Motor(Side::Starboard),
                (1, number) => Part::Battery(number),
                _ => return Err(Garbled),
            };
            Reading::Trouble(TroubleReading { part, text: take.text()? })
        }
        22 => Reading::Receiver(ReceiverReading {
            listening: take.flag()?,
            frequency_khz: take.option(Take::u8)?,
            protocols: take.option(Take::u8)?,
            clock: match take.u8()? {
                0 => ClockState::Unknown,
                1 => ClockState::Unset,
                2 => ClockState::Set,
                3 => ClockState::Disciplined,
                4 => ClockState::Lost,
                _ => return Err(Garbled),
            },
            clock_offset_s: take.option(Take::f64)?,
            clock_fault: take.text()?,
        }),
        5 => Reading::Water(WaterReading {
            serial: take.u32()?,
            clock_s: take.u32()?,
            temperature_c: take.f64()?,
            noise_average: take.u8()?,
            noise_peak: take.u8()?,
            frequency_khz: take.u8()?,
            counter: take.u16()?,
            lines_lost: take.option(Take::u16)?,
        }),
        _ => return Err(Garbled),
    })
}

fn gnss(take: &mut Take<'_>) -> Result<GnssReading, Garbled> {
    Ok(GnssReading {
        utc: take.option(Take::utc)?,
        fix: take.option(|take| {
            let (lat_rad, lon_rad) = (take.f64()?, take.f64()?);
            let (height_m, hdop) = (take.f64()?, take.f64()?);
            let quality = match take.u8()? {
                0 => Quality::Autonomous,
                1 => Quality::Differential,
                2 => Quality::RtkFixed,
                3 => Quality::RtkFloat,
                4 => Quality::Estimated,
                _ => return Err(Garbled),
            };
            Ok(GnssFix { lat_rad, lon_rad, height_m, hdop, quality })
        })?,
        satellites: take.u8()?,
        velocity: take
            .option(|take| Ok(GroundVelocity { course_rad: take.f64()?, speed_mps: take.f64()? }))?,
        heading_rad: take.option(Take::f64)?,
        yaw_rate_rad_s: take.option(Take::f64)?,
        roll_rad: take.option(Take::f64)?,
        pitch_rad: take.option(Take::f64)?,
        magnetic_heading_rad: take.option(Take::f64)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::write_input;
    use proptest::prelude::*;

    fn readings() -> Vec<Reading> {
        let fix =
            GnssFix { lat_rad: 1.1, lon_rad: 0.2, height_m: 40.0, quality: Quality::RtkFloat, hdop: 0.9 };
        vec![
            Reading::Receiver(ReceiverReading {
                listening: true,
                frequency_khz: Some(69),
                protocols: None,
                clock: ClockState::Lost,
                clock_offset_s: Some(3.6),
                clock_fault: "set at the next mark".into(),
            }),
            Reading::Gnss(GnssReading {
                utc: Some(UtcTime::from_micros(5)),
                fix: Some(fix),
                satellites: 8,
                velocity: Some(GroundVelocity { course_rad: 0.1, speed_mps: 1.5 }),
                heading_rad: None,
                yaw_rate_rad_s: Some(-0.1),
                roll_rad: Some(0.02),
                pitch_rad: None,
                magnetic_heading_rad: Some(1.5),
            }),
            Reading::Motor(
                Side::Starboard,
                MotorReading { propeller_rpm: 500.0, power_w: 90.0, temperature_c: 30.0 },
            ),
            Reading::Battery(BatteryReading { number: 3, voltage_v: 29.0, ..BatteryReading::default() }),
            Reading::Tag(TagReading {
                protocol: "S64K".into(),
                data: Some(7),
                raw: Some("$001129,1551087572,897,S64K,15,7,33,69,1".into()),
                ..TagReading::default()
            }),
            Reading::Rail(RailReading {
                number: 4,
                voltage_v: 5.0,
                current_a: -0.003,
                fuse_a: 17.5,
                flags: 3,
            }),
            Reading::PowerChannel(PowerChannelReading { rail: 3, name: "H_VR0".into(), on: true }),
            Reading::Water(WaterReading { temperature_c: 8.0, ..WaterReading::default() }),
            Reading::Pulse(PulseReading { utc: UtcTime::from_micros(1_600_000_000_000_123), sequence: 9 }),
            Reading::Trouble(TroubleReading { part: Part::Motor(Side::Starboard), text: "hot".into() }),
            Reading::Trouble(TroubleReading { part: Part::Battery(3), text: String::new() }),
        ]
    }

    fn examples() -> Vec<Input> {
        let socket = SocketAddrV4::new([10, 0, 2, 7].into(), 6002);
        let others = vec![
            Input::Timer,
            Input::Warning(Entity::Hydrophone, "7 lines lost".into()),
            Input::Device(DeviceState {
                entity: Entity::Hydrophone,
                condition: Condition::Error,
                text: "no answer".into(),
            }),
            Input::Host(HostReading {
                computer_cpu_percent: Some(12.5),
                temperature_c: Some(50.0),
                ..HostReading::default()
            }),
            Input::Packet(Peer::Udp(socket), vec![1, 2, 3]),
            Input::Connected(Peer::Tcp(3)),
            Input::Disconnected(Peer::Tcp(3)),
            Input::Reachable(Reachable { udp: vec![socket], tcp: vec![] }),
            Input::LogOpened(Ok("20261121/074327".into())),
            Input::LogOpened(Err("disk full".into())),
            Input::NotKept("plan".into()),
            Input::Stored(Ticket(3), Ok(())),
            Input::Stored(Ticket(4), Err("disk full".into())),
            Input::ParametersKept("Path Control".into(), Ok(())),
            Input::ParametersKept("Path Control".into(), Err("disk full".into())),
            Input::Shutdown,
            Input::Order(Peer::Tcp(3), Mandate { lease: 1 << 50, command: 1 << 41 }, vec![1, 2, 3]),
            Input::Lease(Lease { epoch: 7, lasts: Duration::from_secs(30), holder: "nils".into() }),
            Input::Chart(ChartFile::whole("sea".into(), [7; 32], DepthIndex::default())),
            Input::Route(RouteAnswer { number: 3, outcome: Err("land".into()) }),
            Input::Route(RouteAnswer {
                number: 4,
                outcome: Ok(FoundRoute {
                    places: vec![LatLon::from_deg(63.33, 10.08).unwrap(); 3],
                    length_m: 1_200.0,
                    start_moved: true,
                }),
            }),
        ];
        let at = MonoTime::from_micros(70);
        readings().into_iter().map(|reading| Input::Reading(at, reading)).chain(others).collect()
    }

    #[test]
    fn what_is_written_reads_back_and_nothing_shorter_does() {
        let now = Now { mono: MonoTime::from_micros(77), utc: UtcTime::from_micros(-9) };
        for input in examples() {
            let mut bytes = Vec::new();
            write_input(&mut bytes, now, &input);
            assert_eq!(read_input(&bytes), Ok((now, input)));
            for length in 0..bytes.len() {
                assert_eq!(read_input(&bytes[..length]), Err(Garbled));
            }
        }
    }

    #[test]
    fn what_is_no_number_survives() {
        let reading = GnssReading { heading_rad: Some(f64::NAN), ..GnssReading::default() };
        let now = Now { mono: MonoTime::default(), utc: UtcTime::default() };
        let (mut bytes, mut again) = (Vec::new(), Vec::new());
        write_input(&mut bytes, now, &Input::Reading(now.mono, Reading::Gnss(reading)));
        let (now, input) = read_input(&bytes).unwrap();
        write_input(&mut again, now, &input);
        assert_eq!(bytes, again);
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = read_input(&bytes);
        }
    }
}
