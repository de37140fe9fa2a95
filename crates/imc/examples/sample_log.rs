//! Writes a log of ten minutes at sea: `cargo run -p imc --example sample_log -- FOLDER`.
//!
//! An Otter sails a square at 1 m/s around a tagged fish. The figures are made up and always the same; the
//! folder is laid out as one of a real vehicle. The name of the log is printed.

use imc::lsf::{LogOptions, LogWriter};
use imc::messages::{
    EntityInfo, EntityState, EntityStateState, EstimatedState, FuelLevel, Goto, GpsFix, GpsFixValidity,
    PlanControlState, PlanControlStateState, PlanManeuver, PlanSpecification, PlanTransition, Rpm,
    TBRFishTag, TBRFishTagTransProtocol, TBRSensor, Voltage, ZUnits,
};
use imc::{Address, Header, Payload};
use std::path::Path;
use units::{LatLon, LocalFrame, LocalPoint, UtcTime};

const OTTER: Address = Address(0x2810);
const ENTITIES: [&str; 8] = [
    "Daemon",
    "GPS",
    "Navigation",
    "Plan Engine",
    "Motor - Port",
    "Motor - Starboard",
    "Battery",
    "Hydrophone",
];
/// 2026-06-01 10:00 UTC.
const START_US: i64 = 1_780_308_000_000_000;
const SECONDS: u32 = 600;
const SPEED_MPS: f64 = 1.0;
const SIDE_M: f64 = 100.0;
/// South, a little less than π: as a single π would be beyond the range of headings.
const SOUTH_RAD: f64 = std::f64::consts::PI - 1e-6;
const SOUND_MPS: f64 = 1_480.0;

struct Otter {
    log: LogWriter,
    buffer: Vec<u8>,
    now: UtcTime,
}

impl Otter {
    fn say<T: Payload>(&mut self, entity: &str, message: &T) -> std::io::Result<()> {
        let number = ENTITIES.iter().position(|label| *label == entity).unwrap_or(255);
        let header =
            Header { timestamp: self.now.seconds(), src: OTTER, src_ent: number as u8, ..Header::default() };
        self.buffer.clear();
        imc::encode_into(&mut self.buffer, &header, message).map_err(std::io::Error::other)?;
        self.log.write(&self.buffer)
    }
}

/// Where the square is after so many metres, and the heading there (rad).
fn on_square(sailed_m: f64) -> (LocalPoint, f64) {
    let along_m = sailed_m % SIDE_M;
    match (sailed_m / SIDE_M) as u32 % 4 {
        0 => (LocalPoint { north_m: along_m, east_m: 0.0 }, 0.0),
        1 => (LocalPoint { north_m: SIDE_M, east_m: along_m }, std::f64::consts::FRAC_PI_2),
        2 => (LocalPoint { north_m: SIDE_M - along_m, east_m: SIDE_M }, SOUTH_RAD),
        _ => (LocalPoint { north_m: 0.0, east_m: SIDE_M - along_m }, -std::f64::consts::FRAC_PI_2),
    }
}

fn plan(frame: &LocalFrame) -> PlanSpecification {
    let corner = |at: u32| format!("corner{at}");
    let goto = |at: u32| {
        let place = frame.to_place(on_square(SIDE_M * f64::from(at)).0);
        let (lat, lon) = (place.lat_rad(), place.lon_rad());
        let data = Goto { lat, lon, z_units: ZUnits::Depth, speed: SPEED_MPS as f32, ..Goto::default() };
        PlanManeuver { maneuver_id: corner(at).into(), data: data.into(), ..PlanManeuver::default() }
    };
    let next = |at: u32| PlanTransition {
        source_man: corner(at).into(),
        dest_man: corner(at % 4 + 1).into(),
        conditions: "ManeuverIsDone".into(),
        ..PlanTransition::default()
    };
    PlanSpecification {
        plan_id: "square".into(),
        start_man_id: corner(1).into(),
        maneuvers: (1..=4).map(goto).collect(),
        transitions: (1..=4).map(next).collect(),
        ..PlanSpecification::default()
    }
}

fn introduce(otter: &mut Otter, frame: &LocalFrame) -> std::io::Result<()> {
    for (id, label) in ENTITIES.iter().enumerate() {
        let info = EntityInfo { id: id as u8, label: (*label).into(), ..EntityInfo::default() };
        otter.say(label, &info)?;
    }
    otter.say("Plan Engine", &plan(frame))
}

