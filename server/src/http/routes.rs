//! The routes of the API and what belongs to it.

use super::{
    alarms, areas, charts, control, export, health, history, imports, live, logbook, missions, openapi,
    people, plans, register, teleop, transports,
};
use crate::web::{Need, Route, assets};
use api::{
    Alarm, AlarmHistory, AlarmHistoryQuery, AlarmList, At, AtQuery, AuditEntry, Buckets, BucketsQuery,
    ChartAtQuery, ChartCorridor, ChartCorridorRequest, ChartNear, ChartSet, ChartTileQuery, Command,
    Detections, DetectionsFileQuery, DetectionsQuery, Entity, EventsQuery, ExportQuery, ExportSize,
    FleetDetectionsQuery, Gap, GapsQuery, Import, ImportQuery, ImportedPlan, Lease, LeaseRequest, LinkStatus,
    LiveFrame, LiveRequest, LogBook, LogNote, LogNoteChange, LogNoteQuery, LogNoteRequest, LogNoteRevision,
    LogNotes, LogNotesFileQuery, LogNotesQuery, LogQuery, Me, Mission, MissionChange, MissionQuery,
    MissionRequest, MissionSummary, Missions, MissionsQuery, NewToken, NoGoArea, NoGoAreaChange,
    NoGoAreaQuery, NoGoAreaRequest, NoGoAreas, NoGoAreasQuery, NoGoAreasRequest, OrderRequest, Ordered,
    Person, PlanChange, PlanCheck, PlanDocument, PlanExportQuery, PlanImportQuery, PlanQuery, PlanRevision,
    PlanSummary, PlanUnderWay, PlanUploadRequest, PlansAboard, Recorded, RecordedDay, Recording,
    RegisterAnswer, RegisterChange, RegisterDeleteQuery, RegisterEntry, RegisterImport, RegisterImportQuery,
    RegisterQuery, RegisterRecord, Role, Samples, SamplesQuery, SeaRouteAnswer, SeaRouteRequest, Series,
    SeriesQuery, Session, ShelveRequest, StopQuery, StoredPlan, System, TeleopMessage, TeleopStatus, Token,
    TokenMade, TrackPoint, TrackQuery, TransportPeer, VesselParameters, VesselQuery, VesselQuerySent,
};
use axum::Json;
use shore::logbook::PHOTO_BYTES;
use shore::register::FILE_BYTES;
use utoipa::openapi::OpenApi;

/// Bytes of a plan, and of a file that holds one.
const PLAN_BYTES: usize = 4 << 20;

