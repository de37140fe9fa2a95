//! The configured devices with drivers that only listen, for `lutra-agent doctor`.

use super::can::CanMotors;
use super::configured::{
    ConfiguredDevice, GPSD_TASK, configured_devices, line_receiver_settings, motors_config, motors_place, one,
};
use crate::device::Device;
use config::Config;
use config::schema::device::{compass, hydrophone, line_receiver, torqeedo};
use drivers::gnss::{Compass, CompassSettings};
use drivers::hydrophone::{Receiver, ReceiverSettings, Setting, Sync};
use drivers::line_receiver::{LineReceiver, LineReceiverSettings};
use drivers::motors::Motors;
use std::sync::Arc;
use std::time::Duration;

/// Query of a Thelma Biotel receiver for its firmware.
const FIRMWARE: &str = "FV?";

/// The devices of [`configured_devices`], with drivers that change nothing: the compass is sent nothing; the hydrophone is
/// asked for its firmware, and gets neither settings nor the time; the motor card is sent no frame, only its serial adapter
/// is sent the bus speed and opened.
///
/// # Errors
/// As [`configured_devices`].
pub(crate) fn listening(config: &Config) -> anyhow::Result<Vec<ConfiguredDevice>> {
    let mut all = configured_devices(config, &Arc::default())?;
    for configured in &mut all {
        match configured.device {
            Device::Compass => {
                // gpsd is sent a watch command, which affects only this connection.
                if let Some(section) = one(config, &compass::COMPASS)?
                    && section.task() != GPSD_TASK
                {
                    let input_timeout = Duration::from_secs_f64(section.get(&compass::INPUT_TIMEOUT));
                    let silent =
                        CompassSettings { init: Vec::new(), input_timeout, ..CompassSettings::default() };
                    configured.driver = Box::new(Compass::new(silent));
                }
            }
            Device::Motors => {
                if let Some(section) = one(config, &torqeedo::TORQEEDO)? {
                    let (_, wire) = motors_place(section)?;
                    let motors = Motors::listening(motors_config(section)?)?;
                    configured.driver = Box::new(CanMotors::new(motors, wire, Arc::default()));
                }
            }
            Device::Hydrophone => {
                if let Some(section) = one(config, &line_receiver::LINE_RECEIVER)? {
                    let silent =
                        LineReceiverSettings { init: Vec::new(), ..line_receiver_settings(section)? };
                    configured.driver = Box::new(LineReceiver::new(silent));
                }
                if one(config, &hydrophone::HYDROPHONE)?.is_some() {
                    let asked = ReceiverSettings {
                        settings: vec![Setting::parse(FIRMWARE)?],
                        sync: Sync::Off,
                        ..Default::default()
                    };
                    configured.driver = Box::new(Receiver::new(asked));
                }
            }
            Device::Watchdog | Device::Light | Device::Pulse => {}
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::InMemory;
    use drivers::{Input, Output};
    use units::{MonoTime, Now, UtcTime};

    /// All that a driver sends within a minute in which nothing answers.
    fn sent(configured: &mut ConfiguredDevice) -> String {
        let mut sent = Vec::new();
        for ms in 0..60_000_u64 {
            let mono = MonoTime::from_micros(ms * 1000);
            let now = Now { mono, utc: UtcTime::from_micros(1_790_000_000_000_000 + ms as i64 * 1000) };
            configured.driver.handle(now, if ms == 0 { Input::Opened } else { Input::Time });
            while let Some(output) = configured.driver.poll_output() {
                if let Output::Send { bytes, .. } | Output::Newest { bytes, .. } = output {
                    sent.extend(bytes);
                    sent.push(b' ');
                }
            }
        }
        String::from_utf8(sent).unwrap()
    }

    #[test]
    fn nothing_is_sent_that_changes_a_device() {
        let text = format!(
            "{}\n[Actuators.Torqeedo]\nCAN Port - Device = slcan:/dev/ttyACM0\nPower Channel H_AUX0 - Name = Lamp\n\
             [Sensors.ThelmaHydrophone]\nInitialization String 0 - Command = LI=01\nUse PPS = false\n",
            crate::OTTER_INI
        );
        let files = InMemory::new().with("otter.ini", text);
        let config = Config::load(&files, "otter.ini".as_ref(), &["Hardware"]);
        let sent: Vec<(Device, String)> = listening(&config)
            .unwrap()
            .iter_mut()
            .map(|configured| (configured.device, sent(configured)))
            .collect();
        for (device, sent) in &sent {
            let words: Vec<&str> = sent.split_whitespace().collect();
            match device {
                Device::Compass => assert!(words.is_empty(), "{sent}"),
                Device::Motors => assert!(words.chunks(3).all(|words| words == ["C", "S6", "O"]), "{sent}"),
                _ => assert!(words.iter().all(|word| ["LIVECM", "FV?", "EX!"].contains(word)), "{sent}"),
            }
        }
        assert_eq!(sent.len(), 3, "{sent:?}");
    }
}
