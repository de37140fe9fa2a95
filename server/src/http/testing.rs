//! A fleet and a history that tests make up.

use crate::shore::{Changes, Fleet, FleetQuestion, History, Wanted};
use api::{ExportQuery, Field, Fix, Liveness, Recorded, System, TrackPoint, TrackQuery, Update};
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::{Arc, Mutex};
use tokio::sync::{mpsc, watch};
use units::UtcTime;

/// Owns a made-up fleet.
#[derive(Clone)]
pub(crate) struct MadeUp(Arc<Inner>);

struct Inner {
    state: Mutex<State>,
    changed: watch::Sender<u64>,
}

#[derive(Default)]
struct State {
    revision: u64,
    systems: BTreeMap<u16, System>,
    /// By system and message: the latest, and the revisions of all.
    series: BTreeMap<(u16, String), (Update, Vec<u64>)>,
    events: Vec<(u64, Update)>,
}

impl MadeUp {
    /// An empty fleet and its handle.
    pub(crate) fn start() -> (Self, Fleet) {
        let (questions, mut asked) = mpsc::channel(16);
        let (changed, revision) = watch::channel(0);
        let made_up = Self(Arc::new(Inner { state: Mutex::default(), changed }));
        let answering = made_up.clone();
        tokio::spawn(async move {
            while let Some(question) = asked.recv().await {
                answering.answer(question);
            }
        });
        (made_up, Fleet::new(questions, revision))
    }

    fn answer(&self, question: FleetQuestion) {
        let state = self.0.state.lock().unwrap();
        let systems = |wanted: &Wanted| {
            let admitted = state.systems.values().filter(|system| wanted.admits_system(system.address));
            admitted.cloned().collect::<Vec<_>>()
        };
        match question {
            FleetQuestion::Systems { wanted, answer } => drop(answer.send(systems(&wanted))),
            FleetQuestion::Changes { since, wanted, answer } => {
                let mut changes =
                    Changes { revision: state.revision, systems: systems(&wanted), ..Changes::default() };
                for (update, revisions) in state.series.values() {
                    let new = revisions.iter().filter(|revision| **revision > since).count() as u64;
                    let wants = wanted.admits_system(update.system) && wanted.admits_message(&update.abbrev);
                    if new > 0 && wants {
                        changes.skipped += if since == 0 { 0 } else { new - 1 };
                        changes.values.push(update.clone());
                    }
                }
                if wanted.events {
                    let new = state.events.iter().filter(|(revision, _)| *revision > since);
                    changes.events = new.map(|(_, event)| event.clone()).collect();
                }
                drop(answer.send(changes));
            }
        }
    }

    fn change(&self, change: impl FnOnce(&mut State, u64)) {
        let mut state = self.0.state.lock().unwrap();
        state.revision += 1;
        let revision = state.revision;
        change(&mut state, revision);
        drop(state);
        self.0.changed.send_replace(revision);
    }

    /// A system is, or is now like this.
    pub(crate) fn system(&self, system: System) {
        self.change(|state, _| drop(state.systems.insert(system.address, system)));
    }

    /// A value came.
    pub(crate) fn value(&self, update: Update) {
        self.change(|state, revision| {
            let key = (update.system, update.abbrev.clone());
            let series = state.series.entry(key).or_insert_with(|| (update.clone(), Vec::new()));
            series.0 = update;
            series.1.push(revision);
        });
    }

    /// An event came.
    pub(crate) fn event(&self, update: Update) {
        self.change(|state, revision| state.events.push((revision, update)));
    }
}

