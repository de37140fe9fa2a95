//! The task that owns the hub, and the handle by which transports, pages and programs use it.
//!
//! Everything goes through one bounded channel, so that a peer's last packets are processed before its departure. A
//! transport that sends faster than the hub processes must wait, which gives backpressure on its peer's socket. The hub
//! itself never waits: packets for a peer go into that peer's [`Outbox`], records into the [`Recorder`]'s queue.

mod ledger;
mod outbox;

pub use ledger::{Ledger, TransportEvent, TransportRecord, Whose};
use outbox::Unsent;
pub use outbox::{AT_ONCE_BYTES, Outbox};

use crate::clock::Clock;
use crate::owners::{Duty, Owners};
use crate::recorder::Recorder;
use api::say;
use bytes::Bytes;
use hub::{Counters, Delivery, Incoming, Peer, PeerId, PeerState, Settings, Telecommand, Transport};
use imc::{Address, PacketView};
use link::Commander;
use operations::Operations;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::Now;

/// Most queued batches and requests to the hub.
const WAITING: usize = 256;
/// Most queued bytes of packets for the hub; beyond that transports, and so their peers' sockets, wait.
const WAITING_BYTES: u32 = 4 << 20;
/// How many of them are processed at once before their results are passed on.
const AT_ONCE: usize = 16;
/// Period of the hub's tick.
const TICK: Duration = Duration::from_secs(1);

/// The controller of each vessel that was ever under control.
pub type Control = BTreeMap<Address, Commander>;

/// A request to [`Operations`], answered by the task that owns it. The services of this crate wrap them in typed methods;
/// other crates cannot make them.
type Request = Box<dyn FnOnce(&mut Operations, Now) + Send>;

enum Message {
    Join(Peer, Arc<Outbox>, oneshot::Sender<PeerId>),
    Leave(PeerId),
    Packets(PeerId, Vec<Incoming>, OwnedSemaphorePermit),
    Request(Request),
    Peers(oneshot::Sender<Vec<PeerFigures>>),
}

/// A peer and its statistics.
#[derive(Debug)]
pub struct PeerFigures {
    /// As the hub knows it.
    pub state: PeerState,
    /// Telemetry packets that were dropped because it does not read fast enough.
    pub dropped: u64,
}

/// The server has ended.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("the server is stopping")]
pub struct Stopped;

/// Handle of the hub; cheap to clone.
#[derive(Clone)]
pub struct Router {
    messages: mpsc::Sender<Message>,
    urgent: mpsc::Sender<Request>,
    room: Arc<Semaphore>,
    revision: watch::Receiver<u64>,
    control: watch::Receiver<Control>,
    clock: Clock,
    address: Address,
    ledger: Ledger,
}

/// A peer's connection to the hub. [`Connection::leave`] ends it.
pub struct Connection {
    /// The peer's number.
    pub id: PeerId,
    /// Packets for it.
    pub outbox: Arc<Outbox>,
    messages: mpsc::Sender<Message>,
    room: Arc<Semaphore>,
}

impl Router {
    /// Starts the hub's task; it ends when `stop` is cancelled.
    pub fn start(
        settings: Settings,
        recorder: Recorder,
        clock: Clock,
        (tasks, owners): (&TaskTracker, &Owners),
        stop: CancellationToken,
    ) -> Self {
        let (messages, waiting) = mpsc::channel(WAITING);
        let (urgent, first) = mpsc::channel(WAITING);
        let (changed, revision) = watch::channel(0);
        let (told, control) = watch::channel(Control::new());
        let address = settings.address;
        let task = Task {
            operations: Operations::new(settings),
            outboxes: BTreeMap::new(),
            full: BTreeSet::new(),
            leases: 0,
            recorder,
            changed,
            told,
            clock: clock.clone(),
        };
        tasks.spawn(task.run(first, waiting, owners.duty("the hub"), stop));
        let room = Arc::new(Semaphore::new(WAITING_BYTES as usize));
        let ledger = Ledger::new(clock.clone());
        Self { messages, urgent, room, revision, control, clock, address, ledger }
    }

    /// The server's clock.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The server's own IMC address.
    pub fn address(&self) -> Address {
        self.address
    }

