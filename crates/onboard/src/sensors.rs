//! Sensor values on their way to the bus, and the watch over their silence.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::epoch::{euler_angles, gps_fix};
use crate::input::DeviceState;
use crate::navigation::{Arrival, Estimate, Navigation, NavigationHealth, Rejection};
use crate::output::Level;
use crate::settings::WatchSettings;
use crate::states::{Condition, States};
use devices::{BatteryReading, GnssReading, MotorReading, Part, RailReading, Side, TroubleReading};
use imc::messages::{
    AngularVelocity, Current, EstimatedState, FuelLevel, GpsFixRejection, GpsFixRejectionReason,
    NavigationUncertainty, Rpm, Temperature, Voltage,
};
use std::collections::BTreeMap;
use std::time::Duration;
use units::MonoTime;

/// The state of the sensors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sensors {
    gnss: Option<MonoTime>,
    /// When there was a position that navigation took, and a heading.
    position: Option<MonoTime>,
    heading: Option<MonoTime>,
    rejection: Option<Rejection>,
    /// It was reported that the compass gives no dilution.
    told_dilution: bool,
    motors: [Option<MonoTime>; 2],
    batteries: [Option<(MonoTime, BatteryReading)>; 4],
    /// When each power rail reported last, and its voltage (V).
    rails: [Option<(MonoTime, f64)>; 5],
    /// Which of them have fallen silent.
    silent: [bool; 4],
    /// The lowest charge since one fell silent (%).
    held_percent: Option<f64>,
    /// Energy taken from the batteries since the start (Wh).
    used_wh: f64,
    navigation: Option<NavigationHealth>,
    /// Drivers' reports of devices with a fault, and since when.
    failing: BTreeMap<Entity, (MonoTime, String)>,
    /// Faults that parts report.
    troubles: BTreeMap<Entity, String>,
}

impl Sensors {
    /// The program was stalled this long, so that nothing could be heard: no compass or motor counts as silent for it.
    /// The age of the position is not corrected.
    pub(crate) fn held_up(&mut self, gap: Duration) {
        for at in self.motors.iter_mut().chain([&mut self.gnss]).flatten() {
            *at = *at + gap;
        }
    }

    /// An epoch of the compass: to the bus as it came, and to navigation.
    pub(crate) fn gnss(
        &mut self,
        bus: &mut Bus,
        navigation: &mut Navigation,
        arrival: Arrival,
        reading: &GnssReading,
    ) {
        let Arrival { at, lag } = arrival;
        self.gnss = Some(at);
        let fix = gps_fix(reading);
        bus.send(Entity::Gps, &fix);
        let time = bus.utc_of(at).seconds() - lag.as_secs_f64();
        if let Some(angles) = euler_angles(time, reading) {
            bus.send(Entity::Gps, &angles);
        }
        if let Some(rate) = reading.yaw_rate_rad_s.filter(|value| value.is_finite()) {
            bus.send(Entity::Gps, &AngularVelocity { time, z: rate, ..AngularVelocity::default() });
        }
        let jumps = navigation.jumps();
        let rejection = navigation.read_late(arrival, reading).err();
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
        self.assume_dilution(bus, navigation, reading);
        if rejection.is_none() {
            self.position = Some(at);
        }
        if reading.heading_rad.is_some_and(f64::is_finite)
            || navigation.health(bus.mono()) == NavigationHealth::Good
        {
            self.heading = Some(at);
        }
    }

    /// Reports once that the compass gives no dilution, and which value is assumed.
    fn assume_dilution(&mut self, bus: &mut Bus, navigation: &Navigation, reading: &GnssReading) {
        if !self.told_dilution && reading.fix.is_some_and(|fix| fix.hdop.is_nan()) {
            self.told_dilution = true;
            let assumed = navigation.settings().assumed_hdop;
            let text = format!(
                "the compass tells no dilution (HDOP): {assumed:.1} is taken for it (`Assumed HDOP`); let it send GGA or GSA with one"
            );
            bus.entry(Entity::Navigation, Level::Warning, text);
        }
    }

