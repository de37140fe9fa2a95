//! The configured devices of the vessel: the port of each, and its driver.

use super::can::{CanMotors, Orders};
use super::wire::Wire;
use crate::device::Device;
use crate::io::Place;
use anyhow::{Context as _, bail};
use config::schema::device::{self, compass, hydrophone, line_receiver, torqeedo};
use config::{Config, Section};
use devices::Pair;
use devices::pattern::Pattern;
use devices::slcan::Bitrate;
use drivers::Driver;
use drivers::gnss::{Compass, CompassSettings};
use drivers::gpsd::{Gpsd, Watch};
use drivers::hydrophone::{Receiver, ReceiverSettings, Setting, Sync};
use drivers::line_receiver::{Language, LineReceiver, LineReceiverSettings};
use drivers::motors::{ChannelConfig, ChannelTable, MotorAssignment, Motors, MotorsConfig, write_period};
use std::sync::Arc;
use std::time::Duration;

/// A task of this name gets its sentences from gpsd.
pub(super) const GPSD_TASK: &str = "Sensors.GPSDraw";
/// Commands that open and close the hydrophone's command mode, which its driver sends automatically.
const COMMAND_MODE: [&str; 2] = ["LIVECM", "EX!"];

/// A device, its driver and its port.
pub(crate) struct ConfiguredDevice {
    /// The kind of device.
    pub(crate) device: Device,
    /// Its driver.
    pub(crate) driver: Box<dyn Driver + Send>,
    /// Its port.
    pub(crate) place: Place,
}

/// The devices of a configuration; the motors' driver takes its commands from `orders`.
///
/// # Errors
/// When there is none, or a value of the configuration is not valid: the text names the section.
pub(crate) fn configured_devices(
    config: &Config,
    orders: &Arc<Orders>,
) -> anyhow::Result<Vec<ConfiguredDevice>> {
    let mut all = Vec::new();
    if let Some(section) = one(config, &compass::COMPASS)? {
        all.push(compass_of(section).with_context(|| about(section))?);
    }
    if let Some(section) = one(config, &torqeedo::TORQEEDO)? {
        all.push(motors_of(config, section, orders).with_context(|| about(section))?);
    }
    let thelma = one(config, &hydrophone::HYDROPHONE)?;
    if let Some(section) = thelma {
        all.push(hydrophone_of(section).with_context(|| about(section))?);
    }
    if let Some(section) = one(config, &line_receiver::LINE_RECEIVER)? {
        if let Some(thelma) = thelma {
            bail!(
                "{} and {} both run: the vessel has one receiver, disable the other",
                about(thelma),
                about(section)
            );
        }
        all.push(line_receiver_of(section).with_context(|| about(section))?);
    }
    if all.is_empty() {
        let profiles = config.profiles().selected().join(", ");
        bail!(
            "in the profile `{profiles}` no device runs: enable [Sensors.GPS], [Actuators.Torqeedo] and [Sensors.TBR700RT] in it, \
             or take another profile"
        );
    }
    Ok(all)
}

fn about(section: &Section) -> String {
    format!("[{}]", section.name())
}

/// The one section of a kind that runs.
pub(super) fn one<'a>(
    config: &'a Config,
    spec: &'static config::SectionSpec,
) -> anyhow::Result<Option<&'a Section>> {
    let mut running = config.running(spec);
    let first = running.next();
    if let (Some(first), Some(second)) = (first, running.next()) {
        bail!("[{}] and [{}] both run: the vessel has one, disable the other", first.name(), second.name());
    }
    Ok(first)
}

/// The serial port of a device.
fn serial(section: &Section) -> anyhow::Result<Place> {
    Place::parse(&section.get(&device::SERIAL_DEVICE), positive(section.get(&device::BAUD_RATE)))
}

/// Initialization strings of a device, without the line ends of the file.
fn init(section: &Section) -> Vec<String> {
    numbered(section, &device::INIT_COMMAND).into_iter().map(|(_, text)| text).collect()
}

