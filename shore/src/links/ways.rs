//! What a vessel with several ways says of them, as figures.

use super::vessel::Task;
use link::{WayState, WaysReport};

impl Task {
    /// Keeps what the vessel says of its ways, and tells a change of the one that carries live values.
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
            metrics::counter!("lutra_way_switches_total", "vessel" => vessel.clone())
                .increment(u64::from(before.is_some()));
        }
        for (place, way) in (0..).zip(&report.ways) {
            let labels = [("vessel", vessel.clone()), ("way", way.name.clone())];
            let gauge = |name: &'static str, value: f64| metrics::gauge!(name, &labels).set(value);
            let bit = |is: bool| f64::from(u8::from(is));
            gauge("lutra_way_up", bit(way.state == WayState::Up));
            gauge("lutra_way_live", bit(report.live == Some(place)));
            gauge("lutra_way_records", bit(report.records == Some(place)));
            gauge("lutra_way_round_trip_seconds", f64::from(way.round_trip_us) / 1e6);
            gauge("lutra_way_late_ratio", f64::from(way.late_per_mille) / 1e3);
            gauge("lutra_way_rate_bytes_per_second", f64::from(way.rate_bytes_per_s));
            gauge("lutra_way_today_bytes", way.today_bytes as f64);
            gauge("lutra_way_daily_budget_bytes", way.daily_bytes as f64);
        }
        self.ways.send_replace(Some(report));
    }
}
