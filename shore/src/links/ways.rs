//! Reports of a vessel about its ways (network paths), as figures.

use super::vessel::Task;
use link::{WayReport, WayState, WaysReport};

impl Task {
    /// Stores the vessel's report, and logs a change of the way that carries live values.
    pub(super) fn ways_told(&mut self, report: WaysReport) {
        let vessel = self.vessel.to_string();
        let name = |place: Option<u8>| {
            let way = place.and_then(|place| report.ways.get(usize::from(place)));
            way.map_or("none", |way| way.name.as_str())
        };
        let before = self.ways.borrow().as_ref().map(|before| (before.live, before.records));
        if before != Some((report.live, report.records)) {
            let (live, records) = (name(report.live), name(report.records));
            let (live_why, records_why) = (report.live_why.name(), report.records_why.name());
            tracing::info!(%vessel, live, live_why, records, records_why, "the vessel's ways");
            // After a time without any link it is not a switch.
            let switched = before.is_some_and(|(live, _)| live.is_some());
            metrics::counter!("lutra_way_switches_total", "vessel" => vessel.clone())
                .increment(u64::from(switched));
        }
        self.figures_of(&report);
        self.ways.send_replace(Some(report));
    }

    /// The link is down, and with it each way. Their last figures of traffic and cost stay visible.
    pub(super) fn ways_down(&mut self) {
        self.ways.send_if_modified(|ways| {
            let Some(report) = ways else { return false };
            (report.live, report.records) = (None, None);
            report.ways.iter_mut().for_each(|way| way.state = WayState::Down);
            true
        });
        let report = self.ways.borrow().clone();
        self.figures_of(&report.unwrap_or_default());
    }

    /// The vessel has connected by a single way, which it does not report on.
    pub(super) fn one_way(&mut self) {
        self.ways.send_replace(None);
        self.figures_of(&WaysReport::default());
    }

    /// The figures of a report. Ways that are not in it count as down.
    fn figures_of(&mut self, report: &WaysReport) {
        let vessel = self.vessel.to_string();
        for (place, way) in (0..).zip(&report.ways) {
            if self.named.has(&vessel, &way.name) {
                let is = |lane: Option<u8>| lane == Some(place);
                figures(&vessel, way, (is(report.live), is(report.records)));
            }
        }
        for name in self.named.names() {
            if report.ways.iter().all(|way| way.name != *name) {
                let gone = WayReport { name: name.clone(), ..WayReport::default() };
                figures(&vessel, &gone, (false, false));
            }
        }
    }
}

fn figures(vessel: &str, way: &WayReport, (live, records): (bool, bool)) {
    let labels = [("vessel", vessel.to_owned()), ("way", way.name.clone())];
    let gauge = |name: &'static str, value: f64| metrics::gauge!(name, &labels).set(value);
    let bit = |is: bool| f64::from(u8::from(is));
    gauge("lutra_way_up", bit(way.state == WayState::Up));
    gauge("lutra_way_live", bit(live));
    gauge("lutra_way_records", bit(records));
    gauge("lutra_way_round_trip_seconds", f64::from(way.round_trip_us) / 1e6);
    gauge("lutra_way_late_ratio", f64::from(way.late_per_mille) / 1e3);
    gauge("lutra_way_rate_bytes_per_second", f64::from(way.rate_bytes_per_s));
    gauge("lutra_way_today_bytes", way.today_bytes as f64);
    gauge("lutra_way_daily_budget_bytes", way.daily_bytes as f64);
}
