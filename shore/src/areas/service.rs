//! Access rules of no-go areas, and their transfer into the sea chart.
//!
//! Every user who may see a vessel sees them. They apply to all vessels, so only operators of all vessels close, change and
//! lift them.

use super::rows::{CLOSED, Change, Closed, Create, Lifted, One, Row};
use crate::charts::{Charts, NoGo};
use crate::clock::Clock;
use crate::error::{Error, ErrorKind, Result};
use crate::identity::{People, Principal};
use crate::logbook::{NEWER, check_text};
use crate::once::{Key, Made, Once};
use api::{
    LogWord, NoGoArea, NoGoAreaChange, NoGoAreaQuery, NoGoAreaRequest, NoGoAreasRequest, Role, Said, say,
};
use planner::Zone;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Mutex;
use tokio_util::sync::CancellationToken;
use units::{LatLon, UtcTime};

/// Corners of an area.
const CORNERS: std::ops::RangeInclusive<usize> = 3..=200;
/// The longest border of an area (m): vessels hold all of them, in pieces.
const BORDER_M: f64 = 200e3;
/// Sides are cut into pieces of this length (m), so that they are where they were drawn: charts are straight in longitude and
/// latitude, maps in Mercator's projection.
const PIECE_M: f64 = 1_000.0;
/// Farther east or west is too near the date line (°).
const DATE_LINE_DEG: f64 = 179.999;
/// How often the closed areas are given to the chart.
const TELL_EVERY: Duration = Duration::from_secs(2);

/// The no-go areas; cheap to clone.
#[derive(Clone)]
pub struct NoGoAreas {
    people: People,
    clock: Clock,
    charts: Charts,
    /// Held from a change until the chart has it, so that the chart ends with the latest state.
    changing: Arc<Mutex<()>>,
}

impl NoGoAreas {
    pub(crate) fn new(people: People, clock: Clock, charts: Charts) -> Self {
        Self { people, clock, charts, changing: Arc::default() }
    }