/// Numbered texts of a section that are not empty, without the line ends of the file.
fn numbered(section: &Section, texts: &config::Param<Vec<u8>>) -> Vec<(String, String)> {
    let text = |(number, bytes): (&str, Vec<u8>)| {
        (number.to_owned(), String::from_utf8_lossy(&bytes).trim_end().to_owned())
    };
    section.each(texts).into_iter().map(text).filter(|(_, text)| !text.is_empty()).collect()
}

/// A setting of the receiver with the expected answer from the files: only needed for its firmware, `FV?`; for all others
/// the driver knows the answer.
fn with_reply(text: &str, reply: Option<&str>) -> anyhow::Result<String> {
    match reply {
        None => Ok(text.to_owned()),
        Some(reply) if reply == text => Ok(text.to_owned()),
        Some(reply) => match reply.strip_prefix("FV=").filter(|_| text == "FV?") {
            Some(version) => Ok(format!("{text}{version}")),
            None => bail!(
                "`{reply}`: the receiver answers {text} with {text} when it obeys; leave the reply empty"
            ),
        },
    }
}

/// A number that the schema keeps above zero and within 32 bits.
fn positive(number: i64) -> u32 {
    u32::try_from(number).unwrap_or(1)
}

fn compass_of(section: &Section) -> anyhow::Result<ConfiguredDevice> {
    let settings = CompassSettings {
        init: init(section),
        heading_offset_rad: section.get(&compass::HEADING_OFFSET).to_radians(),
        variation_rad: section.get(&compass::MAGNETIC).then(|| section.get(&compass::VARIATION).to_radians()),
        input_timeout: Duration::from_secs_f64(section.get(&compass::INPUT_TIMEOUT)),
        ..CompassSettings::default()
    };
    if section.task() != GPSD_TASK {
        let place = serial(section)?;
        let baud = if let Place::Serial { baud, .. } = &place { Some(*baud) } else { None };
        let driver = Box::new(Compass::new(CompassSettings { baud, ..settings }));
        return Ok(ConfiguredDevice { device: Device::Compass, driver, place });
    }
    let (host, port) = (section.get(&compass::GPSD_HOST), section.get(&compass::GPSD_PORT));
    let place = Place::parse(&format!("tcp://{host}:{port}"), 0)?;
    let driver = Box::new(Gpsd::new(Watch::default(), &settings));
    Ok(ConfiguredDevice { device: Device::Compass, driver, place })
}

/// A receiver of fish tags that only sends lines.
fn line_receiver_of(section: &Section) -> anyhow::Result<ConfiguredDevice> {
    let driver = Box::new(LineReceiver::new(line_receiver_settings(section)?));
    Ok(ConfiguredDevice { device: Device::Hydrophone, driver, place: serial(section)? })
}

pub(super) fn line_receiver_settings(section: &Section) -> anyhow::Result<LineReceiverSettings> {
    let language = match section.get(&line_receiver::RECEIVER) {
        "Pattern" => {
            let text = section.get(&line_receiver::PATTERN);
            Language::Pattern(Pattern::parse(&text).with_context(|| format!("Line Pattern = {text}"))?)
        }
        _ => Language::Innovasea,
    };
    let silence = section.get(&line_receiver::LONGEST_SILENCE);
    Ok(LineReceiverSettings {
        language,
        init: section.each(&device::INIT_COMMAND).into_iter().map(|(_, command)| command).collect(),
        longest_silence: (silence > 0.0).then(|| Duration::from_secs_f64(silence)),
    })
}

