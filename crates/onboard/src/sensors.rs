//! Sensor values on their way to the bus, and the watch over their silence.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::navigation::{Estimate, Navigation, NavigationHealth, Rejection};
use crate::output::Level;
use crate::settings::WatchSettings;
use crate::states::{Condition, States};
use devices::{BatteryReading, GnssReading, MotorReading, Quality, Side};
use imc::messages::{
    AngularVelocity, Current, EstimatedState, EulerAngles, FuelLevel, GpsFix, GpsFixRejection,
    GpsFixRejectionReason, GpsFixType, GpsFixValidity, NavigationUncertainty, Rpm, Temperature, Voltage,
};
use std::time::Duration;
use units::MonoTime;

const SECONDS_OF_DAY: i64 = 86_400_000_000;

/// What is known of the sensors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sensors {
    gnss: Option<MonoTime>,
    rejection: Option<Rejection>,
    motors: [Option<MonoTime>; 2],
    batteries: [Option<(MonoTime, BatteryReading)>; 4],
    /// Which of them have fallen silent.
    silent: [bool; 4],
    /// The lowest charge since one fell silent (%).
    held_percent: Option<f64>,
    /// Energy taken from the batteries since the start (Wh).
    used_wh: f64,
    navigation: Option<NavigationHealth>,
}

impl Sensors {
    /// An epoch of the compass: to the bus as it came, and to navigation.
    pub(crate) fn gnss(&mut self, bus: &mut Bus, navigation: &mut Navigation, reading: &GnssReading) {
        self.gnss = Some(bus.mono());
        let fix = gps_fix(reading);
        bus.send(Entity::Gps, &fix);
        let time = bus.seconds();
        if let Some(heading_rad) = reading.heading_rad.filter(|value| value.is_finite()) {
            let angles = EulerAngles { time, psi: heading_rad, ..EulerAngles::default() };
            bus.send(Entity::Gps, &angles);
        }
        if let Some(rate) = reading.yaw_rate_rad_s.filter(|value| value.is_finite()) {
            bus.send(Entity::Gps, &AngularVelocity { time, z: rate, ..AngularVelocity::default() });
        }
        let jumps = navigation.jumps();
        let rejection = navigation.read(bus.mono(), reading).err();
        if let Some(rejection) = rejection {
            let reason = match rejection {
                Rejection::Invalid | Rejection::Stale => GpsFixRejectionReason::Invalid,
                Rejection::Dilution => GpsFixRejectionReason::AboveMaxHdop,
                Rejection::Jump => GpsFixRejectionReason::AboveThreshold,
            };
            bus.send(Entity::Navigation, &GpsFixRejection { utc_time: fix.utc_time, reason });
        }
        if rejection == Some(Rejection::Jump) && self.rejection != rejection {
            bus.entry(Entity::Navigation, Level::Warning, "position jumps; it is not used unless it stays");
        }
        if navigation.jumps() > jumps {
            bus.entry(
                Entity::Navigation,
                Level::Warning,
                "position jumped and stayed; it is used from here on",
            );
        }
        self.rejection = rejection;
    }

    pub(crate) fn motor(&mut self, bus: &mut Bus, side: Side, reading: &MotorReading) {
        if !reading.propeller_rpm.is_finite() {
            return;
        }
        let entity = motor_entity(side);
        self.motors[side as usize] = Some(bus.mono());
        let value = reading.propeller_rpm.clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16;
        bus.send(entity, &Rpm { value });
        if reading.temperature_c.is_finite() {
            bus.send(entity, &Temperature { value: reading.temperature_c as f32 });
        }
    }

    pub(crate) fn battery(&mut self, bus: &mut Bus, reading: &BatteryReading) {
        let sane = [reading.voltage_v, reading.current_a, reading.charge_percent, reading.temperature_c]
            .iter()
            .all(|value| value.is_finite());
        let Some(entity) = Entity::battery(reading.number).filter(|_| sane) else { return };
        let slot = &mut self.batteries[usize::from(reading.number)];
        if let Some((at, before)) = slot {
            let hours = bus.mono().since(*at).as_secs_f64().min(60.0) / 3600.0;
            self.used_wh += before.voltage_v * before.current_a * hours;
        }
        *slot = Some((bus.mono(), *reading));
        bus.send(entity, &Voltage { value: reading.voltage_v as f32 });
        bus.send(entity, &Current { value: reading.current_a as f32 });
        bus.send(entity, &Temperature { value: reading.temperature_c as f32 });
        let level =
            FuelLevel { value: reading.charge_percent as f32, confidence: 100.0, ..FuelLevel::default() };
        bus.send(entity, &level);
    }

