//! Connected peers, and the state of links and recording.

use crate::AppState;
use crate::web::{ApiError, Who};
use api::{LinkStatus, LinkWay, LinkWays, Recording, TransportPeer, VesselChart};
use axum::Json;
use axum::extract::State;
use imc::Address;
use link::{ShoreStatus, WayReport, WaysReport};
use shore::identity::Grants;
use shore::recorder::{RecorderState, WAITING_BYTES};
use shore::router::PeerFigures;

/// `GET /api/v1/connections`.
pub(crate) async fn transports(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<TransportPeer>>, ApiError> {
    let peers = state.shore.router.peers().await.map_err(|_| ApiError::stopping())?;
    Ok(Json(peers.into_iter().filter_map(|peer| describe(peer, &who.grants)).collect()))
}

/// A peer, if the user may see it: with a role on all vessels every peer, else those that send for vessels that the user
/// may see.
fn describe(figures: PeerFigures, grants: &Grants) -> Option<TransportPeer> {
    let PeerFigures { state, dropped } = figures;
    let systems: Vec<u16> =
        state.systems.iter().map(|system| system.0).filter(|system| grants.on(*system).is_some()).collect();
    let seen = grants.everywhere().is_some() || !systems.is_empty();
    seen.then(|| TransportPeer {
        id: state.id.0,
        transport: state.peer.transport.name().to_owned(),
        name: state.peer.name,
        since_us: state.since.micros(),
        systems,
        received: state.received,
        refused: state.refused,
        delivered: state.delivered,
        dropped,
    })
}

/// `GET /api/v1/links`.
pub(crate) async fn links(State(state): State<AppState>, Who(who): Who) -> Json<Vec<LinkStatus>> {
    let seen = state.shore.links.status().into_iter().filter(|(vessel, _)| who.grants.on(vessel.0).is_some());
    let links = &state.shore.links;
    let told = seen.map(|(vessel, status)| LinkStatus {
        ways: links.ways(vessel).map(|report| ways(status.up, report)),
        ..link_status(vessel, status, links.chart(vessel))
    });
    Json(told.collect())
}

fn link_status(vessel: Address, status: ShoreStatus, chart: VesselChart) -> LinkStatus {
    LinkStatus {
        vessel: vessel.0,
        up: status.up,
        backlog_records: status.backlog.records,
        backlog_age_s: status.backlog.waiting.as_secs_f64(),
        keeping_s: status.backlog.keeping.as_secs_f64(),
        round_trip_s: status.round_trip.map(|time| time.as_secs_f64()),
        clock_ahead_s: status.clocks.map(|clocks| clocks.utc_ahead_us as f64 / 1e6),
        clock_uncertainty_s: status.clocks.map(|clocks| clocks.uncertainty_us as f64 / 1e6),
        transit_s: status.transit.mean().map(|time| time.as_secs_f64()),
        received_bytes: status.received_bytes,
        repeated: status.repeated,
        connections: status.connections,
        chart,
        ways: None,
    }
}

/// A vessel's report about its ways; while the link is down, all of them count as down.
fn ways(up: bool, report: WaysReport) -> LinkWays {
    let way = |way: WayReport| LinkWay {
        name: way.name,
        metered: way.metered,
        state: if up { way.state } else { link::WayState::Down }.name().to_owned(),
        round_trip_ms: (way.round_trip_us > 0).then_some(way.round_trip_us / 1000),
        late_per_mille: way.late_per_mille,
        rate_bytes_per_s: Some(way.rate_bytes_per_s).filter(|rate| *rate > 0),
        today_bytes: way.today_bytes,
        daily_bytes: Some(way.daily_bytes).filter(|bytes| *bytes > 0),
        thinning: way.thinning.name().to_owned(),
        failures: way.failures,
    };
    LinkWays {
        live: report.live.filter(|_| up),
        live_why: report.live_why.name().to_owned(),
        records: report.records.filter(|_| up),
        records_why: report.records_why.name().to_owned(),
        ways: report.ways.into_iter().map(way).collect(),
    }
}

/// `GET /api/v1/recording`.
pub(crate) async fn recording(State(state): State<AppState>) -> Json<Recording> {
    let RecorderState { trouble, history_behind, recorded, not_recorded } =
        state.shore.recorder.state().borrow().clone();
    Json(Recording {
        trouble: trouble.map(|trouble| trouble.text),
        history_behind,
        recorded,
        not_recorded,
        waiting_bytes: state.shore.recorder.waiting_bytes() as u64,
        waiting_bytes_most: WAITING_BYTES as u64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use link::{ClockEstimate, PeerBacklog};
    use std::time::Duration;

    #[test]
    fn a_links_times_are_seconds_and_what_is_unknown_is_null() {
        let clocks = ClockEstimate {
            utc_ahead_us: -1_500_000,
            uncertainty_us: 250,
            round_trip: Duration::from_micros(500),
        };
        let backlog = PeerBacklog {
            records: 7,
            waiting: Duration::from_millis(2_500),
            keeping: Duration::from_millis(40),
        };
        let known = ShoreStatus {
            up: true,
            clocks: Some(clocks),
            round_trip: Some(Duration::from_millis(3)),
            backlog,
            ..ShoreStatus::default()
        };
        let status = link_status(Address(7), known, VesselChart::default());
        assert_eq!((status.vessel, status.up, status.backlog_records), (7, true, 7));
        assert_eq!((status.clock_ahead_s, status.clock_uncertainty_s), (Some(-1.5), Some(0.000_25)));
        assert_eq!((status.round_trip_s, status.backlog_age_s, status.keeping_s), (Some(0.003), 2.5, 0.04));
        let status = link_status(Address(7), ShoreStatus::default(), VesselChart::default());
        assert_eq!(
            (status.up, status.round_trip_s, status.clock_ahead_s, status.transit_s),
            (false, None, None, None)
        );
    }
}