/// The receiver of fish tags. Its settings are the initialization strings, in command mode and with their answers.
fn hydrophone_of(section: &Section) -> anyhow::Result<ConfiguredDevice> {
    let mut settings = Vec::new();
    for (number, text) in numbered(section, &device::INIT_COMMAND) {
        if COMMAND_MODE.contains(&text.as_str()) {
            continue;
        }
        let replies = numbered(section, &device::INIT_REPLY);
        let reply = replies.into_iter().find(|(of, _)| *of == number).map(|(_, reply)| reply);
        let text = with_reply(&text, reply.as_deref())
            .with_context(|| format!("Initialization String {number} - Reply"))?;
        settings.push(
            Setting::parse(&text).with_context(|| format!("Initialization String {number} - Command"))?,
        );
    }
    let sync = if section.get(&hydrophone::USE_PPS) {
        Sync::Pulse { period: Duration::from_secs_f64(section.get(&hydrophone::SYNC_PERIOD)) }
    } else {
        Sync::Marks { full_every: positive(section.get(&hydrophone::FULL_STAMP_DIVIDER)) }
    };
    let sensor_interval = init(section).iter().find_map(|text| sensor_interval(text));
    let ack_timeout = Duration::from_secs_f64(section.get(&hydrophone::SYNC_ACK_TIMEOUT));
    let settings =
        ReceiverSettings { settings, sync, sensor_interval, ack_timeout, ..ReceiverSettings::default() };
    Ok(ConfiguredDevice {
        device: Device::Hydrophone,
        driver: Box::new(Receiver::new(settings)),
        place: serial(section)?,
    })
}

/// The interval of sensor reports in the setting LI; `None` for other settings, and if it is off.
fn sensor_interval(setting: &str) -> Option<Duration> {
    let minutes = match setting.strip_prefix("LI=")? {
        "01" => 5,
        "02" => 10,
        "03" => 30,
        "04" => 60,
        "05" => 120,
        "06" => 720,
        "07" => 1440,
        _ => return None,
    };
    Some(Duration::from_mins(minutes))
}

fn motors_of(config: &Config, section: &Section, orders: &Arc<Orders>) -> anyhow::Result<ConfiguredDevice> {
    let (place, wire) = motors_place(section)?;
    let mut motors = motors_config(section)?;
    for user in config.running(&hydrophone::HYDROPHONE) {
        let name = user.get(&hydrophone::POWER_CHANNEL);
        switch_on(&mut motors, &name).with_context(|| about(user))?;
    }
    let motors = Motors::new(motors)?;
    let driver = Box::new(CanMotors::new(motors, wire, Arc::clone(orders)));
    Ok(ConfiguredDevice { device: Device::Motors, driver, place })
}

/// Switches the power channel of a device on from the start.
fn switch_on(motors: &mut MotorsConfig, name: &str) -> anyhow::Result<()> {
    if !name.is_empty() {
        let fed = motors.channels.iter_mut().find(|channel| channel.name == name);
        fed.with_context(|| {
            format!("Power Channel - Name: no channel of the card is called `{name}`; see `Power Channel .. - Name` in its section")
        })?
        .on = true;
    }
    Ok(())
}

/// The port of the card's bus, and its frame format.
///
/// # Errors
/// When the text is not a port, or no adapter supports this bus speed.
pub(crate) fn motors_place(section: &Section) -> anyhow::Result<(Place, Wire)> {
    let text = section.get(&torqeedo::DEVICE);
    let Some(adapter) = text.strip_prefix("slcan:") else {
        if text.contains('/') {
            bail!(
                "CAN Port - Device: `{text}` is not a CAN interface; an adapter on a serial port is written as slcan:{text}"
            );
        }
        return Ok((Place::Can(text), Wire::Kernel(Vec::new())));
    };
    let bits = positive(section.get(&torqeedo::BIT_RATE));
    let bitrate = Bitrate::of_bits(bits).with_context(|| {
        format!("CAN Port - Bit Rate: no slcan adapter has {bits} bit/s; 500000 is usual")
    })?;
    let place =
        Place::parse(adapter, positive(section.get(&torqeedo::BAUD_RATE))).context("CAN Port - Device")?;
    Ok((place, Wire::slcan(bitrate)))
}

