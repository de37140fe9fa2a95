//! Routes of one vessel: its history, orders and reports.

use crate::http::{control, history, teleop};
use crate::web::{Need, Route};
use api::{
    At, AtQuery, Buckets, BucketsQuery, Command, Detections, DetectionsQuery, Entity, EventsQuery, Gap,
    GapsQuery, Lease, LeaseRequest, LogBook, OrderRequest, Ordered, PlanUnderWay, PlansAboard, Role, Samples,
    SamplesQuery, StopQuery, TeleopMessage, TeleopStatus, TrackPoint, TrackQuery, VesselParameters,
    VesselQuery, VesselQuerySent,
};

/// The history of one vessel.
pub(super) fn of_vessels() -> Vec<Route> {
    let viewer = Need::OnVessel(Role::Viewer);
    vec![
        Route::get("/api/v1/vessels/{vessel}/track", viewer, "A vessel's track.", history::track)
            .query::<TrackQuery>()
            .gives::<Vec<TrackPoint>>()
            .packed(),
        Route::get(
            "/api/v1/vessels/{vessel}/track.gpx",
            viewer,
            "A vessel's track as GPX, for chart plotters; parts between breaks of 5 min, or three steps of a thinned track, are segments.",
            history::track_gpx,
        )
        .query::<TrackQuery>()
        .media("application/gpx+xml"),
        Route::get(
            "/api/v1/vessels/{vessel}/track.nc",
            viewer,
            "A vessel's track as NetCDF: a trajectory by CF-1.10, with the attributes of ACDD-1.3.",
            history::track_netcdf,
        )
        .query::<TrackQuery>()
        .media("application/x-netcdf"),
        Route::get(
            "/api/v1/vessels/{vessel}/buckets",
            viewer,
            "Least, greatest and mean values of a field, for plots of any range.",
            history::buckets,
        )
        .query::<BucketsQuery>()
        .gives::<Buckets>()
        .packed(),
        Route::get("/api/v1/vessels/{vessel}/samples", viewer, "Samples as they are.", history::samples)
            .query::<SamplesQuery>()
            .gives::<Samples>()
            .packed(),
        Route::get(
            "/api/v1/vessels/{vessel}/at",
            viewer,
            "How a vessel was: the last value of every series at or before a time.",
            history::at,
        )
        .query::<AtQuery>()
        .gives::<At>()
        .packed(),
        Route::get("/api/v1/vessels/{vessel}/entities", viewer, "Labels of entities.", history::entities)
            .gives::<Vec<Entity>>(),
        Route::get("/api/v1/vessels/{vessel}/detections", viewer, "Tags heard.", history::detections)
            .query::<DetectionsQuery>()
            .gives::<Detections>()
            .packed(),
        Route::get("/api/v1/vessels/{vessel}/logbook", viewer, "The log book.", history::log_book)
            .query::<EventsQuery>()
            .gives::<LogBook>()
            .packed(),
        Route::get(
            "/api/v1/vessels/{vessel}/gaps",
            viewer,
            "What is declared missing, and when nothing was heard.",
            history::gaps,
        )
        .query::<GapsQuery>()
        .gives::<Vec<Gap>>(),
    ]
}

/// Orders to a vessel.
pub(super) fn orders() -> Vec<Route> {
    let viewer = Need::OnVessel(Role::Viewer);
    vec![
        Route::post(
            "/api/v1/vessels/{vessel}/abort",
            Need::OnVessel(Role::Operator),
            "Stop: what the vessel does ends and its motors stand still. Never asks back.",
            control::abort,
        )
        .reaches_unknown()
        .query::<StopQuery>()
        .gives::<Ordered>(),
        Route::get("/api/v1/vessels/{vessel}/lease", viewer, "Who has control of a vessel.", control::lease)
            .gives::<Lease>(),
        Route::post(
            "/api/v1/vessels/{vessel}/lease",
            Need::OnVessel(Role::Operator),
            "Ask for control of a vessel, give it, keep it or take it.",
            control::ask_lease,
        )
        .takes::<LeaseRequest>()
        .gives::<Lease>(),
        Route::get(
            "/api/v1/vessels/{vessel}/commands",
            viewer,
            "What a vessel was ordered, the newest first, and what became of it.",
            control::commands,
        )
        .gives::<Vec<Command>>(),
        Route::get(
            "/api/v1/vessels/{vessel}/commands/{id}",
            viewer,
            "One order and its answer.",
            control::one,
        )
        .gives::<Command>(),
        Route::post(
            "/api/v1/vessels/{vessel}/commands",
            Need::OnVessel(Role::Operator),
            "Order a vessel to do something, with control of it. The answer is 202: its stages come later.",
            control::order,
        )
        .takes::<OrderRequest>()
        .gives::<Command>(),
        Route::socket(
            "/api/v1/vessels/{vessel}/teleop",
            Need::OnVessel(Role::Operator),
            "Steer a vessel by hand, with control of it: a WebSocket.",
            teleop::socket,
        )
        .takes::<TeleopMessage>()
        .gives::<TeleopStatus>(),
        Route::get(
            "/api/v1/vessels/{vessel}/plans",
            viewer,
            "The plans that a vessel stores, as it said last; plan.list asks it.",
            control::plans,
        )
        .gives::<PlansAboard>(),
    ]
}

/// Reports of vessels on request.
pub(super) fn told_by_vessels() -> Vec<Route> {
    let viewer = Need::OnVessel(Role::Viewer);
    vec![
        Route::post(
            "/api/v1/vessels/{vessel}/ask",
            viewer,
            "Ask a vessel for its parameters or plans. Commands nothing; the answer comes by itself, or never.",
            control::ask,
        )
        .takes::<VesselQuery>()
        .gives::<VesselQuerySent>(),
        Route::get(
            "/api/v1/vessels/{vessel}/parameters",
            viewer,
            "The parameters of a vessel, as it reported them last, with what those of Lutra mean.",
            control::parameters,
        )
        .gives::<VesselParameters>(),
        Route::get(
            "/api/v1/vessels/{vessel}/plan",
            viewer,
            "The plan that a vessel sails, as far as it is known ashore.",
            control::plan,
        )
        .gives::<PlanUnderWay>(),
    ]
}
