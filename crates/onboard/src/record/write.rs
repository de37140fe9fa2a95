//! Inputs and outputs to bytes.

use crate::grounding::ChartFile;
use crate::input::{DeviceState, HostReading, Input, Reachable};
use crate::lease::Lease;
use crate::output::{Keep, Level, Output};
use crate::peer::Peer;
use crate::routing::{FoundRoute, RouteAnswer, RouteRequest};
use charts::depth_index::{ChartTrust, Demand};
use devices::{
    BatteryReading, ClockState, GnssReading, MotorReading, Part, PowerChannelReading, PulseReading, Quality,
    RailReading, Reading, ReceiverReading, Side, TagReading, TroubleReading, WaterReading,
};
use mission::{Change, Effect};
use std::net::SocketAddrV4;
use units::{LatLon, MonoTime, Now, UtcTime};

struct Put<'a>(&'a mut Vec<u8>);

impl Put<'_> {
    fn u8(&mut self, value: u8) {
        self.0.push(value);
    }

    fn u16(&mut self, value: u16) {
        self.0.extend(value.to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) {
        self.u64(value.to_bits());
    }

    fn numbers(&mut self, values: &[f64]) {
        for value in values {
            self.f64(*value);
        }
    }

    fn place(&mut self, place: LatLon) {
        self.numbers(&[place.lat_rad(), place.lon_rad()]);
    }

    fn utc(&mut self, value: UtcTime) {
        self.0.extend(value.micros().to_le_bytes());
    }

    fn bytes(&mut self, value: &[u8]) {
        // Packets and texts stay far below 4 GiB.
        self.u32(value.len() as u32);
        self.0.extend(value);
    }

    fn option<T>(&mut self, value: Option<T>, put: impl FnOnce(&mut Self, T)) {
        self.u8(u8::from(value.is_some()));
        if let Some(value) = value {
            put(self, value);
        }
    }

    fn socket(&mut self, socket: SocketAddrV4) {
        self.0.extend(socket.ip().octets());
        self.u16(socket.port());
    }

    fn outcome(&mut self, outcome: &Result<(), String>) {
        self.u8(u8::from(outcome.is_ok()));
        self.bytes(outcome.as_ref().map_or_else(String::as_bytes, |()| b""));
    }

    fn peer(&mut self, peer: Peer) {
        match peer {
            Peer::Udp(socket) => {
                self.u8(0);
                self.socket(socket);
            }
            Peer::Tcp(number) => {
                self.u8(1);
                self.u32(number);
            }
        }
    }
}

/// Appends an input and the moment it came.
pub fn write_input(out: &mut Vec<u8>, now: Now, input: &Input) {
    let mut put = Put(out);
    put.u64(now.mono.micros());
    put.utc(now.utc);
    match input {
        Input::Timer => put.u8(0),
        Input::Reading(at, one) => reading(&mut put, *at, one),
        Input::Host(reading) => {
            put.u8(6);
            let HostReading { cpu_percent, disk_free_mib, disk_free_percent, memory_mib, .. } = *reading;
            let HostReading { computer_cpu_percent, memory_free_percent, temperature_c, .. } = *reading;
            put.numbers(&[cpu_percent, disk_free_mib, disk_free_percent, memory_mib]);
            for known in [computer_cpu_percent, memory_free_percent, temperature_c] {
                put.option(known, Put::f64);
            }
        }
        Input::Packet(peer, bytes) => {
            put.u8(7);
            put.peer(*peer);
            put.bytes(bytes);
        }
        Input::Connected(peer) => {
            put.u8(8);
            put.peer(*peer);
        }
        Input::Disconnected(peer) => {
            put.u8(9);
            put.peer(*peer);
        }
        Input::Reachable(Reachable { udp, tcp }) => {
            put.u8(10);
            for sockets in [udp, tcp] {
                put.u32(sockets.len() as u32);
                for socket in sockets {
                    put.socket(*socket);
                }
            }
        }
        Input::LogOpened(outcome) => {
            put.u8(11);
            put.u8(u8::from(outcome.is_ok()));
            let (Ok(text) | Err(text)) = outcome;
            put.bytes(text.as_bytes());
        }
        Input::Stored(ticket, outcome) => {
            put.u8(14);
            put.u64(ticket.0);
            put.outcome(outcome);
        }
        Input::NotKept(what) => {
            put.u8(12);
            put.bytes(what.as_bytes());
        }
        Input::Shutdown => put.u8(13),
        Input::Order(peer, mandate, bytes) => {
            put.u8(15);
            put.peer(*peer);
            put.u64(mandate.lease);
            put.u64(mandate.command);
            put.bytes(bytes);
        }
        Input::Lease(Lease { epoch, lasts, holder }) => {
            put.u8(16);
            put.u64(*epoch);
            // Leases last minutes.
            put.u64(lasts.as_micros() as u64);
            put.bytes(holder.as_bytes());
        }
        Input::ParametersKept(label, outcome) => {
            put.u8(17);
            put.bytes(label.as_bytes());
            put.outcome(outcome);
        }
        Input::Device(DeviceState { entity, condition, text }) => {
            put.u8(21);
            put.u8(entity.number());
            put.u8(*condition as u8);
            put.bytes(text.as_bytes());
        }
        Input::Warning(entity, text) => {
            put.u8(23);
            put.u8(entity.number());
            put.bytes(text.as_bytes());
        }
        Input::Chart(file) => {
            put.u8(18);
            chart(&mut put, file);
        }
        Input::Route(answer) => {
            put.u8(26);
            route(&mut put, answer);
        }
    }
}

