//! Output to the vessel: commands, the lease, the chart.

use super::connected::Connected;
use super::machine::Shore;
use super::{Outcome, ShoreOutput};
use crate::ConnectionId;
use crate::commands::Waiting;
use crate::frame::{Capabilities, ChartPart, ChartRequest, Command, Commander, Frame, Lease, MAX_PART_BYTES};
use bytes::Bytes;
use std::time::Duration;
use units::{MonoTime, Now};

/// A lease is sent again this often, and expires aboard after [`LEASE_LASTS`] without that.
const LEASE_EVERY: Duration = Duration::from_secs(10);
const LEASE_LASTS: Duration = Duration::from_secs(30);

impl Shore {
    pub(super) fn command(&mut self, now: Now, id: u64, waiting: Waiting, overtakes: bool) {
        for off in if overtakes { self.commands.call_off() } else { Vec::new() } {
            let text = "a stop was ordered before it could be sent".to_owned();
            self.outputs.push_back(ShoreOutput::Outcome(off, Outcome::Refused(text)));
        }
        if !self.commands.put(id, waiting) {
            let text = "too many commands wait for this vessel, or its identity is taken";
            self.outputs.push_back(ShoreOutput::Outcome(id, Outcome::Refused(text.to_owned())));
        } else if overtakes {
            self.commands_everywhere(now);
        }
    }

    /// Offers the chart over one connection, or over all.
    pub(super) fn offer_chart(&mut self, over: Option<ConnectionId>) {
        let Some(offer) = self.chart.clone() else { return };
        let wanted = |one: &&Connected| {
            one.capabilities.has(Capabilities::CHARTS) && over.is_none_or(|over| over == one.id)
        };
        let ids: Vec<ConnectionId> = self.sessions.values().filter(wanted).map(|one| one.id).collect();
        for id in ids {
            self.send(id, &Frame::Chart(offer.clone()));
        }
    }

    /// Has a part read, if it is of the offered chart; one at a time, however many a vessel requests.
    pub(super) fn chart_ask(&mut self, id: ConnectionId, ask: ChartRequest) {
        let offered = self.chart.as_ref().filter(|chart| chart.digest == ask.digest);
        let Some(left) =
            offered.and_then(|chart| chart.bytes.checked_sub(ask.offset)).filter(|left| *left > 0)
        else {
            self.send(id, &Frame::ChartPart(ChartPart::gone(&ask)));
            return;
        };
        if self.reading.is_none_or(|(reader, _)| reader != id) {
            let length = u64::from(ask.length).min(MAX_PART_BYTES as u64).min(left) as u32;
            let ask = ChartRequest { length, ..ask };
            self.reading = Some((id, ask));
            self.outputs.push_back(ShoreOutput::ChartPart(id, ask));
        }
    }

    pub(super) fn give_part(&mut self, id: ConnectionId, ask: &ChartRequest, bytes: Option<Bytes>) {
        if self.reading.take_if(|reading| *reading == (id, *ask)).is_none() {
            return;
        }
        let Some(connected) = self.sessions.get(&id) else { return };
        let zstd = connected.capabilities.has(Capabilities::ZSTD);
        let bytes = bytes.filter(|bytes| !bytes.is_empty() && bytes.len() <= ask.length as usize);
        let part = bytes.map_or_else(|| ChartPart::gone(ask), |bytes| ChartPart::pack(ask, bytes, zstd));
        self.send(id, &Frame::ChartPart(part));
    }

    /// Sends what can still be in time and was not sent yet over the connection that commands go by; over all, where an
    /// answer is late.
    pub(super) fn commands(&mut self, now: Now) {
        if let Some(id) = self.carrier().map(|one| one.id) {
            self.commands_over(now, id);
        }
        if self.sessions.len() > 1 && self.commands.is_late(now.mono) {
            self.commands_everywhere(now);
        }
    }

    fn commands_everywhere(&mut self, now: Now) {
        let ids: Vec<ConnectionId> = self.sessions.keys().copied().collect();
        for id in ids {
            self.commands_over(now, id);
        }
    }

    fn commands_over(&mut self, now: Now, id: ConnectionId) {
        let capabilities = self.sessions.get(&id).map(|one| one.capabilities).unwrap_or_default();
        if !capabilities.has(Capabilities::COMMANDS) {
            return;
        }
        for (command, waiting) in self.commands.sendable(now.mono, id) {
            // Rounded down: better too early than too late.
            let ttl_ms = waiting.expires.since(now.mono).as_millis() as u32;
            let Waiting { lease, order, times, packet, .. } = waiting;
            let told = if capabilities.has(Capabilities::ORDERS) { order } else { 0 };
            let frame = Command { id: command, sent: now.mono, ttl_ms, lease, order: told, packet };
            self.send(id, &Frame::Command(frame));
            if order > 0 {
                self.outputs.push_back(ShoreOutput::Sent { id: command, order, over: id, times });
            }
        }
    }

    /// When the lease is to be sent again: while it is held and the link is open.
    pub(super) fn lease_due(&self) -> Option<MonoTime> {
        let held = matches!(self.lease, Some(Commander { holder: Some(_), .. }));
        (held && !self.sessions.is_empty()).then_some(self.next_lease)
    }

    /// Sends over all connections who commands, before any command goes over one of them.
    pub(super) fn tell_lease(&mut self, now: Now) {
        self.next_lease = now.mono + LEASE_EVERY;
        let Some(Commander { epoch, holder }) = self.lease.clone() else { return };
        let ttl_ms = if holder.is_some() { LEASE_LASTS.as_millis() as u32 } else { 0 };
        let holder = holder.unwrap_or_default();
        self.leases += 1;
        let told: Vec<(ConnectionId, bool)> =
            self.sessions.values().map(|one| (one.id, one.way.is_some())).collect();
        for (id, numbered) in told {
            let number = if numbered { self.leases } else { 0 };
            self.send(id, &Frame::Lease(Lease { epoch, ttl_ms, holder: holder.clone(), number }));
        }
    }
}