    /// State of the transports.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Connects a peer whose queue holds `bound_bytes`.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn join(&self, peer: Peer, bound_bytes: usize) -> Result<Connection, Stopped> {
        let outbox = Arc::new(Outbox::new(bound_bytes, self.clock.clone()));
        let (reply, id) = oneshot::channel();
        self.messages.send(Message::Join(peer, Arc::clone(&outbox), reply)).await.map_err(|_| Stopped)?;
        let id = id.await.map_err(|_| Stopped)?;
        Ok(Connection { id, outbox, messages: self.messages.clone(), room: Arc::clone(&self.room) })
    }

    /// Sends a request to the hub's task and waits for the answer.
    pub(crate) async fn ask<T: Send + 'static>(
        &self,
        request: impl FnOnce(&mut Operations, Now) -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        let (reply, answer) = oneshot::channel();
        let request: Request = Box::new(move |operations, now| {
            reply.send(request(operations, now)).ok();
        });
        self.messages.send(Message::Request(request)).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// As [`Router::ask`], ahead of all queued requests: for a stop.
    pub(crate) async fn ask_first<T: Send + 'static>(
        &self,
        request: impl FnOnce(&mut Operations, Now) -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        let (reply, answer) = oneshot::channel();
        let request: Request = Box::new(move |operations, now| {
            reply.send(request(operations, now)).ok();
        });
        self.urgent.send(request).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// As [`Router::ask`], for tests of other crates.
    ///
    /// # Errors
    /// The server has ended.
    #[cfg(feature = "testing")]
    pub async fn inspect<T: Send + 'static>(
        &self,
        request: impl FnOnce(&mut Operations, Now) -> T + Send + 'static,
    ) -> Result<T, Stopped> {
        self.ask(request).await
    }

    /// All connected peers.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn peers(&self) -> Result<Vec<PeerFigures>, Stopped> {
        let (reply, answer) = oneshot::channel();
        self.messages.send(Message::Peers(reply)).await.map_err(|_| Stopped)?;
        answer.await.map_err(|_| Stopped)
    }

    /// Sends a packet of the server itself. Returns whether there was a peer to get it.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn send(&self, packet: Bytes) -> Result<bool, Stopped> {
        self.ask(move |operations, now| operations.hub_mut().send(now, &packet)).await
    }

    /// The hub's counters.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn counters(&self) -> Result<Counters, Stopped> {
        self.ask(|operations, _| operations.hub().counters()).await
    }

    /// The server's own announcement, for the discovery ports; `None` if it is not an active console.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn announcement(&self) -> Result<Option<Bytes>, Stopped> {
        self.ask(|operations, now| operations.hub_mut().announcement(now)).await
    }

    /// Sets the services that the server announces: where its transports listen.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn set_services(&self, services: String) -> Result<(), Stopped> {
        self.ask(move |operations, _| operations.hub_mut().set_services(&services)).await
    }

    /// Sets the transports besides the link that are trusted, and the vessels that have a link.
    pub(crate) async fn believe(&self, trusted: Vec<Transport>, linked: Vec<u16>) -> Result<(), Stopped> {
        let believe = move |operations: &mut Operations, _| {
            operations.hub_mut().trust_transports(trusted);
            operations.hub_mut().set_linked(linked.into_iter().map(Address).collect());
        };
        self.ask(believe).await
    }

    /// Publishes the controller of each vessel.
    pub fn control(&self) -> watch::Receiver<Control> {
        self.control.clone()
    }

    /// Publishes the revision of the last change of the fleet's state, of leases or of commands.
    pub fn revision(&self) -> watch::Receiver<u64> {
        self.revision.clone()
    }
}

impl Connection {
    /// Passes packets of the peer to the hub, waiting while it is busy.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn give(&self, batch: Vec<Incoming>) -> Result<(), Stopped> {
        let bytes: usize = batch.iter().map(|incoming| incoming.packet.len()).sum();
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX).min(WAITING_BYTES);
        let room = Arc::clone(&self.room).acquire_many_owned(bytes).await.map_err(|_| Stopped)?;
        self.messages.send(Message::Packets(self.id, batch, room)).await.map_err(|_| Stopped)
    }

    /// Ends the connection, after all packets that were given.
    pub async fn leave(self) {
        self.messages.send(Message::Leave(self.id)).await.ok();
    }
}

struct Task {
    operations: Operations,
    outboxes: BTreeMap<PeerId, Arc<Outbox>>,
    /// Peers whose queue is full.
    full: BTreeSet<PeerId>,
    /// The revision of the leases that was published last.
    leases: u64,
    recorder: Recorder,
    changed: watch::Sender<u64>,
    told: watch::Sender<Control>,
    clock: Clock,
}

