//! The battery reserve among the other supervisors: its reports.

use super::{Context, Supervise, clock_text, outlook_text};
use crate::arbiter::Source;
use crate::entity::Entity;
use crate::sensors::Sensors;
use crate::states::Condition;
use imc::messages::FuelLevel;
use mission::BatteryStage;
use std::time::Duration;

const FUEL_REPORT: Duration = Duration::from_secs(10);

impl Supervise {
    /// Whether the batteries are below their warning level.
    pub(crate) fn battery_is_low(&self) -> bool {
        self.battery.stage() != BatteryStage::Normal
    }

    pub(super) fn tell_battery(&mut self, context: &mut Context<'_>, sensors: &Sensors) {
        let silent = sensors.silent_batteries();
        let Some(percent) = sensors.charge_percent() else {
            let (condition, text) = if silent.is_empty() {
                (Condition::Normal, "no battery reports; nothing is watched until one does".to_owned())
            } else {
                let text = format!("{} no longer reports; what was last asked stays", silent.join(", "));
                (Condition::Fault, text)
            };
            context.states.set(context.bus, Entity::Fuel, condition, text);
            return;
        };
        let (power_w, used_wh) = sensors.power_w();
        let left_wh = context.capacity_wh * percent / 100.0;
        let hours = (power_w > 1.0).then(|| left_wh / power_w);
        let next = match (self.battery.outlook(), self.battery.next_warning()) {
            (Some(outlook), _) => outlook_text(context.bus, &outlook),
            (None, Some((charge, at))) => {
                let at = at.map_or_else(String::new, |at| format!(" at {}", clock_text(context.bus, at)));
                format!("a warning below {:.0} %{at}", 100.0 * charge)
            }
            (None, None) => "nothing further".to_owned(),
        };
        let mut parts = vec![format!("{percent:.0} %, {power_w:.0} W, {used_wh:.0} Wh used")];
        if !silent.is_empty() {
            parts.push(format!("{} does not report", silent.join(", ")));
        }
        parts.extend(self.standing(context.bus, Source::Battery));
        parts.push(format!("next: {next}"));
        let condition = match self.battery.stage() {
            BatteryStage::Normal if silent.is_empty() => Condition::Normal,
            BatteryStage::Normal | BatteryStage::Low => Condition::Fault,
            BatteryStage::Reserve | BatteryStage::Critical => Condition::Error,
        };
        context.states.set(context.bus, Entity::Fuel, condition, parts.join("; "));
        if context.bus.mono() >= self.next_fuel {
            self.next_fuel = context.bus.mono() + FUEL_REPORT;
            let opmodes = hours.map_or_else(String::new, |hours| format!("Present={hours:.1}"));
            let level = FuelLevel { value: percent as f32, confidence: 100.0, opmodes: opmodes.into() };
            context.bus.send(Entity::Fuel, &level);
        }
    }
}