    /// The batteries whose reports are fresh.
    fn live(&self) -> impl Iterator<Item = &BatteryReading> {
        let silent = &self.silent;
        let known = self.batteries.iter().zip(silent).filter(|(_, silent)| !**silent);
        known.filter_map(|(slot, _)| slot.as_ref()).map(|(_, reading)| reading)
    }

    /// Charge of the emptiest battery that reports (%). While one that did is silent it may be the emptiest:
    /// the charge then falls but does not rise.
    pub(crate) fn charge_percent(&self) -> Option<f64> {
        let lowest = self.live().map(|reading| reading.charge_percent).min_by(f64::total_cmp)?;
        Some(self.held_percent.map_or(lowest, |held| held.min(lowest)))
    }

    /// Voltage of the weakest battery that reports (V).
    pub(crate) fn voltage_v(&self) -> Option<f64> {
        self.live().map(|reading| reading.voltage_v).min_by(f64::total_cmp)
    }

    /// Names of the batteries that have reported and no longer do.
    pub(crate) fn silent_batteries(&self) -> Vec<&'static str> {
        let all = (0..).zip(self.silent).filter(|(_, silent)| *silent);
        all.filter_map(|(number, _)| Some(Entity::battery(number)?.label_and_task().0)).collect()
    }

    /// Power drawn from the batteries that report (W), and energy used since the start (Wh).
    pub(crate) fn power_w(&self) -> (f64, f64) {
        (self.live().map(|reading| reading.voltage_v * reading.current_a).sum(), self.used_wh)
    }

    /// Which batteries have fallen silent, and how low the charge was then.
    fn watch_batteries(&mut self, now: MonoTime, timeout: Duration) {
        let before = self.charge_percent();
        for (slot, silent) in self.batteries.iter().zip(&mut self.silent) {
            *silent = slot.is_some_and(|(at, _)| now.since(at) > timeout);
        }
        self.held_percent = if self.silent.contains(&true) { before.or(self.held_percent) } else { None };
    }

    /// The states of the sensors and of navigation.
    pub(crate) fn watch(
        &mut self,
        bus: &mut Bus,
        states: &mut States,
        navigation: &Navigation,
        settings: &WatchSettings,
    ) {
        let now = bus.mono();
        match self.gnss.map(|at| now.since(at)) {
            None => states.set(bus, Entity::Gps, Condition::Boot, "waiting for the compass"),
            Some(silence) if silence > settings.gnss_timeout => {
                let text = format!("nothing from the compass for {} s", silence.as_secs());
                states.set(bus, Entity::Gps, Condition::Error, text);
            }
            Some(_) => states.set(bus, Entity::Gps, Condition::Normal, "active"),
        }
        let health = navigation.health(now);
        let (condition, text) = match health {
            NavigationHealth::Waiting => (Condition::Boot, "waiting for GPS fix".to_owned()),
            NavigationHealth::Good => (Condition::Normal, "active".to_owned()),
            NavigationHealth::Reckoning => {
                let most_s = navigation.settings().reckoning_s;
                let sigma_m = navigation.settings().most_sigma_m;
                let text = format!(
                    "no position; reckoning on, slowly, for {most_s:.0} s or until it is uncertain by {sigma_m:.0} m"
                );
                (Condition::Normal, text)
            }
            NavigationHealth::NoPosition => (
                Condition::Error,
                "no position: the motors stop and a plan waits until there is one".to_owned(),
            ),
            NavigationHealth::NoHeading => (
                Condition::Error,
                "no heading: the motors stop and a plan waits until there is one".to_owned(),
            ),
        };
        if self.navigation.replace(health) != Some(health) && condition == Condition::Error {
            bus.entry(Entity::Navigation, Level::Error, text.clone());
        }
        states.set(bus, Entity::Navigation, condition, text);
        for side in Side::BOTH {
            let entity = motor_entity(side);
            match self.motors[side as usize].map(|at| now.since(at)) {
                None => states.set(bus, entity, Condition::Boot, "waiting for the motor's feedback"),
                Some(silence) if silence > settings.motor_timeout => {
                    let text = format!("no feedback for {} s", silence.as_secs());
                    states.set(bus, entity, Condition::Error, text);
                }
                Some(_) => states.set(bus, entity, Condition::Normal, "active"),
            }
        }
        self.watch_batteries(now, settings.battery_timeout);
        for (number, slot) in (0..).zip(&self.batteries) {
            let (Some(entity), Some((at, reading))) = (Entity::battery(number), slot) else { continue };
            if now.since(*at) > settings.battery_timeout {
                states.set(bus, entity, Condition::Fault, "no report");
            } else {
                let text = format!("{:.0} %, {:.1} V", reading.charge_percent, reading.voltage_v);
                states.set(bus, entity, Condition::Normal, text);
            }
        }
    }
}