fn each_second(otter: &mut Otter, second: u32, place: LatLon, heading_rad: f64) -> std::io::Result<()> {
    let fix = GpsFix {
        validity: GpsFixValidity::VALID_POS | GpsFixValidity::VALID_SOG | GpsFixValidity::VALID_COG,
        lat: place.lat_rad(),
        lon: place.lon_rad(),
        satellites: 14,
        cog: heading_rad as f32,
        sog: SPEED_MPS as f32,
        ..GpsFix::default()
    };
    otter.say("GPS", &fix)?;
    let turn = (f64::from(second) / 7.0).sin();
    for (motor, sign) in [("Motor - Port", 1.0), ("Motor - Starboard", -1.0)] {
        otter.say(motor, &Rpm { value: (570.0 + sign * 25.0 * turn) as i16 })?;
    }
    for label in ENTITIES {
        let state = EntityState { state: EntityStateState::Normal, ..EntityState::default() };
        otter.say(label, &EntityState { description: "active".into(), ..state })?;
    }
    let battery = 92.0 - f64::from(second) / 300.0;
    otter.say("Battery", &FuelLevel { value: battery as f32, confidence: 100.0, ..FuelLevel::default() })?;
    otter.say("Battery", &Voltage { value: (24.0 + battery / 25.0) as f32 })?;
    let state = PlanControlState {
        state: PlanControlStateState::Executing,
        plan_id: "square".into(),
        plan_eta: -1,
        plan_progress: -1.0,
        man_id: format!("corner{}", second / 100 % 4 + 1).into(),
        man_type: Goto::ID,
        ..PlanControlState::default()
    };
    otter.say("Plan Engine", &state)
}

/// The fish swims in the middle of the square and is heard some 30 s apart.
fn listen(otter: &mut Otter, second: u32, at: LocalPoint, place: LatLon, heard: u16) -> std::io::Result<()> {
    let swum = f64::from(second) / 40.0;
    let fish = LocalPoint { north_m: 55.0 + 8.0 * swum.sin(), east_m: 45.0 + 8.0 * swum.cos() };
    let range_m = at.distance_m(fish);
    let travel_ms = (range_m / SOUND_MPS * 1e3) as u16;
    let tag = TBRFishTag {
        serial_no: 1_200,
        unix_timestamp: otter.now.seconds() as u32,
        millis: travel_ms,
        trans_protocol: TBRFishTagTransProtocol::S256,
        trans_id: 42,
        trans_data: 57 + heard % 5,
        snr: (40.0 - range_m / 5.0) as u8,
        trans_freq: 69,
        recv_mem_addr: heard,
        lat: Some(place.lat_rad()),
        lon: Some(place.lon_rad()),
    };
    otter.say("Hydrophone", &tag)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: sample_log FOLDER")?;
    let start = UtcTime::from_micros(START_US);
    let options = LogOptions { system: OTTER, entity: 0, compress: true, config: String::new() };
    let log = LogWriter::create(Path::new(&folder), start, "square", options)?;
    println!("{}", log.folder().display());
    let origin = LatLon::from_deg(63.440_6, 10.353_5)?;
    let frame = LocalFrame::new(origin);
    let mut otter = Otter { log, buffer: Vec::new(), now: start };
    introduce(&mut otter, &frame)?;
    let mut heard = 0;
    for tenth in 0..SECONDS * 10 {
        otter.now = UtcTime::from_micros(START_US + i64::from(tenth) * 100_000);
        let (at, heading_rad) = on_square(f64::from(tenth) * 0.1 * SPEED_MPS);
        let state = EstimatedState {
            lat: origin.lat_rad(),
            lon: origin.lon_rad(),
            x: at.north_m as f32,
            y: at.east_m as f32,
            psi: heading_rad as f32,
            u: SPEED_MPS as f32,
            vx: (SPEED_MPS * heading_rad.cos()) as f32,
            vy: (SPEED_MPS * heading_rad.sin()) as f32,
            depth: -1.0,
            alt: -1.0,
            ..EstimatedState::default()
        };
        otter.say("Navigation", &state)?;
        if tenth % 10 == 0 {
            let (second, place) = (tenth / 10, frame.to_place(at));
            each_second(&mut otter, second, place, heading_rad)?;
            if second % 29 == 11 {
                listen(&mut otter, second, at, place, heard)?;
                heard += 1;
            }
            if second % 300 == 60 {
                let sensor = TBRSensor {
                    serial_no: 1_200,
                    unix_timestamp: otter.now.seconds() as u32,
                    temperature: 8.4,
                    avg_noise_level: 12,
                    peak_noise_level: 31,
                    recv_listen_freq: 69,
                    recv_mem_addr: heard,
                };
                otter.say("Hydrophone", &sensor)?;
                heard += 1;
            }
        }
    }
    let end = otter.now;
    otter.log.finish(end)?;
    Ok(())
}