/// A boat at this time: it sails a circle of 300 m around a place that its number tells.
pub(crate) fn boat(number: u16, now: UtcTime) -> (System, Vec<Update>) {
    let seconds = (now.micros() % 600_000_000) as f64 / 1e6;
    let along = seconds / 600.0 * std::f64::consts::TAU + f64::from(number);
    let (lat, lon) = (63.44 + 0.004 * f64::from(number), 10.40 + 0.006 * f64::from(number));
    let fix = Fix {
        time_us: now.micros(),
        lat_deg: lat + 0.0027 * along.cos(),
        lon_deg: lon + 0.006 * along.sin(),
        heading_rad: Some((along + std::f64::consts::FRAC_PI_2).rem_euclid(std::f64::consts::TAU)),
        course_rad: Some((along + std::f64::consts::FRAC_PI_2).rem_euclid(std::f64::consts::TAU)),
        speed_mps: Some(1.5),
    };
    let address = 0x0814 + number;
    let system = System {
        address,
        name: (number < 3).then(|| format!("otter-{number}")),
        kind: (number < 3).then(|| "USV".to_owned()),
        liveness: if number == 2 { Liveness::Stale } else { Liveness::Live },
        heard_us: now.micros() - if number == 2 { 7_000_000 } else { 0 },
        doors: vec!["link".to_owned()],
        fix: (number < 3).then_some(fix),
        entities: [(1, "Navigation".to_owned()), (2, "<b>Battery</b>".to_owned())].into(),
    };
    let update = |id, abbrev: &str, entity, fields: Vec<Field>| Update {
        system: address,
        id,
        abbrev: abbrev.to_owned(),
        entity,
        instance: None,
        time_us: now.micros(),
        received_us: system.heard_us,
        period_s: Some(0.1),
        fields,
    };
    let updates = vec![
        update(
            350,
            "EstimatedState",
            1,
            vec![
                field("lat", fix.lat_deg.to_radians().into(), "rad"),
                field("lon", fix.lon_deg.to_radians().into(), "rad"),
                field("psi", fix.heading_rad.into(), "rad"),
                field("u", 1.5.into(), "m/s"),
            ],
        ),
        update(
            252,
            "Voltage",
            2,
            vec![
                field("value", (24.0 + seconds / 100.0).into(), "V"),
                field("spare", serde_json::Value::Null, ""),
            ],
        ),
        update(3, "LogBookEntry", 255, vec![field("text", "<img src=x onerror=alert(1)>".into(), "")]),
    ];
    (system, updates)
}

fn field(name: &str, value: serde_json::Value, unit: &str) -> Field {
    Field { name: name.to_owned(), value, unit: unit.to_owned(), meaning: None }
}

/// Lets three boats and an unknown system speak ten times a second, for as long as the test lasts.
pub(crate) fn sail(fleet: &MadeUp) {
    let fleet = fleet.clone();
    tokio::spawn(async move {
        let mut interval = tokio::time::interval(std::time::Duration::from_millis(100));
        loop {
            interval.tick().await;
            for number in 0..4 {
                let (system, updates) = boat(number, crate::clock::now());
                fleet.system(system);
                for update in updates {
                    fleet.value(update);
                }
            }
        }
    });
}

/// A history of an hour of [`boat`]s.
pub(crate) struct MadeUpHistory {
    /// Rows after which an export fails.
    pub(crate) fails_after: Option<u32>,
}

impl History for MadeUpHistory {
    fn recorded(&self) -> anyhow::Result<Vec<Recorded>> {
        let recorded = |system| Recorded {
            system,
            abbrev: "EstimatedState".to_owned(),
            count: 3,
            first_us: 0,
            last_us: 2_000_000,
        };
        Ok(vec![recorded(0x0814), recorded(0x0815)])
    }

    fn track(&self, vessel: u16, query: &TrackQuery) -> anyhow::Result<Vec<TrackPoint>> {
        let step = (query.to_us - query.from_us).max(1) / 400;
        let at = |index| {
            let time_us = query.from_us + step * index;
            let fix = boat(vessel - 0x0814, UtcTime::from_micros(time_us)).0.fix?;
            Some(TrackPoint { time_us, lat_deg: fix.lat_deg, lon_deg: fix.lon_deg })
        };
        Ok((0..400).filter_map(at).collect())
    }

    fn export(
        &self,
        query: &ExportQuery,
        may: &dyn Fn(u16) -> bool,
        out: &mut dyn Write,
    ) -> anyhow::Result<()> {
        anyhow::ensure!(query.message == "EstimatedState", "There is no message {:?}.", query.message);
        writeln!(out, "time,vessel,u [m/s]")?;
        for row in 0..100_000 {
            if self.fails_after == Some(row) {
                anyhow::bail!("the disk failed");
            }
            for vessel in [0x0814, 0x0815] {
                if may(vessel) && query.vessel.is_none_or(|wanted| wanted == vessel) {
                    writeln!(out, "{row},{vessel},1.5")?;
                }
            }
        }
        Ok(())
    }
}