/// The card's settings of this vessel.
///
/// # Errors
/// When frequency and divider give no valid interval between two commands.
pub(crate) fn motors_config(section: &Section) -> anyhow::Result<MotorsConfig> {
    let divider = positive(section.get(&torqeedo::WRITE_DIVIDER));
    let write_period = write_period(section.get(&torqeedo::FREQUENCY), divider)
        .context("Execution Frequency and Motor write divider leave no time between two commands")?;
    // Number 1 is the port motor where the configuration says so; the other one is the starboard motor.
    let port = u8::from(section.get(&torqeedo::PORT_MOTOR) == 1);
    let assignment = |motor, reversed| MotorAssignment { motor, reversed };
    let table =
        if section.get(&torqeedo::RAILS) == 4 { ChannelTable::FourRails } else { ChannelTable::FiveRails };
    let states = section.each(&torqeedo::CHANNEL_STATE);
    let mut channels = Vec::new();
    for (label, name) in section.each(&torqeedo::CHANNEL_NAME) {
        if name.is_empty() {
            continue;
        }
        let (rail, channel) = table.place(label).with_context(|| {
            format!("Power Channel {label}: a card of this kind has no such channel; see `Card Rails`")
        })?;
        let on = states.iter().any(|(of, state)| *of == label && *state == 1);
        channels.push(ChannelConfig { name, rail, channel, on });
    }
    Ok(MotorsConfig {
        write_period,
        command_timeout: Duration::from_secs_f64(section.get(&torqeedo::COMMAND_TIMEOUT)),
        sides: Pair::new(
            assignment(port, section.get(&torqeedo::PORT_REVERSED)),
            assignment(1 - port, section.get(&torqeedo::STARBOARD_REVERSED)),
        ),
        channels,
        ..MotorsConfig::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::InMemory;

    fn loaded(more: &str) -> Config {
        let files = InMemory::new().with("otter.ini", format!("{}\n{more}", crate::OTTER_INI));
        let config = Config::load(&files, "otter.ini".as_ref(), &["Hardware"]);
        assert!(!config.report().has_errors(), "{}", config.report());
        config
    }

    fn places(more: &str) -> anyhow::Result<Vec<(Device, String)>> {
        let all = configured_devices(&loaded(more), &Arc::default())?;
        Ok(all.into_iter().map(|one| (one.device, one.place.to_string())).collect())
    }

    fn refused(more: &str) -> String {
        format!("{:#}", places(more).unwrap_err())
    }

    #[test]
    fn the_shipped_configuration_has_a_compass_and_motors_on_the_system_s_bus() {
        let all = places("").unwrap();
        assert!(all.contains(&(Device::Compass, "/dev/ttyUSB0 (115200 bit/s)".to_owned())), "{all:?}");
        assert!(all.contains(&(Device::Motors, "CAN interface can0".to_owned())), "{all:?}");
    }

    #[test]
    fn an_adapter_is_recognised_by_its_prefix_and_a_bare_path_refused() {
        let slcan = "[Actuators.Torqeedo]\nCAN Port - Device = slcan:/dev/ttyACM0\n";
        let all = places(slcan).unwrap();
        assert!(all.contains(&(Device::Motors, "/dev/ttyACM0 (115200 bit/s)".to_owned())), "{all:?}");
        let bare = refused("[Actuators.Torqeedo]\nCAN Port - Device = /dev/ttyACM0\n");
        assert!(bare.contains("[Actuators.Torqeedo]") && bare.contains("slcan:/dev/ttyACM0"), "{bare}");
        let odd = refused(&format!("{slcan}CAN Port - Bit Rate = 300000\n"));
        assert!(odd.contains("no slcan adapter has 300000 bit/s"), "{odd}");
    }

    #[test]
    fn sides_and_power_channels_are_those_of_the_files() {
        let config = loaded(
            "[Actuators.Torqeedo]\nPort Motor - Number = 1\nStarboard Motor - Reversed = true\nCard Rails = 4\n\
             Power Channel H_5V - Name = Modem\nPower Channel H_5V - State = 1\nPower Channel H_AUX1 - Name = Lamp\n",
        );
        let section = config.running(&torqeedo::TORQEEDO).next().unwrap();
        let motors = motors_config(section).unwrap();
        let port = MotorAssignment { motor: 1, reversed: false };
        assert_eq!(motors.sides, Pair::new(port, MotorAssignment { motor: 0, reversed: true }));
        let channel =
            |name: &str, rail, channel, on| ChannelConfig { name: name.to_owned(), rail, channel, on };
        assert_eq!(motors.channels, [channel("Lamp", 2, 1, false), channel("Modem", 3, 5, true)]);
        assert_eq!(motors.write_period, Duration::from_millis(250));
    }

    #[test]
    fn the_hydrophone_s_settings_are_commands_that_a_driver_may_send() {
        let with = |text: &str| {
            places(&format!("[Sensors.ThelmaHydrophone]\nInitialization String 0 - Command = {text}\n"))
        };
        assert!(with("LI=01").unwrap().iter().any(|(device, _)| *device == Device::Hydrophone));
        assert!(with("LIVECM").is_ok());
        let erased = format!("{:#}", with("FS!").unwrap_err());
        assert!(erased.contains("[Sensors.ThelmaHydrophone]") && erased.contains("FS!"), "{erased}");
        assert_eq!(sensor_interval("LI=02"), Some(Duration::from_mins(10)));
        assert_eq!((sensor_interval("LI=00"), sensor_interval("FC=69")), (None, None));
    }

    #[test]
    fn the_reply_of_a_setting_is_what_the_receiver_can_answer() {
        let with = |command: &str, reply: &str| {
            places(&format!(
                "[Sensors.ThelmaHydrophone]\nInitialization String 0 - Command = {command}\n\
                 Initialization String 0 - Reply = {reply}\n"
            ))
        };
        assert!(with("FC=69", "FC=69\\r").is_ok() && with("FV?", "FV=v1.0.6").is_ok());
        assert_eq!(with_reply("FV?", Some("FV=v1.0.6")).unwrap(), "FV?v1.0.6");
        let refused = format!("{:#}", with("FC=69", "FC=71").unwrap_err());
        assert!(
            refused.contains("Initialization String 0 - Reply") && refused.contains("FC=71"),
            "{refused}"
        );
    }

    #[test]
    fn the_channel_that_feeds_the_hydrophone_is_on_from_the_start() {
        let config = loaded("[Actuators.Torqeedo]\nPower Channel H_AUX0 - Name = Receiver\n");
        let mut motors = motors_config(config.running(&torqeedo::TORQEEDO).next().unwrap()).unwrap();
        switch_on(&mut motors, "").unwrap();
        assert!(!motors.channels[0].on);
        switch_on(&mut motors, "Receiver").unwrap();
        assert!(motors.channels[0].on);
        let unknown = refused("[Sensors.ThelmaHydrophone]\nPower Channel - Name = Sonar\n");
        assert!(unknown.contains("[Sensors.ThelmaHydrophone]") && unknown.contains("`Sonar`"), "{unknown}");
    }

    #[test]
    fn sentences_of_gpsd_come_from_its_port() {
        let all = places(
            "[Sensors.GPS]\nEnabled = Never\n[Sensors.GPSDraw]\nEnabled = Hardware\nEntity Label = GPS\n",
        )
        .unwrap();
        assert!(all.contains(&(Device::Compass, "tcp://localhost:2947".to_owned())), "{all:?}");
    }

    #[test]
    fn commands_that_come_too_seldom_for_the_card_are_refused() {
        let slow = refused("[Actuators.Torqeedo]\nExecution Frequency = 4\n");
        assert!(slow.contains("Motor write divider"), "{slow}");
    }

    #[test]
    fn two_compasses_are_refused_by_name() {
        let two = refused("[Sensors.GPS/Second]\nEnabled = Hardware\nEntity Label = GPS 2\n");
        assert!(two.contains("[Sensors.GPS]") && two.contains("[Sensors.GPS/Second]"), "{two}");
    }
}