/// All routes for programs, and what pages are made of.
pub(crate) fn table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let admin = Need::Everywhere(Role::Admin);
    let mut table = vec![
        Route::get(
            "/healthz",
            Need::Anyone,
            "Whether the server does its work: 503 while nothing can be recorded.",
            health::healthz,
        ),
        Route::get(
            "/readyz",
            Need::Anyone,
            "Whether the server takes requests: 503 while it ends.",
            health::readyz,
        ),
        Route::get("/metrics", Need::Figures, "Figures for Prometheus.", health::metrics).media("text/plain"),
        Route::get("/static/{name}", Need::Anyone, "Scripts and styles.", assets::serve),
        Route::get(
            "/worker.js",
            Need::Anyone,
            "What answers while the server is not reached.",
            assets::worker,
        ),
        Route::get("/manifest.webmanifest", Need::Anyone, "To install the pages.", assets::web_manifest),
        Route::get("/favicon.ico", Need::Anyone, "The picture in the tab.", assets::favicon),
        Route::get("/api/v1/openapi.json", viewer, "This document.", document).packed(),
        Route::get("/api/v1/me", viewer, "Who asks.", people::me).gives::<Me>(),
        Route::get("/api/v1/people", admin, "Accounts.", people::list).gives::<Vec<Person>>(),
        Route::get("/api/v1/tokens", viewer, "One's own tokens; for an admin all.", people::token_list)
            .gives::<Vec<Token>>(),
        Route::post("/api/v1/tokens", viewer, "Make a token. Only for browsers.", people::token_make)
            .takes::<NewToken>()
            .gives::<TokenMade>(),
        Route::delete("/api/v1/tokens/{id}", viewer, "Revoke a token.", people::token_revoke),
        Route::get("/api/v1/sessions", viewer, "One's own sessions; for an admin all.", people::session_list)
            .gives::<Vec<Session>>(),
        Route::delete("/api/v1/sessions/{id}", viewer, "End a session.", people::session_end),
        Route::get("/api/v1/audit", admin, "Who did what, the newest first.", people::audit_list)
            .query::<people::AuditQuery>()
            .gives::<Vec<AuditEntry>>(),
        Route::get("/api/v1/vessels", viewer, "The fleet as it is.", history::vessels).gives::<Vec<System>>(),
        Route::socket("/api/live", viewer, "The fleet as it changes: a WebSocket.", live::socket)
            .takes::<LiveRequest>()
            .gives::<LiveFrame>(),
        Route::get("/api/v1/recorded", viewer, "What the history holds.", history::recorded)
            .gives::<Vec<Recorded>>(),
        Route::get(
            "/api/v1/recorded/days",
            viewer,
            "What came ashore on which day, the newest first.",
            history::recorded_days,
        )
        .gives::<Vec<RecordedDay>>(),
        Route::get("/api/v1/series", viewer, "Series of samples, with fields and units.", history::series)
            .query::<SeriesQuery>()
            .gives::<Vec<Series>>()
            .packed(),
        Route::get("/api/v1/detections", viewer, "Tags heard by all vessels.", history::fleet_detections)
            .query::<FleetDetectionsQuery>()
            .gives::<Detections>()
            .packed(),
        Route::get(
            "/api/v1/connections",
            viewer,
            "Who is connected by which transport.",
            transports::transports,
        )
        .gives::<Vec<TransportPeer>>(),
        Route::get("/api/v1/links", viewer, "How the vessels' links are.", transports::links)
            .gives::<Vec<LinkStatus>>(),
        Route::get("/api/v1/recording", viewer, "How recording goes.", transports::recording)
            .gives::<Recording>(),
    ];
    table.extend(of_vessels());
    table.extend(orders());
    table.extend(told_by_vessels());
    table.extend(alarms_table());
    table.extend(log_book());
    table.extend(missions_table());
    table.extend(register_table());
    table.extend(no_go_areas());
    table.extend(transfers());
    table.extend(plans());
    table.extend(chart());
    table
}

/// `GET /api/v1/openapi.json`.
async fn document() -> Json<OpenApi> {
    Json(openapi::describe(&table()))
}

