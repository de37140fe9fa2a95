//! The task that owns the hub, and the handle by which doors, pages and programs talk to it.
//!
//! Everything goes through one bounded channel, so that what a peer said last is heard before it leaves. A door
//! that sends faster than the hub takes waits, and so its peer's socket does. The hub itself waits for nobody:
//! what it says to a peer goes into that peer's [`Outbox`], what it records into the [`Recorder`]'s queue.

mod ledger;
mod outbox;
mod recorder;

pub(crate) use ledger::{DoorRecord, Happened, Ledger};
use outbox::Unsent;
pub(crate) use outbox::{AT_ONCE_BYTES, Outbox};
pub(crate) use recorder::{Recorder, RecorderState, WAITING_BYTES};

use crate::clock::Clock;
use crate::owners::{Duty, Owners};
use bytes::Bytes;
use hub::{Delivery, Hub, Incoming, Now, Peer, PeerId, PeerState, Settings, Telecommand};
use imc::{Address, PacketView};
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Batches and questions that may wait for the hub.
const WAITING: usize = 256;
/// Bytes of packets that may wait for the hub; doors wait, and so their peers' sockets do, when there are more.
const UNHEARD_BYTES: u32 = 4 << 20;
/// How many of them are taken at once before what came of them is handed on.
const AT_ONCE: usize = 16;
/// How often the hub is told that time passes.
const TICK: Duration = Duration::from_secs(1);

/// Who commands each vessel whose control anybody ever had: the epoch, and the holder's name or nobody.
pub(crate) type Control = BTreeMap<Address, (u64, Option<String>)>;

/// A question to the hub, which the hub's task answers.
type Look = Box<dyn FnOnce(&mut Hub, Now) + Send>;

enum Ask {
    Join(Peer, Arc<Outbox>, oneshot::Sender<PeerId>),
    Leave(PeerId),
    Packets(PeerId, Vec<Incoming>, OwnedSemaphorePermit),
    Look(Look),
    Peers(oneshot::Sender<Vec<PeerFigures>>),
}

/// A peer and how it keeps up.
#[derive(Debug)]
pub(crate) struct PeerFigures {
    /// As the hub knows it.
    pub(crate) state: PeerState,
    /// Telemetry packets that were dropped because it does not read.
    pub(crate) dropped: u64,
}

/// The server has ended.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("the server is stopping")]
pub(crate) struct Stopped;

/// The way to the hub; cheap to clone.
#[derive(Clone)]
pub(crate) struct Relay {
    asks: mpsc::Sender<Ask>,
    urgent: mpsc::Sender<Look>,
    room: Arc<Semaphore>,
    revision: watch::Receiver<u64>,
    control: watch::Receiver<Control>,
    clock: Clock,
    address: Address,
    ledger: Ledger,
}

/// A peer's connection to the hub. [`Connection::leave`] ends it.
pub(crate) struct Connection {
    /// The peer's number.
    pub(crate) id: PeerId,
    /// What the hub says to it.
    pub(crate) outbox: Arc<Outbox>,
    asks: mpsc::Sender<Ask>,
    room: Arc<Semaphore>,
}

impl Relay {
    /// Starts the hub's task; it ends when `stop` says so.
    pub(crate) fn start(
        settings: Settings,
        recorder: Recorder,
        clock: Clock,
        (tasks, owners): (&TaskTracker, &Owners),
        stop: CancellationToken,
    ) -> Self {
        let (asks, waiting) = mpsc::channel(WAITING);
        let (urgent, first) = mpsc::channel(WAITING);
        let (changed, revision) = watch::channel(0);
        let (told, control) = watch::channel(Control::new());
        let address = settings.address;
        let task = Task {
            hub: Hub::new(settings),
            outboxes: BTreeMap::new(),
            full: BTreeSet::new(),
            recorder,
            changed,
            told,
            clock: clock.clone(),
        };
        tasks.spawn(task.run(first, waiting, owners.duty("the hub"), stop));
        let room = Arc::new(Semaphore::new(UNHEARD_BYTES as usize));
        let ledger = Ledger::new(clock.clone());
        Self { asks, urgent, room, revision, control, clock, address, ledger }
    }