    /// Gives the closed areas to the chart, which applies them at its next look.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub(crate) async fn tell(&self) -> Result<()> {
        let _changing = self.changing.lock().await;
        self.tell_now().await
    }

    /// The same, for a caller that holds the lock.
    async fn tell_now(&self) -> Result<()> {
        let rows = self.people.ask(Closed).await?;
        let changed_us = rows.iter().flat_map(|row| [Some(row.written_us), row.changed.1]).flatten().max();
        let at = UtcTime::from_micros(changed_us.unwrap_or_default());
        self.charts.close(NoGo { at, ..in_chart(&rows) });
        Ok(())
    }

    /// Repeats this periodically: app.db may have committed a change whose requester was gone.
    pub(crate) async fn keep(self, stop: CancellationToken) {
        let mut every = tokio::time::interval(TELL_EVERY);
        while stop.run_until_cancelled(every.tick()).await.is_some() {
            if let Err(error) = self.tell().await {
                tracing::warn!(%error, "the chart learns later which areas are closed");
            }
        }
    }

    /// The closed ones, and the lifted ones too where that is asked for.
    ///
    /// # Errors
    /// app.db cannot be read.
    pub async fn list(&self, who: &Principal, lifted: bool) -> Result<api::NoGoAreas> {
        let closed = self.people.ask(Closed).await?;
        let mut rows = closed.clone();
        rows.sort_by_cached_key(|row| (row.area.as_ref().map(|area| area.name.to_lowercase()), row.id));
        if lifted {
            rows.extend(self.people.ask(Lifted).await?);
        }
        // Compare with what is listed here, not with what the chart was given before.
        let trouble = self.charts.does_not_hold(Some(&in_chart(&closed)));
        Ok(api::NoGoAreas {
            areas: rows.into_iter().map(told).collect(),
            in_force: trouble.is_none(),
            trouble,
            may_change: may_change(who).is_ok(),
        })
    }

    /// Closes an area. If a person repeats a request with the same key, the first area is the answer.
    ///
    /// # Errors
    /// The person may not, or the named field is not valid.
    pub async fn create(
        &self,
        who: &Principal,
        from: String,
        ask: NoGoAreaRequest,
        query: NoGoAreaQuery,
    ) -> Result<NoGoArea> {
        may_change(who)?;
        let subject = ask.name.clone();
        let id = self.close_once(who, from, query, subject, vec![checked(ask)?]).await?;
        self.one(id).await
    }

    /// Closes several areas by one change of the chart, all or none; returns the closed areas.
    ///
    /// # Errors
    /// The person may not, or the named field of an area is not valid.
    pub async fn create_all(
        &self,
        who: &Principal,
        from: String,
        NoGoAreasRequest { areas }: NoGoAreasRequest,
        query: NoGoAreaQuery,
    ) -> Result<api::NoGoAreas> {
        may_change(who)?;
        let count = areas.len();
        if !(1..=CLOSED as usize).contains(&count) {
            let text = say("areas: there are {n}; give 1 to {most}");
            return Err(malformed(text.with("n", count).with("most", CLOSED)));
        }
        let numbered = |(at, area): (usize, NoGoAreaRequest)| {
            checked(area).map_err(|error| Error { text: error.text.numbered("area", at + 1), ..error })
        };
        let areas: Vec<_> = areas.into_iter().enumerate().map(numbered).collect::<Result<_>>()?;
        let first = areas.first().map(|area| area.name.clone()).unwrap_or_default();
        let subject = if count == 1 { first } else { format!("{count} areas, the first one {first}") };
        self.close_once(who, from, query, subject, areas).await?;
        self.list(who, false).await
    }

    /// Closes areas, unless this was done by the same key before; the number of the first.
    async fn close_once(
        &self,
        who: &Principal,
        from: String,
        NoGoAreaQuery { key }: NoGoAreaQuery,
        subject: String,
        areas: Vec<NoGoAreaRequest>,
    ) -> Result<i64> {
        let key = Key::new(Made::NoGoArea, who.person, key)?;
        let (service, who) = (self.clone(), who.clone());
        to_its_end(async move {
            let _changing = service.changing.lock().await;
            let known = match &key {
                Some(key) => service.people.ask(key.clone()).await?,
                None => None,
            };
            let first = match known {
                Some(first) => first,
                None => service.close(&who, from, subject, Once { key, make: areas }).await?,
            };
            service.bring_in().await?;
            Ok(first)
        })
        .await
    }

    async fn close(
        &self,
        who: &Principal,
        from: String,
        subject: String,
        Once { key, make: areas }: Once<Vec<NoGoAreaRequest>>,
    ) -> Result<i64> {
        if self.charts.set().is_none() {
            let text = say(
                "There is no sea chart that could hold it: import one by `lutra-server chart import` first.",
            );
            return Err(Error::refused(text));
        }
        let make = Create { areas, by: who.name.clone(), now: self.clock.utc() };
        Ok(self.people.act(who, from, "area.close", subject, Once { key, make }).await?)
    }

    /// Changes an area, lifts it, or closes it again; its earlier state is kept.
    ///
    /// # Errors
    /// The person may not, it was changed meanwhile, or the named field is not valid.
    pub async fn change(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: NoGoAreaChange,
    ) -> Result<NoGoArea> {
        may_change(who)?;
        let (areas, who) = (self.clone(), who.clone());
        to_its_end(async move { areas.change_to_its_end(&who, from, id, change).await }).await
    }

    async fn change_to_its_end(
        &self,
        who: &Principal,
        from: String,
        id: i64,
        change: NoGoAreaChange,
    ) -> Result<NoGoArea> {
        let _changing = self.changing.lock().await;
        let row = self.find(id).await?;
        if row.revision != change.revision {
            return Err(Error::new(ErrorKind::Newer, NEWER));
        }
        let closed = change.closed;
        // Even an area that is not valid can be lifted.
        let area = if closed { checked(change.area)? } else { row.area.unwrap_or(change.area) };
        let word = match (closed, row.lifted.1.is_some()) {
            (false, _) => "area.lift",
            (true, true) => "area.close",
            (true, false) => "area.change",
        };
        let subject = format!("{} (area {id})", area.name);
        let (by, now) = (who.name.clone(), self.clock.utc());
        let change = Change { id, revision: row.revision, area, closed, by, now };
        self.people.act(who, from, word, subject, change).await?;
        self.bring_in().await?;
        self.one(id).await
    }

    /// Applies the closed areas to the chart at once. If that fails, [`Self::list`] says why, and it is tried again.
    async fn bring_in(&self) -> Result<()> {
        self.tell_now().await?;
        let charts = self.charts.clone();
        tokio::task::spawn_blocking(move || charts.look()).await.map_err(|_| crate::router::Stopped)?;
        Ok(())
    }

    async fn one(&self, id: i64) -> Result<NoGoArea> {
        Ok(told(self.find(id).await?))
    }

    async fn find(&self, id: i64) -> Result<Row> {
        let none = || {
            let text = say("There is no such area; GET /api/v1/no-go-areas lists them.");
            Error::new(ErrorKind::NotFound, text)
        };
        self.people.ask(One(id)).await?.ok_or_else(none)
    }
}

/// Runs `work` to its end even if the requester is gone: a closed area must reach the chart.
async fn to_its_end<T: Send + 'static>(work: impl Future<Output = Result<T>> + Send + 'static) -> Result<T> {
    tokio::spawn(work).await.map_err(|_| crate::router::Stopped)?
}

fn may_change(who: &Principal) -> Result<()> {
    if who.grants.everywhere() >= Some(Role::Operator) {
        return Ok(());
    }
    let text = say("{name} may not close areas: that needs the role operator on all vessels. Ask an admin.")
        .with("name", &who.name);
    Err(Error::new(ErrorKind::Forbidden, text))
}