/// The history of one vessel.
fn of_vessels() -> Vec<Route> {
    let viewer = Need::OnVessel(Role::Viewer);
    vec![
        Route::get("/api/v1/vessels/{vessel}/track", viewer, "A vessel's track.", history::track)
            .query::<TrackQuery>()
            .gives::<Vec<TrackPoint>>()
            .packed(),
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

/// What people order a vessel to do.
fn orders() -> Vec<Route> {
    let viewer = Need::OnVessel(Role::Viewer);
    vec![
        Route::post(
            "/api/v1/vessels/{vessel}/abort",
            Need::OnVessel(Role::Operator),
            "Stop: what the vessel does ends and its motors stand still. Never asks back.",
            control::abort,
        )
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

/// What vessels tell of themselves when they are asked.
fn told_by_vessels() -> Vec<Route> {
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
            "The parameters of a vessel, as it told them last, with what those of Lutra mean.",
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

/// What is wrong. Who may acknowledge which is decided by the alarm's vessel.
fn alarms_table() -> Vec<Route> {
    let operator = Need::Somewhere(Role::Operator);
    vec![
        Route::get(
            "/api/v1/alarms",
            Need::Somewhere(Role::Viewer),
            "What is wrong, and what happened to alarms lately.",
            alarms::list,
        )
        .gives::<AlarmList>(),
        Route::get(
            "/api/v1/alarms/history",
            Need::Somewhere(Role::Viewer),
            "What happened to alarms, the newest first.",
            alarms::history,
        )
        .query::<AlarmHistoryQuery>()
        .gives::<AlarmHistory>(),
        Route::post(
            "/api/v1/alarms/{id}/acknowledge",
            operator,
            "Say that you know of an alarm.",
            alarms::acknowledge,
        )
        .gives::<Alarm>(),
        Route::post(
            "/api/v1/alarms/{id}/shelve",
            operator,
            "Put an alarm aside for a time. Not an emergency.",
            alarms::shelve,
        )
        .takes::<ShelveRequest>()
        .gives::<Alarm>(),
    ]
}

/// The log book that people keep. Who may see and change which note is decided by its vessel and author.
fn log_book() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let operator = Need::Somewhere(Role::Operator);
    vec![
        Route::get("/api/v1/logbook", viewer, "Notes of the log book, the newest first.", logbook::list)
            .query::<LogNotesQuery>()
            .gives::<LogNotes>(),
        Route::get(
            "/api/v1/logbook.csv",
            Need::Somewhere(Role::Researcher),
            "CSV of the log book, the newest first. An answer that ends without an error is whole.",
            logbook::csv,
        )
        .query::<LogNotesFileQuery>()
        .media("text/csv"),
        Route::post("/api/v1/logbook", operator, "Write a note into the log book.", logbook::write)
            .query::<LogNoteQuery>()
            .takes::<LogNoteRequest>()
            .gives::<LogNote>(),
        Route::patch(
            "/api/v1/logbook/{id}",
            operator,
            "Correct a note, as its author or an admin; what it said is kept. 409 when it was changed meanwhile.",
            logbook::correct,
        )
        .takes::<LogNoteChange>()
        .gives::<LogNote>(),
        Route::delete(
            "/api/v1/logbook/{id}",
            operator,
            "Withdraw a note, as its author or an admin. It is kept, and marked.",
            logbook::withdraw,
        )
        .gives::<LogNote>(),
        Route::get(
            "/api/v1/logbook/{id}/earlier",
            viewer,
            "What a note said before it was corrected, the newest first.",
            logbook::earlier,
        )
        .gives::<Vec<LogNoteRevision>>(),
        Route::get("/api/v1/logbook/{id}/photo", viewer, "The photo of a note.", logbook::photo)
            .media("image/*"),
        Route::put(
            "/api/v1/logbook/{id}/photo",
            operator,
            "Give a note its photo: JPEG, PNG or WebP of at most 4 MiB. The body is the file.",
            logbook::add_photo,
        )
        .takes_file()
        .gives::<LogNote>()
        .body_bytes(PHOTO_BYTES),
    ]
}

/// Missions that people record. Who may see and change which is decided by its vessels.
fn missions_table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let operator = Need::Somewhere(Role::Operator);
    vec![
        Route::get("/api/v1/missions", viewer, "Missions, those that began last first.", missions::list)
            .query::<MissionsQuery>()
            .gives::<Missions>(),
        Route::post("/api/v1/missions", operator, "Write a mission down.", missions::create)
            .query::<MissionQuery>()
            .takes::<MissionRequest>()
            .gives::<Mission>(),
        Route::get("/api/v1/missions/{id}", viewer, "A mission.", missions::one).gives::<Mission>(),
        Route::patch(
            "/api/v1/missions/{id}",
            operator,
            "Change a mission; what it said is kept. 409 when it was changed meanwhile.",
            missions::change,
        )
        .takes::<MissionChange>()
        .gives::<Mission>(),
        Route::delete(
            "/api/v1/missions/{id}",
            operator,
            "Withdraw a mission. It is kept, and marked.",
            missions::withdraw,
        )
        .gives::<Mission>(),
        Route::get(
            "/api/v1/missions/{id}/summary",
            viewer,
            "A mission's summary, vessel by vessel: distance, hours, battery and tags.",
            missions::summary,
        )
        .gives::<MissionSummary>(),
    ]
}

/// What people close to all vessels.
fn no_go_areas() -> Vec<Route> {
    let (viewer, operator) = (Need::Somewhere(Role::Viewer), Need::Everywhere(Role::Operator));
    vec![
        Route::get("/api/v1/no-go-areas", viewer, "Areas that are closed to all vessels.", areas::list)
            .query::<NoGoAreasQuery>()
            .gives::<NoGoAreas>(),
        Route::post(
            "/api/v1/no-go-areas",
            operator,
            "Close an area: plans, routes and vessels keep out of it.",
            areas::create,
        )
        .query::<NoGoAreaQuery>()
        .takes::<NoGoAreaRequest>()
        .gives::<NoGoArea>(),
        Route::post(
            "/api/v1/no-go-areas/batch",
            operator,
            "Close several areas, all or none, by one change of the chart.",
            areas::create_all,
        )
        .query::<NoGoAreaQuery>()
        .takes::<NoGoAreasRequest>()
        .gives::<NoGoAreas>(),
        Route::patch(
            "/api/v1/no-go-areas/{id}",
            operator,
            "Change an area, lift it, or close it again; what it was is kept. 409 when it was changed meanwhile.",
            areas::change,
        )
        .takes::<NoGoAreaChange>()
        .gives::<NoGoArea>(),
    ]
}

/// The register of studies. Who may change which entry is decided by its kind and vessel.
fn register_table() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let researcher = Need::Somewhere(Role::Researcher);
    vec![
        Route::get(
            "/api/v1/register",
            viewer,
            "The register: projects, people, animals, tags, receivers and their deployments, by kind and name.",
            register::list,
        )
        .query::<RegisterQuery>()
        .gives::<RegisterAnswer>()
        .packed(),
        Route::post("/api/v1/register", researcher, "Register something.", register::create)
            .takes::<RegisterRecord>()
            .gives::<RegisterEntry>(),
        Route::put(
            "/api/v1/register/{id}",
            researcher,
            "Change an entry; what it said is kept. 409 when it was changed meanwhile.",
            register::change,
        )
        .takes::<RegisterChange>()
        .gives::<RegisterEntry>(),
        Route::delete(
            "/api/v1/register/{id}",
            researcher,
            "Delete an entry that no other names; what it said is kept.",
            register::delete,
        )
        .query::<RegisterDeleteQuery>(),
        Route::get(
            "/api/v1/register.csv",
            viewer,
            "A table of the register, of one kind; without entries it is the template of a file to import.",
            register::csv,
        )
        .query::<RegisterQuery>()
        .media("text/csv")
        .packed(),
        Route::post(
            "/api/v1/register/import",
            researcher,
            "What a table would change in the register, with all of its problems; with `apply` it is taken, whole or not at \
             all. The body is the file.",
            register::import,
        )
        .query::<RegisterImportQuery>()
        .takes_file()
        .gives::<RegisterImport>()
        .body_bytes(FILE_BYTES),
    ]
}

/// The ways out and in.
fn transfers() -> Vec<Route> {
    let researcher = Need::Somewhere(Role::Researcher);
    let operator = Need::Everywhere(Role::Operator);
    vec![
        Route::get(
            "/api/v1/export.csv",
            researcher,
            "CSV of messages. An answer that ends without an error is whole.",
            export::csv,
        )
        .query::<ExportQuery>()
        .media("text/csv")
        .packed(),
        Route::get(
            "/api/v1/detections.csv",
            researcher,
            "Detections as a file, in the format of a portal if that is asked for, the oldest report first. An answer that ends \
             without an error is whole.",
            export::detections,
        )
        .query::<DetectionsFileQuery>()
        .media("text/csv")
        .packed(),
        Route::get("/api/v1/export.json", researcher, "What stands in its columns.", export::description)
            .query::<ExportQuery>(),
        Route::get("/api/v1/export/size", researcher, "How large the CSV will be.", export::size)
            .query::<ExportQuery>()
            .gives::<ExportSize>(),
        Route::get("/api/v1/export.lsf", researcher, "Packets as a log, as they came.", export::lsf)
            .query::<LogQuery>()
            .media("application/octet-stream"),
        Route::post("/api/v1/import", operator, "Import a log: the body is the file.", imports::upload)
            .query::<ImportQuery>()
            .takes_file()
            .paces()
            .gives::<Import>(),
        Route::get("/api/v1/import", operator, "Logs uploaded, the newest first.", imports::list)
            .gives::<Vec<Import>>(),
        Route::get("/api/v1/import/{id}", operator, "How far an import is.", imports::one).gives::<Import>(),
        Route::post(
            "/api/v1/import/{id}/cancel",
            operator,
            "End an import; what was read stays.",
            imports::cancel,
        )
        .gives::<Import>(),
    ]
}

/// Plans ashore. Who may see and change which is decided by the plan's vessel.
fn plans() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    let operator = Need::Somewhere(Role::Operator);
    vec![
        Route::get("/api/v1/plans", viewer, "Plans, by name.", plans::list).gives::<Vec<PlanSummary>>(),
        Route::post(
            "/api/v1/plans",
            operator,
            "Keep a new plan, as a draft. It gets another name if its own is taken.",
            plans::create,
        )
        .takes::<PlanDocument>()
        .gives::<StoredPlan>()
        .body_bytes(PLAN_BYTES),
        Route::post(
            "/api/v1/plans/check",
            viewer,
            "What a plan would take and what is wrong with it; nothing is kept.",
            plans::check,
        )
        .takes::<PlanDocument>()
        .gives::<PlanCheck>()
        .body_bytes(PLAN_BYTES),
        Route::post(
            "/api/v1/plans/import",
            operator,
            "Keep a new plan from a file: GPX, GeoJSON, or JSON of an IMC PlanSpecification. The body is the file.",
            plans::import,
        )
        .query::<PlanImportQuery>()
        .takes_file()
        .gives::<ImportedPlan>()
        .body_bytes(PLAN_BYTES),
        Route::get("/api/v1/plans/{id}", viewer, "A plan.", plans::read)
            .query::<PlanQuery>()
            .gives::<StoredPlan>(),
        Route::put(
            "/api/v1/plans/{id}",
            operator,
            "Change a plan. 409 with the newer one when somebody else changed it meanwhile.",
            plans::save,
        )
        .takes::<PlanChange>()
        .gives::<StoredPlan>()
        .body_bytes(PLAN_BYTES),
        Route::delete("/api/v1/plans/{id}", operator, "Delete a plan; it can be restored.", plans::delete),
        Route::post("/api/v1/plans/{id}/restore", operator, "Take a deletion back.", plans::restore)
            .gives::<StoredPlan>(),
        Route::post("/api/v1/plans/{id}/duplicate", operator, "Copy a plan.", plans::duplicate)
            .gives::<StoredPlan>(),
        Route::post(
            "/api/v1/plans/{id}/upload",
            operator,
            "Bring a saved plan aboard a vessel; takes the control of it. The effect is seen when the vessel's digest is ours.",
            plans::upload,
        )
        .takes::<PlanUploadRequest>()
        .gives::<Command>(),
        Route::get("/api/v1/plans/{id}/revisions", viewer, "The states that a plan had.", plans::revisions)
            .gives::<Vec<PlanRevision>>(),
        Route::get("/api/v1/plans/{id}/export", viewer, "A plan as a file.", plans::export)
            .query::<PlanExportQuery>()
            .media("application/octet-stream"),
    ]
}

/// The sea chart.
fn chart() -> Vec<Route> {
    let viewer = Need::Somewhere(Role::Viewer);
    vec![
        Route::get("/api/v1/chart", viewer, "The chart set of the server.", charts::set)
            .gives::<ChartSet>()
            .packed(),
        Route::get(
            "/api/v1/chart/tiles/{z}/{x}/{y}",
            viewer,
            "A Mapbox vector tile of the chart, packed by gzip.",
            charts::tile,
        )
        .query::<ChartTileQuery>()
        .media("application/vnd.mapbox-vector-tile"),
        Route::get("/api/v1/chart/at", viewer, "How deep it is at a place, and what is near.", charts::at)
            .query::<ChartAtQuery>()
            .gives::<ChartNear>()
            .packed(),
        Route::post("/api/v1/chart/corridor", viewer, "How deep it is along a way.", charts::corridor)
            .takes::<ChartCorridorRequest>()
            .gives::<ChartCorridor>()
            .packed(),
        Route::post(
            "/api/v1/chart/route",
            viewer,
            "The shortest route through deep water, clear of dangers.",
            charts::route,
        )
        .takes::<SeaRouteRequest>()
        .gives::<SeaRouteAnswer>()
        .packed(),
    ]
}