    /// The server's clock.
    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The server's own IMC address.
    pub(crate) fn address(&self) -> Address {
        self.address
    }

    /// What happened at the doors.
    pub(crate) fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Connects a peer whose queue holds `bound_bytes`.
    pub(crate) async fn join(&self, peer: Peer, bound_bytes: usize) -> Result<Connection, Stopped> {
        let outbox = Arc::new(Outbox::new(bound_bytes, self.clock.clone()));
        let (reply, id) = oneshot::channel();
        self.asks.send(Ask::Join(peer, Arc::clone(&outbox), reply)).await.map_err(|_| Stopped)?;
        let id = id.await.map_err(|_| Stopped)?;
        Ok(Connection { id, outbox, asks: self.asks.clone(), room: Arc::clone(&self.room) })
    }

    /// Runs `look` where the hub lives and gives what it returns.
    pub(crate) async fn look<T: Send + 'static>(
        &self,
        look: impl FnOnce(&mut Hub, Now) -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        let (reply, answer) = oneshot::channel();
        let look: Look = Box::new(move |hub, now| {
            reply.send(look(hub, now)).ok();
        });
        self.asks.send(Ask::Look(look)).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// As [`Relay::look`], ahead of everything that waits for the hub: for a stop.
    pub(crate) async fn look_first<T: Send + 'static>(
        &self,
        look: impl FnOnce(&mut Hub, Now) -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        let (reply, answer) = oneshot::channel();
        let look: Look = Box::new(move |hub, now| {
            reply.send(look(hub, now)).ok();
        });
        self.urgent.send(look).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// Everyone who is connected.
    pub(crate) async fn peers(&self) -> Result<Vec<PeerFigures>, Stopped> {
        let (reply, answer) = oneshot::channel();
        self.asks.send(Ask::Peers(reply)).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// Sends a packet of the server's own. Whether a peer was there to hear it.
    pub(crate) async fn send(&self, packet: Bytes) -> Result<bool, Stopped> {
        self.look(move |hub, now| hub.send(now, &packet)).await
    }

    /// Tells who commands which vessel.
    pub(crate) fn control(&self) -> watch::Receiver<Control> {
        self.control.clone()
    }

    /// Tells when the fleet's state changed, or who commands, or what became of a command: the revision of the last change.
    pub(crate) fn revision(&self) -> watch::Receiver<u64> {
        self.revision.clone()
    }
}

impl Connection {
    /// Hands packets of the peer to the hub, waiting while it is busy.
    pub(crate) async fn give(&self, batch: Vec<Incoming>) -> Result<(), Stopped> {
        let bytes: usize = batch.iter().map(|incoming| incoming.packet.len()).sum();
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX).min(UNHEARD_BYTES);
        let room = Arc::clone(&self.room).acquire_many_owned(bytes).await.map_err(|_| Stopped)?;
        self.asks.send(Ask::Packets(self.id, batch, room)).await.map_err(|_| Stopped)
    }

    /// Ends the connection, after everything that was given.
    pub(crate) async fn leave(self) {
        self.asks.send(Ask::Leave(self.id)).await.ok();
    }
}

struct Task {
    hub: Hub,
    outboxes: BTreeMap<PeerId, Arc<Outbox>>,
    /// Peers for which nothing more has room.
    full: BTreeSet<PeerId>,
    recorder: Recorder,
    changed: watch::Sender<u64>,
    told: watch::Sender<Control>,
    clock: Clock,
}