    /// The parts that are not good but must be before motors are armed, each with the reason.
    pub(crate) fn missing(&self, now: MonoTime, watch: &WatchSettings) -> Vec<String> {
        let fresh = |at: Option<MonoTime>, timeout| at.is_some_and(|at| now.since(at) <= timeout);
        let of_compass = [
            (self.position, "position (the compass reports no usable one)"),
            (self.heading, "heading (the compass does not report it)"),
        ];
        let compass = of_compass.into_iter().filter(|(at, _)| !fresh(*at, watch.gnss_timeout));
        let motors =
            Side::BOTH.into_iter().filter(|side| !fresh(self.motors[*side as usize], watch.motor_timeout));
        let motor =
            |side: Side| format!("CAN (no feedback of the {})", motor_entity(side).label_and_task().0);
        compass.map(|(_, text)| text.to_owned()).chain(motors.map(motor)).collect()
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

    /// A power rail: to the bus.
    pub(crate) fn rail(&mut self, bus: &mut Bus, reading: &RailReading) {
        let sane = reading.voltage_v.is_finite() && reading.current_a.is_finite();
        let Some(entity) = Entity::rail(reading.number).filter(|_| sane) else { return };
        self.rails[usize::from(reading.number)] = Some((bus.mono(), reading.voltage_v));
        bus.send(entity, &Voltage { value: reading.voltage_v as f32 });
        bus.send(entity, &Current { value: reading.current_a as f32 });
    }

    /// The fault that a part reports, for its state; its driver warns of it too.
    pub(crate) fn trouble(&mut self, reading: &TroubleReading) {
        let entity = match reading.part {
            Part::Motor(side) => Some(motor_entity(side)),
            Part::Battery(number) => Entity::battery(number),
        };
        match entity {
            Some(entity) if reading.text.is_empty() => drop(self.troubles.remove(&entity)),
            Some(entity) => drop(self.troubles.insert(entity, reading.text.clone())),
            None => {}
        }
    }

    /// How a device is, as its driver knows it: to the log book, and for the states of its part.
    pub(crate) fn device(&mut self, bus: &mut Bus, state: &DeviceState) {
        if state.condition.is_bad() {
            let (_, text) = self.failing.entry(state.entity).or_insert_with(|| (bus.mono(), String::new()));
            if *text != state.text {
                text.clone_from(&state.text);
                bus.entry(state.entity, Level::Error, state.text.clone());
            }
        } else if state.condition == Condition::Normal && self.failing.remove(&state.entity).is_some() {
            bus.entry(state.entity, Level::Info, "works again");
        }
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

    /// The driver's report of a part that is in error by it. A device that has worked is bridged for as long as its
    /// silence is: a plug that is loose for a moment does not end a plan.
    fn failing(
        &self,
        entity: Entity,
        last: Option<MonoTime>,
        now: MonoTime,
        timeout: Duration,
    ) -> Option<&str> {
        let (since, text) = self.failing.get(&entity)?;
        let late = |at: MonoTime| now.since(at) > timeout;
        (late(*since) || last.is_none_or(late)).then_some(text)
    }

    /// The states of both motors.
    fn watch_motors(&self, bus: &mut Bus, states: &mut States, timeout: Duration) {
        for side in Side::BOTH {
            let entity = motor_entity(side);
            let last = self.motors[side as usize];
            match last.map(|at| bus.mono().since(at)) {
                _ if let Some(text) = self.failing(entity, last, bus.mono(), timeout) => {
                    states.set(bus, entity, Condition::Error, text);
                }
                None => states.set(bus, entity, Condition::Boot, "waiting for the motor's feedback"),
                Some(silence) if silence > timeout => {
                    let text = format!("no feedback for {} s", silence.as_secs());
                    states.set(bus, entity, Condition::Error, text);
                }
                Some(_) => match self.troubles.get(&entity) {
                    Some(text) => states.set(bus, entity, Condition::Fault, text.as_str()),
                    None => states.set(bus, entity, Condition::Normal, "active"),
                },
            }
        }
    }

    /// The states of the rails that have reported.
    fn watch_rails(&self, bus: &mut Bus, states: &mut States, timeout: Duration) {
        for (number, slot) in (0..).zip(&self.rails) {
            let (Some(entity), Some((at, voltage_v))) = (Entity::rail(number), slot) else { continue };
            if bus.mono().since(*at) > timeout {
                states.set(bus, entity, Condition::Fault, "no report");
            } else {
                // Without the current, which differs with every report and would make a message each.
                states.set(bus, entity, Condition::Normal, format!("{voltage_v:.1} V"));
            }
        }
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
            _ if let Some(text) = self.failing(Entity::Gps, self.gnss, now, settings.gnss_timeout) => {
                states.set(bus, Entity::Gps, Condition::Error, text);
            }
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
        self.watch_motors(bus, states, settings.motor_timeout);
        self.watch_rails(bus, states, settings.battery_timeout);
        self.watch_batteries(now, settings.battery_timeout);
        for (number, slot) in (0..).zip(&self.batteries) {
            let (Some(entity), Some((at, reading))) = (Entity::battery(number), slot) else { continue };
            if now.since(*at) > settings.battery_timeout {
                states.set(bus, entity, Condition::Fault, "no report");
            } else {
                let text = format!("{:.0} %, {:.1} V", reading.charge_percent, reading.voltage_v);
                match self.troubles.get(&entity) {
                    Some(trouble) => states.set(bus, entity, Condition::Fault, format!("{text}; {trouble}")),
                    None => states.set(bus, entity, Condition::Normal, text),
                }
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
    use imc::messages::{EulerAngles, GpsFix, GpsFixValidity};
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
        assert_eq!(
            (sensors.charge_percent(), sensors.voltage_v()),
            (None, None),
            "no report is not a charge"
        );
        report(&mut sensors, 91, 0, 95.0);
        report(&mut sensors, 92, 1, 96.0);
        assert_eq!(sensors.charge_percent(), Some(95.0));
    }

    #[test]
    fn who_was_held_up_takes_nobody_for_silent() {
        let at = |ms: u64| Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::default() };
        let settings = Settings::otter("test", imc::Address(0x2810));
        let mut bus = Bus::new(&settings, at(0));
        let mut states = States::new(vec![], at(0).mono);
        let navigation = Navigation::new(settings.navigation);
        let mut sensors = Sensors::default();
        let mut look = |sensors: &mut Sensors, ms| {
            bus.begin(at(ms));
            sensors.watch(&mut bus, &mut states, &navigation, &settings.watch);
            states.condition(Entity::MotorPort)
        };
        let mut heard = Bus::new(&settings, at(0));
        sensors.motor(&mut heard, Side::Port, &MotorReading::default());
        sensors.held_up(Duration::from_secs(4));
        assert_eq!(look(&mut sensors, 4_500), Condition::Normal);
        assert_eq!(look(&mut sensors, 7_000), Condition::Error, "a motor that stays silent is told");
    }

    #[test]
    fn what_a_part_reports_of_itself_is_its_state_until_it_is_over() {
        let at = |ms: u64| Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::default() };
        let settings = Settings::otter("test", imc::Address(0x2810));
        let mut bus = Bus::new(&settings, at(0));
        let mut states = States::new(vec![], at(0).mono);
        let navigation = Navigation::new(settings.navigation);
        let mut sensors = Sensors::default();
        let mut see = |ms, text: &str| {
            bus.begin(at(ms));
            sensors.motor(&mut bus, Side::Starboard, &MotorReading::default());
            let reading =
                BatteryReading { number: 2, charge_percent: 80.0, voltage_v: 32.0, ..Default::default() };
            sensors.battery(&mut bus, &reading);
            for part in [Part::Motor(Side::Starboard), Part::Battery(2), Part::Battery(9)] {
                sensors.trouble(&TroubleReading { part, text: text.to_owned() });
            }
            sensors.watch(&mut bus, &mut states, &navigation, &settings.watch);
            [Entity::MotorStarboard, Entity::Battery2]
                .map(|entity| (states.condition(entity), states.all[usize::from(entity.number())].1.clone()))
        };
        let normal = |text: &str| (Condition::Normal, text.to_owned());
        let fault = |text: &str| (Condition::Fault, text.to_owned());
        assert_eq!(see(0, ""), [normal("active"), normal("80 %, 32.0 V")]);
        assert_eq!(see(500, "hot: wait"), [fault("hot: wait"), fault("80 %, 32.0 V; hot: wait")]);
        assert_eq!(see(1000, ""), [normal("active"), normal("80 %, 32.0 V")]);
    }

    #[test]
    fn attitude_goes_out_whole_and_a_missing_dilution_is_told_once() {
        let start =
            Now { mono: MonoTime::from_micros(5_000_000), utc: UtcTime::from_micros(1_795_000_000_000_000) };
        let settings = Settings::otter("test", imc::Address(0x2810));
        let mut bus = Bus::new(&settings, start);
        let mut navigation = Navigation::new(settings.navigation);
        let mut sensors = Sensors::default();
        let fix =
            devices::GnssFix { lat_rad: 1.1, lon_rad: 0.2, hdop: f64::NAN, ..devices::GnssFix::default() };
        let reading = GnssReading {
            fix: Some(fix),
            heading_rad: Some(1.0),
            roll_rad: Some(0.05),
            pitch_rad: Some(-0.02),
            magnetic_heading_rad: Some(0.9),
            velocity: Some(devices::GroundVelocity { course_rad: f64::NAN, speed_mps: 0.0 }),
            ..GnssReading::default()
        };
        // Read a second and a half ago, and half a second under way before.
        let arrival = Arrival { at: MonoTime::from_micros(3_500_000), lag: Duration::from_millis(500) };
        for _ in 0..3 {
            sensors.gnss(&mut bus, &mut navigation, arrival, &reading);
        }
        let mut packets = Vec::new();
        while let Some(output) = bus.poll() {
            if let crate::output::Output::Packet { bytes, .. } = output {
                packets.push(imc::Packet::decode(&bytes).unwrap());
            }
        }
        let angles = packets.iter().find_map(|packet| packet.get::<EulerAngles>()).unwrap();
        assert_eq!((angles.phi, angles.theta, angles.psi, angles.psi_magnetic), (0.05, -0.02, 1.0, 0.9));
        assert!((angles.time - (start.utc.seconds() - 2.0)).abs() < 1e-6, "{}", angles.time);
        let fix = packets.iter().find_map(|packet| packet.get::<GpsFix>()).unwrap();
        assert!(
            fix.validity.contains(GpsFixValidity::VALID_SOG)
                && !fix.validity.contains(GpsFixValidity::VALID_COG)
        );
        let entries = packets.iter().filter_map(|packet| packet.get::<imc::messages::LogBookEntry>());
        assert_eq!(entries.filter(|entry| entry.text.to_str_lossy().contains("Assumed HDOP")).count(), 1);
        assert_eq!(navigation.health(arrival.at + Duration::from_secs(1)), NavigationHealth::Good);
    }

    #[test]
    fn a_device_that_fails_is_in_error_in_its_driver_s_words_once_it_is_missed() {
        let at = |ms: u64| Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::default() };
        let settings = Settings::otter("test", imc::Address(0x2810));
        let mut bus = Bus::new(&settings, at(0));
        let mut states = States::new(vec![Entity::MotorPort], at(0).mono);
        let navigation = Navigation::new(settings.navigation);
        let mut sensors = Sensors::default();
        let mut see = |sensors: &mut Sensors, ms, condition, text: &str| {
            bus.begin(at(ms));
            let entity = Entity::MotorPort;
            sensors.device(&mut bus, &DeviceState { entity, condition, text: text.to_owned() });
            if condition == Condition::Normal {
                sensors.motor(&mut bus, Side::Port, &MotorReading::default());
            }
            sensors.watch(&mut bus, &mut states, &navigation, &settings.watch);
            states.condition(entity)
        };
        assert_eq!(see(&mut sensors, 0, Condition::Error, "no port"), Condition::Error, "never there");
        assert_eq!(see(&mut sensors, 100, Condition::Boot, ""), Condition::Error, "open, and no answer yet");
        assert_eq!(see(&mut sensors, 200, Condition::Normal, ""), Condition::Normal);
        assert_eq!(see(&mut sensors, 1000, Condition::Error, "lost"), Condition::Normal, "a loose plug");
        assert_eq!(see(&mut sensors, 2300, Condition::Error, "lost"), Condition::Error);
        assert_eq!(see(&mut sensors, 2400, Condition::Normal, ""), Condition::Normal);
        // Feedback that comes does not hide for ever that its driver finds the device failing.
        for ms in (2500..4600).step_by(100) {
            see(&mut sensors, ms, Condition::Error, "refuses");
            sensors.motors[0] = Some(at(ms).mono);
        }
        assert_eq!(see(&mut sensors, 4700, Condition::Error, "refuses"), Condition::Error);
    }
}
