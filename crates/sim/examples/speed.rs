//! Prints how many seconds a vessel simulates in one second of this computer.
//!
//! `cargo run --release -p sim --example speed [SIMULATED_SECONDS]`

use sim::{
    CurrentConfig, EnvironmentConfig, FishConfig, GnssConfig, OutputForm, Vessel, VesselConfig, WaveConfig,
    WindConfig,
};
use std::hint::black_box;
use std::time::{Duration, Instant};
use units::{LatLon, UtcTime};

fn config(rate_hz: u32, form: OutputForm, rough: bool) -> VesselConfig {
    let start = UtcTime::from_micros(1_718_000_000_000_000);
    let place = LatLon::from_deg(63.44, 10.35).expect("invariant: a place");
    let mut config = VesselConfig::at(place, start, 1);
    config.form = form;
    config.gnss = GnssConfig { rate_hz, baud: 0, ..GnssConfig::default() };
    config.fish = vec![FishConfig::near(place, start, 40, 1)];
    if rough {
        config.environment = EnvironmentConfig {
            current: CurrentConfig { speed_mps: 0.3, variation_mps: 0.05, ..CurrentConfig::default() },
            wind: WindConfig { speed_mps: 6.0, ..WindConfig::default() },
            waves: WaveConfig { significant_height_m: 0.3, ..WaveConfig::default() },
        };
    }
    config
}

#[expect(clippy::disallowed_methods, reason = "measuring speed needs the wall clock")]
fn measure(name: &str, config: &VesselConfig, seconds: u32) {
    let mut vessel = Vessel::new(config).expect("invariant: the settings above are in range");
    let (mut outputs, mut bytes) = (0_u64, 0_u64);
    let begin = Instant::now();
    for step in 0..u64::from(seconds) * 25 {
        if step % 6 == 0 {
            vessel.command(0.6, 0.55).expect("invariant: within -1 to 1");
        }
        vessel.step(Duration::from_millis(40));
        while let Some(timed) = vessel.poll_output() {
            outputs += 1;
            if let sim::Output::Serial(_, line) = &timed.output {
                bytes += line.len() as u64;
            }
            black_box(timed);
        }
    }
    let rate = f64::from(seconds) / begin.elapsed().as_secs_f64();
    println!("{name:<58} {rate:>9.0} s/s  {outputs} outputs, {bytes} bytes on serial lines");
}

fn main() {
    let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(20_000);
    measure("calm, values, GNSS 1 Hz", &config(1, OutputForm::Values, false), seconds);
    measure("wind, waves, current, values, GNSS 1 Hz", &config(1, OutputForm::Values, true), seconds);
    measure("wind, waves, current, bytes, GNSS 1 Hz", &config(1, OutputForm::Bytes, true), seconds);
    measure("wind, waves, current, bytes, GNSS 5 Hz", &config(5, OutputForm::Bytes, true), seconds);
    measure("wind, waves, current, values, GNSS 25 Hz", &config(25, OutputForm::Values, true), seconds);
    measure("wind, waves, current, bytes, GNSS 25 Hz", &config(25, OutputForm::Bytes, true), seconds);
}