impl Task {
    /// Serves until `stop`. After a fault what the hub had heard is still recorded.
    async fn run(
        mut self,
        mut first: mpsc::Receiver<Look>,
        mut waiting: mpsc::Receiver<Ask>,
        duty: Duty,
        stop: CancellationToken,
    ) {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut asks = Vec::with_capacity(AT_ONCE);
        loop {
            let ticks = tokio::select! {
                biased;
                () = stop.cancelled() => break,
                Some(look) = first.recv() => {
                    asks.push(Ask::Look(look));
                    false
                }
                _ = tick.tick() => true,
                count = waiting.recv_many(&mut asks, AT_ONCE) => {
                    if count == 0 {
                        break;
                    }
                    false
                }
            };
            let _busy = duty.busy();
            let worked = catch_unwind(AssertUnwindSafe(|| {
                if ticks {
                    self.hub.tick(self.clock.now());
                }
                for ask in asks.drain(..) {
                    self.ask(ask);
                }
            }));
            self.hand_on();
            if worked.is_err() {
                // The duty is dropped undone: the server ends.
                return;
            }
        }
        // What was said before the end is still recorded.
        first.close();
        while let Ok(look) = first.try_recv() {
            self.ask(Ask::Look(look));
        }
        waiting.close();
        while let Ok(ask) = waiting.try_recv() {
            self.ask(ask);
        }
        self.hand_on();
        duty.done();
    }

    fn ask(&mut self, ask: Ask) {
        let now = self.clock.now();
        match ask {
            Ask::Join(peer, outbox, reply) => {
                let id = self.hub.join(now, peer);
                self.outboxes.insert(id, outbox);
                if reply.send(id).is_err() {
                    self.leave(id);
                }
            }
            Ask::Leave(peer) => self.leave(peer),
            Ask::Packets(peer, batch, _room) => self.hub.packets(now, peer, batch),
            Ask::Look(look) => look(&mut self.hub, now),
            Ask::Peers(reply) => {
                let dropped = |peer| self.outboxes.get(&peer).map_or(0, |outbox| outbox.dropped());
                let figures = |state: PeerState| PeerFigures { dropped: dropped(state.id), state };
                reply.send(self.hub.peers().into_iter().map(figures).collect()).ok();
            }
        }
    }

    fn leave(&mut self, peer: PeerId) {
        self.hub.leave(peer);
        // Orders that it did not take go by another way, or wait for one.
        let left = self.outboxes.remove(&peer).map(|outbox| outbox.drain()).unwrap_or_default();
        for Delivery { packet, tag } in left {
            let (Some(tag), Ok(view)) = (tag.filter(|tag| tag.id.is_some()), PacketView::unchecked(&packet))
            else {
                continue;
            };
            let order = Telecommand { vessel: view.dst(), tag, packet: packet.clone() };
            self.hub.give_again(self.clock.now(), order);
        }
    }

    fn hand_on(&mut self) {
        let (outboxes, full, mut unsent) = (&self.outboxes, &mut self.full, Vec::new());
        self.hub.drain_deliveries(|peer, packets| {
            if let Some(outbox) = outboxes.get(&peer) {
                let Unsent { called_off, no_room } = outbox.push(packets);
                unsent.extend(
                    called_off.into_iter().map(|id| (id, "a stop was ordered before it could be sent")),
                );
                if !outbox.takes() {
                    full.insert(peer);
                }
                let deaf = "NOT SENT: the connection to the vessel takes nothing at present";
                unsent.extend(no_room.into_iter().map(|id| (id, deaf)));
            }
        });
        self.full.retain(|peer| {
            let takes = self.outboxes.get(peer).is_none_or(|outbox| outbox.takes());
            self.hub.takes(*peer, takes);
            !takes
        });
        for (id, why) in unsent {
            let now = self.clock.now();
            self.hub.commands_mut().refused(now, id, why.to_owned());
        }
        let records = self.hub.drain_records();
        if !records.is_empty() {
            self.recorder.submit(records);
        }
        let (leases, commands) = (self.hub.leases(), self.hub.commands());
        let control = leases.changed(0).map(|(vessel, lease)| {
            let holder = lease.held.as_ref().map(|held| held.holder.name.clone());
            (vessel, (lease.last_epoch, holder))
        });
        let control: Control = control.filter(|(_, (epoch, _))| *epoch > 0).collect();
        self.told.send_if_modified(|known| {
            let differs = *known != control;
            *known = control;
            differs
        });
        let alarms = self.hub.alarms().revision();
        let revision = self.hub.fleet().revision() + leases.revision() + commands.revision() + alarms;
        self.changed.send_if_modified(|known| std::mem::replace(known, revision) != revision);
    }
}