fn route(put: &mut Put<'_>, RouteAnswer { number, outcome }: &RouteAnswer) {
    put.u32(*number);
    put.u8(u8::from(outcome.is_ok()));
    match outcome {
        Ok(FoundRoute { places, length_m, start_moved }) => {
            // A route has far fewer corners than 32 bits count.
            put.u32(places.len() as u32);
            for place in places {
                put.place(*place);
            }
            put.f64(*length_m);
            put.u8(u8::from(*start_moved));
        }
        Err(why) => put.bytes(why.as_bytes()),
    }
}

fn reading(put: &mut Put<'_>, at: MonoTime, reading: &Reading) {
    put.u8(kind(reading));
    put.u64(at.micros());
    match reading {
        Reading::Gnss(reading) => gnss(put, reading),
        Reading::Motor(side, reading) => {
            put.u8(match side {
                Side::Port => 0,
                Side::Starboard => 1,
            });
            let MotorReading { propeller_rpm, power_w, temperature_c } = *reading;
            put.numbers(&[propeller_rpm, power_w, temperature_c]);
        }
        Reading::Battery(reading) => {
            let BatteryReading { number, voltage_v, current_a, charge_percent, temperature_c } = *reading;
            put.u8(number);
            put.numbers(&[voltage_v, current_a, charge_percent, temperature_c]);
        }
        Reading::Trouble(TroubleReading { part, text }) => {
            let (kind, number) = match part {
                Part::Motor(side) => (0, side.index()),
                Part::Battery(number) => (1, *number),
            };
            put.u8(kind);
            put.u8(number);
            put.bytes(text.as_bytes());
        }
        Reading::Tag(reading) => tag(put, reading),
        Reading::Water(reading) => water(put, reading),
        Reading::Receiver(reading) => receiver(put, reading),
        Reading::Rail(reading) => {
            let RailReading { number, voltage_v, current_a, fuse_a, flags } = *reading;
            put.u8(number);
            put.numbers(&[voltage_v, current_a, fuse_a]);
            put.u8(flags);
        }
        Reading::Pulse(PulseReading { utc, sequence }) => {
            put.utc(*utc);
            put.u32(*sequence);
        }
        Reading::PowerChannel(PowerChannelReading { rail, name, on }) => {
            put.u8(*rail);
            put.bytes(name.as_bytes());
            put.u8(u8::from(*on));
        }
    }
}

/// The kind of input that a reading is.
const fn kind(reading: &Reading) -> u8 {
    match reading {
        Reading::Gnss(_) => 1,
        Reading::Motor(..) => 2,
        Reading::Battery(_) => 3,
        Reading::Tag(_) => 4,
        Reading::Water(_) => 5,
        Reading::Rail(_) => 19,
        Reading::PowerChannel(_) => 20,
        Reading::Receiver(_) => 22,
        Reading::Pulse(_) => 24,
        Reading::Trouble(_) => 25,
    }
}

fn receiver(put: &mut Put<'_>, reading: &ReceiverReading) {
    put.u8(u8::from(reading.listening));
    put.option(reading.frequency_khz, Put::u8);
    put.option(reading.protocols, Put::u8);
    put.u8(match reading.clock {
        ClockState::Unknown => 0,
        ClockState::Unset => 1,
        ClockState::Set => 2,
        ClockState::Disciplined => 3,
        ClockState::Lost => 4,
    });
    put.option(reading.clock_offset_s, Put::f64);
    put.bytes(reading.clock_fault.as_bytes());
}

fn chart(put: &mut Put<'_>, file: &ChartFile) {
    put.bytes(file.name().as_bytes());
    put.0.extend(file.digest());
    put.bytes(&file.index().to_bytes());
}

fn gnss(put: &mut Put<'_>, reading: &GnssReading) {
    put.option(reading.utc, Put::utc);
    put.option(reading.fix, |put, fix| {
        put.numbers(&[fix.lat_rad, fix.lon_rad, fix.height_m, fix.hdop]);
        put.u8(match fix.quality {
            Quality::Autonomous => 0,
            Quality::Differential => 1,
            Quality::RtkFixed => 2,
            Quality::RtkFloat => 3,
            Quality::Estimated => 4,
        });
    });
    put.u8(reading.satellites);
    put.option(reading.velocity, |put, velocity| {
        put.numbers(&[velocity.course_rad, velocity.speed_mps]);
    });
    put.option(reading.heading_rad, Put::f64);
    put.option(reading.yaw_rate_rad_s, Put::f64);
    put.option(reading.roll_rad, Put::f64);
    put.option(reading.pitch_rad, Put::f64);
    put.option(reading.magnetic_heading_rad, Put::f64);
}

