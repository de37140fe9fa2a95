//! The hub and its operators' services, as one machine.

use crate::alarms::{Alarms, ShoreState};
use crate::commands::{Commands, Order, OrderedBy};
use crate::leases::{Holder, LeaseRefused, Leases};
use api::{Said, say};
use hub::{CALLED_OFF, CommandId, Dispatched, Fleet, Hub, OrderLog as _, Settings};
use imc::messages::{Payload as _, PlanControlState, PlanControlStateState};
use imc::{Address, PacketView};
use units::Now;

/// The hub, the leases, the commands and the alarms.
#[derive(Debug)]
pub struct Operations {
    hub: Hub<Commands>,
    leases: Leases,
    alarms: Alarms,
}

/// Why an order is not taken.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotOrdered {
    /// Another person commands the vessel.
    #[error(transparent)]
    NoControl(#[from] LeaseRefused),
    /// A stop came in between.
    #[error("{CALLED_OFF}")]
    CalledOff,
    /// The order is not valid, or cannot be taken now.
    #[error("{0}")]
    Refused(Said),
}

impl Operations {
    /// No peers, no orders, no alarms.
    pub fn new(settings: Settings) -> Self {
        let commands = Commands::new(settings.address);
        Self { hub: Hub::new(settings, commands), leases: Leases::default(), alarms: Alarms::default() }
    }

    /// Routing.
    pub fn hub(&self) -> &Hub<Commands> {
        &self.hub
    }

    /// Routing, to pass packets to it and to drain it.
    pub fn hub_mut(&mut self) -> &mut Hub<Commands> {
        &mut self.hub
    }

    /// The live state of the fleet.
    pub fn fleet(&self) -> &Fleet {
        self.hub.fleet()
    }

    /// Who commands which vessel.
    pub fn leases(&self) -> &Leases {
        &self.leases
    }

    /// Who commands which vessel, to change it.
    pub fn leases_mut(&mut self) -> &mut Leases {
        &mut self.leases
    }

    /// Orders, and their outcome.
    pub fn commands(&self) -> &Commands {
        self.hub.orders()
    }

    /// Orders, to add to them.
    pub fn commands_mut(&mut self) -> &mut Commands {
        self.hub.orders_mut()
    }

    /// The alarms.
    pub fn alarms(&self) -> &Alarms {
        &self.alarms
    }

    /// The alarms, to acknowledge or shelve them.
    pub fn alarms_mut(&mut self) -> &mut Alarms {
        &mut self.alarms
    }

    /// Advances the time. Call it once a second.
    pub fn tick(&mut self, now: Now) {
        self.leases.tick(now);
        self.hub.tick(now);
        self.hub.orders_mut().tick(now);
    }

    /// Derives the alarms from the state of the fleet and of the shore. Call it once a second.
    pub fn watch(&mut self, now: Now, shore: &ShoreState) {
        let contradictions = self.hub.contradictions(now.mono);
        self.alarms.watch(now, self.hub.fleet(), &ShoreState { contradictions, ..shore.clone() });
    }

    /// Takes an order under the lease of the person who gives it, before it is written into the audit log. `stops` is what
    /// [`Commands::stops`] was when the order began to be prepared: if a stop came since, the order is not given.
    ///
    /// # Errors
    /// Another person commands the vessel, a stop came in between, or the order is not valid.
    pub fn begin(
        &mut self,
        now: Now,
        vessel: Address,
        (asked, holder): (&OrderedBy, &Holder),
        order: Order,
        stops: u64,
    ) -> Result<CommandId, NotOrdered> {
        let epoch = if order.takes_lease() { self.leases.epoch(now, vessel, holder)? } else { 0 };
        if order.commands() && self.commands().stops(vessel) != stops {
            return Err(NotOrdered::CalledOff);
        }
        self.commands_mut().begin(now, vessel, asked, epoch, order).map_err(NotOrdered::Refused)
    }

    /// Sends an order that is in the audit log, if the lease that it was given under still holds; `holder` is `None` for
    /// an order that needs none. `None` if it is not sent.
    pub fn dispatch(&mut self, now: Now, id: CommandId, holder: Option<&Holder>) -> Option<Dispatched> {
        let command = self.commands().get(id)?;
        let (vessel, epoch) = (command.vessel, command.epoch);
        if epoch != 0 && holder.is_none_or(|holder| self.leases.epoch(now, vessel, holder) != Ok(epoch)) {
            self.commands_mut().refused(now, id, say("control was lost before it was sent"));
            return None;
        }
        let ran = self.running(vessel);
        let order = self.commands_mut().accepted(now, id, ran)?;
        let dispatched = self.hub.dispatch(now, order);
        self.commands_mut().dispatched(now, id, &dispatched);
        Some(dispatched)
    }

    /// Stops a vessel. It needs no lease and does not wait.
    ///
    /// # Errors
    /// Never for a stop of a vessel's own address; what [`Commands::begin`] refuses.
    pub fn stop(
        &mut self,
        now: Now,
        vessel: Address,
        asked: &OrderedBy,
    ) -> Result<(CommandId, Option<Dispatched>), Said> {
        let id = self.commands_mut().begin(now, vessel, asked, 0, Order::Stop)?;
        Ok((id, self.dispatch(now, id, None)))
    }

    /// The plan that a vessel reports as executed.
    pub fn running(&self, vessel: Address) -> Option<String> {
        let state = self.plan_state(vessel)?;
        Some(state.plan_id.to_str_lossy().into_owned())
    }

    /// A vessel's last report of the plan that it executes; `None` while it executes none.
    pub fn plan_state(&self, vessel: Address) -> Option<PlanControlState> {
        let (_, series) = self.fleet().system(vessel)?.latest(PlanControlState::ID)?;
        let state: PlanControlState = imc::decode(&PacketView::unchecked(series.packet()).ok()?).ok()??;
        let runs =
            matches!(state.state, PlanControlStateState::Executing | PlanControlStateState::Initializing);
        runs.then_some(state)
    }
}