impl Task {
    /// Serves until `stop`. After a panic, packets that the hub has processed are still recorded.
    async fn run(
        mut self,
        mut first: mpsc::Receiver<Request>,
        mut waiting: mpsc::Receiver<Message>,
        duty: Duty,
        stop: CancellationToken,
    ) {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut taken = Vec::with_capacity(AT_ONCE);
        loop {
            let ticks = tokio::select! {
                biased;
                () = stop.cancelled() => break,
                Some(request) = first.recv() => {
                    taken.push(Message::Request(request));
                    false
                }
                _ = tick.tick() => true,
                count = waiting.recv_many(&mut taken, AT_ONCE) => {
                    if count == 0 {
                        break;
                    }
                    false
                }
            };
            let _busy = duty.busy();
            let worked = catch_unwind(AssertUnwindSafe(|| {
                if ticks {
                    self.operations.tick(self.clock.now());
                }
                for message in taken.drain(..) {
                    self.take(message);
                }
            }));
            self.hand_on();
            if worked.is_err() {
                // The duty is dropped unfinished: the server ends.
                return;
            }
        }
        // Packets sent before the end are still recorded.
        first.close();
        while let Ok(request) = first.try_recv() {
            self.take(Message::Request(request));
        }
        waiting.close();
        while let Ok(message) = waiting.try_recv() {
            self.take(message);
        }
        self.hand_on();
        duty.done();
    }

    fn take(&mut self, message: Message) {
        let now = self.clock.now();
        match message {
            Message::Join(peer, outbox, reply) => {
                let id = self.operations.hub_mut().join(now, peer);
                self.outboxes.insert(id, outbox);
                if reply.send(id).is_err() {
                    self.leave(id);
                }
            }
            Message::Leave(peer) => self.leave(peer),
            Message::Packets(peer, batch, _room) => self.operations.hub_mut().packets(now, peer, batch),
            Message::Request(request) => request(&mut self.operations, now),
            Message::Peers(reply) => {
                let dropped = |peer| self.outboxes.get(&peer).map_or(0, |outbox| outbox.dropped());
                let figures = |state: PeerState| PeerFigures { dropped: dropped(state.id), state };
                reply.send(self.operations.hub().peers().into_iter().map(figures).collect()).ok();
            }
        }
    }

    fn leave(&mut self, peer: PeerId) {
        self.operations.hub_mut().leave(peer);
        // Orders that it did not take are sent by another transport, or wait for one.
        let left = self.outboxes.remove(&peer).map(|outbox| outbox.drain()).unwrap_or_default();
        for Delivery { packet, tag } in left {
            let tag = tag.filter(|tag| tag.id.is_some() && !tag.is_copy);
            let (Some(tag), Ok(view)) = (tag, PacketView::unchecked(&packet)) else { continue };
            let order = Telecommand { vessel: view.dst(), tag, packet: packet.clone() };
            self.operations.hub_mut().give_again(self.clock.now(), order);
        }
    }

    fn hand_on(&mut self) {
        let (outboxes, full, mut unsent) = (&self.outboxes, &mut self.full, Vec::new());
        self.operations.hub_mut().drain_deliveries(|peer, packets| {
            if let Some(outbox) = outboxes.get(&peer) {
                let Unsent { called_off, no_room } = outbox.push(packets);
                unsent.extend(
                    called_off.into_iter().map(|id| (id, say("a stop was ordered before it could be sent"))),
                );
                if !outbox.takes() {
                    full.insert(peer);
                }
                let deaf = say("NOT SENT: the connection to the vessel takes nothing at present");
                unsent.extend(no_room.into_iter().map(|id| (id, deaf.clone())));
            }
        });
        self.full.retain(|peer| {
            let takes = self.outboxes.get(peer).is_none_or(|outbox| outbox.takes());
            self.operations.hub_mut().takes(*peer, takes);
            !takes
        });
        for (id, why) in unsent {
            let now = self.clock.now();
            self.operations.commands_mut().refused(now, id, why);
        }
        let records = self.operations.hub_mut().drain_records();
        if !records.is_empty() {
            self.recorder.submit(records);
        }
        self.publish();
    }

    /// Publishes the revision, and the controllers if they changed.
    fn publish(&mut self) {
        let (leases, commands) = (self.operations.leases(), self.operations.commands());
        if std::mem::replace(&mut self.leases, leases.revision()) != leases.revision() {
            let control = leases.changed(0).map(|(vessel, lease)| {
                let holder = lease.held.as_ref().map(|held| held.holder.name.clone());
                (vessel, Commander { epoch: lease.last_epoch, holder })
            });
            let control: Control = control.filter(|(_, commander)| commander.epoch > 0).collect();
            self.told.send_if_modified(|known| {
                let differs = *known != control;
                *known = control;
                differs
            });
        }
        let alarms = self.operations.alarms().revision();
        let revision = self.operations.fleet().revision() + leases.revision() + commands.revision() + alarms;
        self.changed.send_if_modified(|known| std::mem::replace(known, revision) != revision);
    }
}