fn told(row: Row) -> NoGoArea {
    let word = |(by, at): (Option<String>, Option<i64>)| Some(LogWord { by: by?, time_us: at? });
    let unreadable =
        || NoGoAreaRequest { name: "This area cannot be read".to_owned(), ..NoGoAreaRequest::default() };
    NoGoArea {
        id: row.id,
        revision: row.revision,
        area: row.area.unwrap_or_else(unreadable),
        written: LogWord { by: row.by, time_us: row.written_us },
        changed: word(row.changed),
        lifted: word(row.lifted),
    }
}

/// Validates an area.
fn checked(ask: NoGoAreaRequest) -> Result<NoGoAreaRequest> {
    let name = check_text("name", &ask.name, 1..=80)?;
    if name.contains(['\n', '\t']) {
        return Err(malformed(say("name: has several lines: write one")));
    }
    let reason = check_text("reason", &ask.reason, 0..=500)?;
    let mut corners = ask.corners;
    corners.dedup();
    if corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    if !CORNERS.contains(&corners.len()) {
        let (least, most) = CORNERS.into_inner();
        return Err(malformed(
            say("corners: there are {n}; give {least} to {most}")
                .with("n", corners.len())
                .with("least", least)
                .with("most", most),
        ));
    }
    let places = places(&corners)?;
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let over = |([_, from_deg], [_, to_deg]): (&[f64; 2], &[f64; 2])| (from_deg - to_deg).abs() > 180.0;
    if corners.iter().any(|[_, lon_deg]| lon_deg.abs() > DATE_LINE_DEG) || sides.into_iter().any(over) {
        return Err(malformed(say("corners: the area reaches the date line: close one on each side of it")));
    }
    let border_m = Zone::new(places.clone()).map_or(0.0, |zone| zone.border_m());
    if border_m > BORDER_M {
        let (km, most_km) = (border_m / 1e3, BORDER_M / 1e3);
        return Err(malformed(
            say("corners: the border is {km} km long; at most {most_km} km are taken")
                .with("km", format!("{km:.0}"))
                .with("most_km", format!("{most_km:.0}")),
        ));
    }
    Zone::drawn(places).map_err(|error| malformed(say("corners: {error}").with("error", error)))?;
    Ok(NoGoAreaRequest { name, reason, corners })
}

fn places(corners: &[[f64; 2]]) -> Result<Vec<LatLon>> {
    let place = |[lat, lon]: &[f64; 2]| {
        LatLon::from_deg(*lat, *lon).map_err(|error| {
            let text = say("corners: {lat}, {lon} is not a place: {error}");
            malformed(text.with("lat", lat).with("lon", lon).with("error", error))
        })
    };
    corners.iter().map(place).collect()
}

/// Converts areas for the chart, and tells whether one cannot be read: no program writes such a row, but its position is
/// then not known.
fn in_chart(rows: &[Row]) -> NoGo {
    let mut all = NoGo::default();
    for row in rows {
        if let Some(area) = row.area.as_ref().and_then(|area| area_in_chart(row.id, area)) {
            all.areas.push(area);
        } else {
            let id = row.id;
            all.lost = Some(format!(
                "area {id} cannot be read from app.db: lift it, and close it again where it lies"
            ));
        }
    }
    all
}

fn area_in_chart(id: i64, area: &NoGoAreaRequest) -> Option<chartdb::NoGoArea> {
    let corners = places(&area.corners).ok()?;
    let ends = corners.iter().cycle().skip(1);
    let corners = corners.iter().zip(ends).flat_map(|(from, to)| side(*from, *to)).collect();
    Some(chartdb::NoGoArea { number: u32::try_from(id).ok()?, name: area.name.clone(), corners })
}

/// A side without its end, straight on a Mercator map, in pieces.
fn side(from: LatLon, to: LatLon) -> Vec<LatLon> {
    let northing = |lat_rad: f64| lat_rad.tan().asinh();
    let (from_y, to_y) = (northing(from.lat_rad()), northing(to.lat_rad()));
    let east_rad = units::wrap_pi(to.lon_rad() - from.lon_rad());
    let length_m =
        Zone::new(vec![from, to, from]).map_or(0.0, |there_and_back| there_and_back.border_m() / 2.0);
    // At most 201 of an area whose border is as long as may be.
    let pieces = (length_m / PIECE_M).ceil().clamp(1.0, BORDER_M / PIECE_M) as u32;
    let at = |piece: u32| {
        let share = f64::from(piece) / f64::from(pieces);
        let lat_rad = (from_y + share * (to_y - from_y)).sinh().atan();
        let lon_rad = units::wrap_pi(from.lon_rad() + share * east_rad);
        LatLon::from_rad(lat_rad, lon_rad)
    };
    (0..pieces).filter_map(|piece| if piece == 0 { Some(from) } else { at(piece).ok() }).collect()
}

fn malformed(text: impl Into<Said>) -> Error {
    Error::new(ErrorKind::Malformed, text)
}
