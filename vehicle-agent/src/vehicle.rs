//! A brain in a simulated vessel, under one virtual clock.
//!
//! The clock jumps from event to event: the next step of the hull, the next reading of a sensor, the next
//! deadline of the brain. Two worlds with the same settings give the same outputs at the same times.

use control::MotorPair;
use onboard::{
    BatteryReading, Brain, COMMAND_LIFE, GnssFix, GnssReading, Input, Keep, MotorReading, Now, Output, Side,
    TagReading, WaterReading,
};
use sim::{CardReport, HydrophoneLine, Quality, Vessel};
use std::sync::mpsc::Receiver;
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// Something the brain put out, or was told, and when.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Happening {
    /// It was told this.
    Told(Input),
    /// It wants this.
    Wanted(Output),
}

/// How commands come to the simulated motors.
pub(crate) enum Motors {
    /// At once: nothing can hold up a virtual clock.
    Direct,
    /// Through a gate of their own thread: what it is given, and what it lets through.
    Gated(Box<dyn Fn(MotorPair)>, Receiver<MotorPair>),
}

impl std::fmt::Debug for Motors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Direct => "Direct",
            Self::Gated(..) => "Gated",
        })
    }
}

/// Vessel, brain and clock.
#[derive(Debug)]
pub(crate) struct World {
    /// The vessel.
    pub(crate) vessel: Vessel,
    /// Its brain.
    pub(crate) brain: Brain,
    /// Whether plans are kept by pretending; otherwise the caller tells what became of them.
    pub(crate) virtual_disk: bool,
    /// How much the computer's clock is ahead of the true time (µs).
    pub(crate) clock_error_us: i64,
    /// The way to the motors.
    pub(crate) motors: Motors,
}

impl World {
    /// A vessel and its brain at the vessel's time.
    pub(crate) fn new(vessel: Vessel, brain: Brain) -> Self {
        Self { vessel, brain, virtual_disk: true, clock_error_us: 0, motors: Motors::Direct }
    }

    /// The moment.
    pub(crate) fn now(&self) -> Now {
        let utc = UtcTime::from_micros(self.vessel.utc().micros() + self.clock_error_us);
        Now { mono: self.vessel.now(), utc }
    }

    /// Tells the brain something at this moment.
    pub(crate) fn tell(&mut self, input: Input, sink: &mut impl FnMut(Now, Happening)) {
        let now = self.now();
        sink(now, Happening::Told(input.clone()));
        self.brain.handle(now, input);
        let mut stored = Vec::new();
        while let Some(output) = self.brain.poll_output() {
            match &output {
                Output::Keep(Keep::Plans(effect)) if self.virtual_disk => {
                    stored.push(Input::Stored(effect.ticket(), Ok(())));
                }
                Output::Keep(Keep::Parameters(label, _)) if self.virtual_disk => {
                    stored.push(Input::ParametersKept(label.clone(), Ok(())));
                }
                _ => {}
            }
            if let Output::Motors(motors) = &output {
                self.command(*motors);
            }
            sink(now, Happening::Wanted(output));
        }
        // A virtual disk never fails and takes no time.
        for input in stored {
            self.tell(input, sink);
        }
    }

    fn command(&mut self, motors: MotorPair) {
        match &self.motors {
            Motors::Direct => obey(&mut self.vessel, motors),
            Motors::Gated(gate, _) => {
                gate(motors);
                self.obey_gate();
            }
        }
    }

    /// Hands the motors what the gate lets through, also without being asked.
    fn obey_gate(&mut self) {
        if let Motors::Gated(_, commands) = &self.motors {
            for motors in commands.try_iter() {
                obey(&mut self.vessel, motors);
            }
        }
    }

    /// Lets the vessel drift until `until` while nobody steers: the motors run for as long as a command is good
    /// and no longer. Sensors speak to nobody but for the hydrophone, whose lines wait in its serial port.
    pub(crate) fn drift(&mut self, until: MonoTime, sink: &mut impl FnMut(Now, Happening)) {
        let running = (self.vessel.now() + COMMAND_LIFE).min(until);
        self.vessel.step(running.since(self.vessel.now()));
        self.obey_gate();
        obey(&mut self.vessel, MotorPair::STOPPED);
        self.vessel.step(until.since(running));
        let mut late = Vec::new();
        while let Some(timed) = self.vessel.poll_output() {
            if matches!(timed.output, sim::Output::Hydrophone(_)) {
                late.extend(input_of(&timed.output));
            }
        }
        for input in late {
            self.tell(input, sink);
        }
    }