fn tag(put: &mut Put<'_>, reading: &TagReading) {
    put.u32(reading.serial);
    put.u32(reading.clock_s);
    put.u16(reading.millis);
    put.bytes(reading.protocol.as_bytes());
    put.u32(reading.tag_id);
    put.option(reading.data, Put::u16);
    put.u8(reading.snr_db);
    put.u8(reading.frequency_khz);
    put.u16(reading.counter);
    put.option(reading.raw.as_deref(), |put, raw| put.bytes(raw.as_bytes()));
    put.option(reading.lines_lost, Put::u16);
}

fn water(put: &mut Put<'_>, reading: &WaterReading) {
    put.u32(reading.serial);
    put.u32(reading.clock_s);
    put.f64(reading.temperature_c);
    put.u8(reading.noise_average);
    put.u8(reading.noise_peak);
    put.u8(reading.frequency_khz);
    put.u16(reading.counter);
    put.option(reading.lines_lost, Put::u16);
}

/// Appends an output.
pub fn write_output(out: &mut Vec<u8>, output: &Output) {
    let mut put = Put(out);
    match output {
        Output::Motors(motors) => {
            put.u8(0);
            put.f64(motors.port);
            put.f64(motors.starboard);
        }
        Output::Packet { bytes, to } => {
            put.u8(1);
            put.bytes(bytes);
            put.u32(to.len() as u32);
            for peer in to {
                put.peer(*peer);
            }
        }
        Output::Announce(bytes) => {
            put.u8(2);
            put.bytes(bytes);
        }
        Output::OpenLog { label, utc } => {
            put.u8(3);
            put.bytes(label.as_bytes());
            put.utc(*utc);
        }
        Output::CloseLog => put.u8(4),
        Output::Keep(what) => {
            put.u8(5);
            keep(&mut put, what);
        }
        Output::Power { channel, on } => {
            put.u8(7);
            put.bytes(channel.as_bytes());
            put.u8(u8::from(*on));
        }
        Output::Route(wanted) => {
            put.u8(8);
            put.option(wanted.as_deref(), request);
        }
        Output::Console(level, text) => {
            put.u8(6);
            put.u8(match level {
                Level::Debug => 0,
                Level::Info => 1,
                Level::Warning => 2,
                Level::Error => 3,
            });
            put.bytes(text.as_bytes());
        }
    }
}

fn request(put: &mut Put<'_>, request: &RouteRequest) {
    let RouteRequest { number, from, to, needs, zones: _, longest_m } = request;
    put.u32(*number);
    put.place(*from);
    put.place(*to);
    put.numbers(&[needs.clearance_m, *longest_m]);
    let Demand { water_level_m, draught_m, squat_m, reserve_m, air_draught_m, position_m, trust, entry } =
        needs.demand;
    put.numbers(&[water_level_m, draught_m, squat_m, reserve_m, position_m]);
    put.option(air_draught_m, Put::f64);
    // The errors that are accepted come from the program itself.
    put.u8(match trust {
        ChartTrust::AsCharted => 0,
        ChartTrust::DepthErrors(_) => 1,
        ChartTrust::AllErrors(_) => 2,
    });
    put.u8(entry.prohibited as u8);
    put.u8(entry.restricted as u8);
}

fn keep(put: &mut Put<'_>, keep: &Keep) {
    match keep {
        Keep::Plans(effect) => {
            put.u64(effect.ticket().0);
            match effect {
                Effect::Store { record, .. } => {
                    put.u8(0);
                    put.bytes(record.plan_id.as_bytes());
                    put.bytes(&record.bytes);
                    change(put, &record.change);
                }
                Effect::Remove { plan_id, change: by, .. } => {
                    put.u8(1);
                    put.bytes(plan_id.as_bytes());
                    change(put, by);
                }
                Effect::RemoveAll { change: by, .. } => {
                    put.u8(2);
                    change(put, by);
                }
            }
        }
        Keep::Parameters(label, values) => {
            put.u8(3);
            put.bytes(label.as_bytes());
            put.u32(values.len() as u32);
            for (name, value) in values {
                put.bytes(name.as_bytes());
                put.bytes(value.as_bytes());
            }
        }
        Keep::UnderWay(packet) => {
            put.u8(4);
            put.bytes(packet.as_deref().unwrap_or_default());
        }
    }
}

fn change(put: &mut Put<'_>, change: &Change) {
    put.utc(change.at);
    put.u16(change.system);
    put.bytes(change.name.as_bytes());
}