fn motor_entity(side: Side) -> Entity {
    match side {
        Side::Port => Entity::MotorPort,
        Side::Starboard => Entity::MotorStarboard,
    }
}

fn gps_fix(reading: &GnssReading) -> GpsFix {
    let mut fix = GpsFix { satellites: reading.satellites, ..GpsFix::default() };
    let mut validity = GpsFixValidity::empty();
    if let Some(utc) = reading.utc {
        let civil = utc.civil();
        validity |= GpsFixValidity::VALID_DATE | GpsFixValidity::VALID_TIME;
        // Years of four digits; the receiver has no others.
        fix.utc_year = civil.year.clamp(0, 9999) as u16;
        fix.utc_month = civil.month;
        fix.utc_day = civil.day;
        fix.utc_time = (utc.micros().rem_euclid(SECONDS_OF_DAY) as f64 / 1e6) as f32;
    }
    if let Some(position) = reading.fix.filter(|fix| fix.lat_rad.is_finite() && fix.lon_rad.is_finite()) {
        validity |= GpsFixValidity::VALID_POS | GpsFixValidity::VALID_HDOP;
        fix.r#type = match position.quality {
            Quality::Autonomous => GpsFixType::Standalone,
            Quality::Differential => GpsFixType::Differential,
        };
        fix.lat = position.lat_rad;
        fix.lon = position.lon_rad;
        fix.height = position.height_m as f32;
        fix.hdop = position.hdop as f32;
    }
    if let Some(velocity) = reading.velocity.filter(|v| v.course_rad.is_finite() && v.speed_mps.is_finite()) {
        validity |= GpsFixValidity::VALID_COG | GpsFixValidity::VALID_SOG;
        fix.cog = velocity.course_rad as f32;
        fix.sog = velocity.speed_mps as f32;
    }
    fix.validity = validity;
    fix
}

/// The state of the vessel as it goes out.
pub(crate) fn estimated_state(estimate: &Estimate) -> EstimatedState {
    EstimatedState {
        lat: estimate.origin.lat_rad(),
        lon: estimate.origin.lon_rad(),
        height: estimate.height_m as f32,
        x: estimate.offset.north_m as f32,
        y: estimate.offset.east_m as f32,
        psi: estimate.motion.heading_rad as f32,
        u: estimate.motion.surge_mps() as f32,
        v: estimate.motion.sway_mps() as f32,
        vx: estimate.motion.north_mps as f32,
        vy: estimate.motion.east_mps as f32,
        r: estimate.motion.yaw_rate_rad_s.unwrap_or(0.0) as f32,
        depth: 0.0,
        alt: -1.0,
        ..EstimatedState::default()
    }
}

/// How sure the vessel is of its position.
pub(crate) fn uncertainty(estimate: &Estimate) -> NavigationUncertainty {
    let variance = (estimate.sigma_m * estimate.sigma_m) as f32;
    NavigationUncertainty { x: variance, y: variance, ..NavigationUncertainty::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use units::{Now, UtcTime};

    #[test]
    fn the_emptiest_battery_counts_and_a_silent_one_does_not_refill_the_rest() {
        let at =
            |second: u64| Now { mono: MonoTime::from_micros(second * 1_000_000), utc: UtcTime::default() };
        let mut bus = Bus::new(&Settings::otter("test", imc::Address(0x2810)), at(0));
        let mut sensors = Sensors::default();
        let mut report = |sensors: &mut Sensors, second, number, charge_percent| {
            bus.begin(at(second));
            let reading =
                BatteryReading { number, charge_percent, voltage_v: 30.0, ..BatteryReading::default() };
            sensors.battery(&mut bus, &reading);
            sensors.watch_batteries(at(second).mono, Duration::from_secs(10));
        };
        report(&mut sensors, 0, 0, 90.0);
        report(&mut sensors, 1, 1, 18.0);
        assert_eq!(sensors.charge_percent(), Some(18.0), "not the mean");
        for second in 2..60 {
            report(&mut sensors, second, 0, 90.0);
        }
        assert_eq!((sensors.charge_percent(), sensors.silent_batteries()), (Some(18.0), vec!["Battery 1"]));
        report(&mut sensors, 60, 0, 12.0);
        assert_eq!(sensors.charge_percent(), Some(12.0));
        sensors.watch_batteries(at(90).mono, Duration::from_secs(10));
        assert_eq!((sensors.charge_percent(), sensors.voltage_v()), (None, None), "no report is no charge");
        report(&mut sensors, 91, 0, 95.0);
        report(&mut sensors, 92, 1, 96.0);
        assert_eq!(sensors.charge_percent(), Some(95.0));
    }
}