    /// Lets time pass to the next event, but not beyond `until`.
    pub(crate) fn advance(&mut self, until: MonoTime, sink: &mut impl FnMut(Now, Happening)) {
        self.obey_gate();
        let before = self.vessel.now();
        let due = self.brain.poll_timeout().unwrap_or(until);
        // At least a microsecond, so that a deadline that is not met cannot stop the clock.
        let next = self.vessel.poll_timeout().min(due).min(until).max(before + Duration::from_micros(1));
        self.vessel.step(next.since(before));
        while let Some(timed) = self.vessel.poll_output() {
            if let Some(input) = input_of(&timed.output) {
                self.tell(input, sink);
            }
        }
        if self.brain.poll_timeout().is_some_and(|due| due <= self.vessel.now()) {
            self.tell(Input::Timer, sink);
        }
    }

    /// Lets time pass until `until`.
    pub(crate) fn run(&mut self, until: MonoTime, sink: &mut impl FnMut(Now, Happening)) {
        while self.vessel.now() < until {
            self.advance(until, sink);
        }
    }
}

fn obey(vessel: &mut Vessel, motors: MotorPair) {
    // The authority lets only numbers within -1 to 1 through.
    vessel.command(motors.port, motors.starboard).ok();
}

/// What a sensor's value is to the brain; bytes are for the drivers.
pub(crate) fn input_of(output: &sim::Output) -> Option<Input> {
    Some(match output {
        sim::Output::Serial(..) | sim::Output::Can(_) | sim::Output::Card(CardReport::Rail { .. }) => {
            return None;
        }
        sim::Output::Gnss(reading) => Input::Gnss(GnssReading {
            utc: Some(reading.utc),
            fix: reading.fix.map(|fix| GnssFix {
                lat_rad: fix.place.lat_rad(),
                lon_rad: fix.place.lon_rad(),
                height_m: fix.height_m + fix.separation_m,
                differential: fix.quality == Quality::Differential,
                hdop: fix.hdop,
            }),
            satellites: reading.satellites_seen,
            velocity: reading.velocity.map(|velocity| (velocity.course_rad, velocity.speed_mps)),
            heading_rad: reading.heading_rad,
            yaw_rate_rad_s: reading.rate_of_turn_radps,
        }),
        sim::Output::Card(CardReport::Motor(side, reading)) => {
            let side = match side {
                sim::Side::Port => Side::Port,
                sim::Side::Starboard => Side::Starboard,
            };
            let reading = MotorReading {
                rpm: reading.propeller_rpm,
                power_w: reading.power_w,
                temperature_c: reading.temperature_c,
            };
            Input::Motor(side, reading)
        }
        sim::Output::Card(CardReport::Battery(number, reading)) => Input::Battery(BatteryReading {
            number: *number,
            voltage_v: reading.voltage_v,
            current_a: reading.current_a,
            charge_percent: reading.charge_percent,
            temperature_c: reading.temperature_c,
        }),
        sim::Output::Hydrophone(HydrophoneLine::Tag(tag)) => Input::Tag(TagReading {
            serial: tag.serial,
            clock_s: tag.clock_s,
            millis: tag.millis,
            protocol: tag.protocol.name().to_owned(),
            tag_id: tag.tag_id,
            data: tag.data,
            snr_db: tag.snr_db,
            frequency_khz: tag.frequency_khz,
            counter: tag.counter,
        }),
        sim::Output::Hydrophone(HydrophoneLine::Sensor(line)) => Input::Water(WaterReading {
            serial: line.serial,
            clock_s: line.clock_s,
            temperature_c: (f64::from(line.temperature_raw) - 50.0) / 10.0,
            noise_average: line.noise_average,
            noise_peak: line.noise_peak,
            frequency_khz: line.frequency_khz,
            counter: line.counter,
        }),
    })
}
