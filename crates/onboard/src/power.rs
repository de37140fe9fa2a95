//! Power channels: consoles' orders, the card's reports, and whether it carries the orders out.
//!
//! A channel is known by the name that the configuration gives it. An order goes to the card's driver; what the card
//! reports goes to the bus, and an order that it does not follow in time is reported to its sender.

use crate::bus::{Asker, Bus};
use crate::entity::Entity;
use crate::output::{Level, Output};
use crate::settings::PowerChannel;
use devices::PowerChannelReading;
use imc::messages::{PowerChannelControl, PowerChannelControlOp, PowerChannelState, PowerChannelStateState};
use std::time::Duration;
use units::MonoTime;

/// The driver asks the card several times within this time.
const FOLLOWS_WITHIN: Duration = Duration::from_secs(5);

/// An order that the card has not followed yet.
#[derive(Debug)]
struct Asked {
    on: bool,
    by: Asker,
    until: MonoTime,
}

#[derive(Debug)]
struct Channel {
    config: PowerChannel,
    /// As the card reported last.
    on: Option<bool>,
    asked: Option<Asked>,
}

/// All power channels.
#[derive(Debug)]
pub(crate) struct Power(Vec<Channel>);

impl Power {
    pub(crate) fn new(channels: &[PowerChannel]) -> Self {
        Self(
            channels.iter().map(|config| Channel { config: config.clone(), on: None, asked: None }).collect(),
        )
    }

    /// An order to switch a channel; `who` gave it.
    pub(crate) fn control(&mut self, bus: &mut Bus, by: Asker, who: &str, request: &PowerChannelControl) {
        let name = request.name.to_str_lossy();
        match self.order(bus, by, &name, request.op) {
            Ok(on) => {
                let text = format!("power channel `{name}` is to be {}, by {who}", word(on));
                bus.entry(Entity::Daemon, Level::Info, text);
                bus.put(Output::Power { channel: name.into_owned(), on });
            }
            Err(why) => {
                let text = format!("power channel `{name}` is not switched: {why}");
                bus.entry_to(Entity::Daemon, by, Level::Warning, text);
            }
        }
    }

    fn order(
        &mut self,
        bus: &Bus,
        by: Asker,
        name: &str,
        operation: PowerChannelControlOp,
    ) -> Result<bool, String> {
        let Some(channel) = self.0.iter_mut().find(|channel| channel.config.name == name) else {
            let known: Vec<&str> = self.0.iter().map(|channel| &channel.config.name[..]).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(format!("the configuration names {known}"));
        };
        let on = match operation {
            PowerChannelControlOp::TurnOn => true,
            PowerChannelControlOp::TurnOff => false,
            PowerChannelControlOp::Toggle => {
                let stands = channel.asked.as_ref().map(|asked| asked.on).or(channel.on);
                !stands.ok_or("the card has not reported it yet, so that it cannot be turned over")?
            }
            _ => return Err("it can be turned on, off and over; schedules are not kept aboard".to_owned()),
        };
        channel.asked = Some(Asked { on, by, until: bus.mono() + FOLLOWS_WITHIN });
        Ok(on)
    }

    /// The card reports a channel: to the bus, from the rail that it hangs on.
    pub(crate) fn reading(&mut self, bus: &mut Bus, reading: &PowerChannelReading) {
        if let Some(channel) = self.0.iter_mut().find(|channel| channel.config.name == reading.name) {
            channel.on = Some(reading.on);
            channel.asked.take_if(|asked| asked.on == reading.on);
        }
        if let Some(rail) = Entity::rail(reading.rail) {
            bus.send(rail, &state(&reading.name, reading.on));
        }
    }

    /// Answers the states of all channels that the card has reported.
    pub(crate) fn answer(&self, bus: &mut Bus, asker: Asker) {
        for Channel { config, on, .. } in &self.0 {
            if let (Some(rail), Some(on)) = (Entity::rail(config.rail), on) {
                bus.send_to(rail, asker, &state(&config.name, *on));
            }
        }
    }

    /// Reports orders that the card has not carried out in time.
    pub(crate) fn watch(&mut self, bus: &mut Bus) {
        for Channel { config, on, asked } in &mut self.0 {
            let late = asked.take_if(|asked| bus.mono() >= asked.until);
            // The card seldom reports an unchanged channel: one that was switched and switched back gives no report.
            if let Some(Asked { on: wanted, by, .. }) = late.filter(|late| *on != Some(late.on)) {
                let stands = on.map_or("is not reported", |on| if on { "is on" } else { "is off" });
                let text = format!(
                    "power channel `{}` was to be {} and the card does not follow: it {stands}; look at the fuse of rail {} \
                     and at the motors' CAN bus",
                    config.name,
                    word(wanted),
                    config.rail
                );
                bus.entry_to(Entity::Daemon, by, Level::Error, text);
            }
        }
    }
}

fn word(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

fn state(name: &str, on: bool) -> PowerChannelState {
    let state = if on { PowerChannelStateState::On } else { PowerChannelStateState::Off };
    PowerChannelState { name: name.into(), state }
}
