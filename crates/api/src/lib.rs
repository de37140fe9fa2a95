//! The API's data types: what browsers and scripts send to the server and get from it.
//!
//! One definition serves three readers: `serde` for the wire, `utoipa` for the OpenAPI document and, in tests,
//! `ts-rs` for `web/src/api/types.gen.ts`, which is committed and compared.
//!
//! Times are microseconds since 1970 UTC, as whole numbers that JavaScript holds exactly until the year 2255.
//! Angles are radians and lengths metres as in IMC, unless a name says otherwise; values carry their unit.
//!
//! Data only: it knows no other crate of Lutra. Begin at `LiveFrame` (the fleet as it changes), `OrderRequest` and `Command`
//! (orders), `PlanDocument` (plans).

mod alarms;
mod areas;
mod charts;
mod commands;
mod connections;
mod datasets;
mod events;
mod explore;
mod history;
mod live;
mod logbook;
mod missions;
mod people;
mod plans;
mod refusals;
mod register;
mod routing;
mod said;
mod samples;
mod table;
mod teleop;
mod transfer;
mod vessel_reports;

pub use alarms::{
    Alarm, AlarmHistory, AlarmHistoryQuery, AlarmList, AlarmNote, AlarmSaying, AlarmShelving, AlarmWord,
    ChartDifference, ShelveRequest, filled,
};
pub use areas::{
    NoGoArea, NoGoAreaChange, NoGoAreaQuery, NoGoAreaRequest, NoGoAreas, NoGoAreasQuery, NoGoAreasRequest,
};
pub use charts::{
    ChartAtQuery, ChartAttribute, ChartBounds, ChartCell, ChartCorridor, ChartCorridorRequest, ChartDepth,
    ChartNear, ChartObject, ChartPiece, ChartProfilePoint, ChartSet, ChartTileQuery, Guard, GuardReason,
    GuardWarning,
};
pub use commands::{
    Command, CommandStep, Lease, LeaseAction, LeaseChange, LeaseHolder, LeaseRequest, LeaseWaiting, Order,
    OrderRequest, Ordered, Parameter, PlanAboard, PlanGiven, PlansAboard, StopQuery,
};
pub use connections::{LinkStatus, LinkWay, LinkWays, Recording, TransportPeer, VesselChart};
pub use datasets::{
    Dataset, DatasetAuthor, DatasetChange, DatasetCheck, DatasetContent, DatasetCovered, DatasetDraft,
    DatasetFileQuery, DatasetQuery, DatasetShare, DatasetShareMade, DatasetShareRequest, DatasetState,
    DatasetStep, DatasetVersion, DatasetVessel, DatasetWithdrawal, DatasetWithdrawn, ShareVisit,
    ShareVisitKind, SharedDataset,
};
pub use events::{
    Detection, Detections, DetectionsFileQuery, DetectionsQuery, Entity, EventsQuery, FleetDetectionsQuery,
    Gap, GapKind, GapsQuery, LogBook, LogBookEntry, ReceiverClock,
};
pub use explore::{
    DetectionFlag, DetectionsSummary, DetectionsSummaryQuery, FlagCode, SummaryBar, SummaryFlag,
    SummarySquare, SummaryTag, SummaryVessel,
};
pub use history::{At, AtQuery, ExportSize, Recorded, RecordedDay, TrackPoint, TrackQuery};
pub use live::{
    Field, Fix, LiveAnswer, LiveFrame, LiveRequest, LiveSample, LiveSeries, LiveStop, LiveStopped, Liveness,
    Subscription, System, Update,
};
pub use logbook::{
    LogNote, LogNoteChange, LogNoteQuery, LogNoteRequest, LogNoteRevision, LogNotes, LogNotesFileQuery,
    LogNotesQuery, LogWord,
};
pub use missions::{
    Mission, MissionChange, MissionQuery, MissionRequest, MissionSummary, MissionVessel, Missions,
    MissionsQuery,
};
pub use people::{AuditEntry, Me, NewToken, Permission, Person, Role, Session, Token, TokenMade, Vessel};
pub use plans::{
    ImportedPlan, PlanChange, PlanCheck, PlanCost, PlanDocument, PlanExportQuery, PlanImportQuery, PlanLeg,
    PlanPlace, PlanQuery, PlanRevision, PlanSpeed, PlanStep, PlanSummary, PlanTask, PlanTrouble,
    PlanUploadRequest, SpeedUnit, StoredPlan,
};
pub use refusals::{NoControl, Refusal, RefusalReason};
pub use register::{
    RegisterAnimal, RegisterAnswer, RegisterChange, RegisterDeleteQuery, RegisterDeployment, RegisterEntry,
    RegisterFieldChange, RegisterImport, RegisterImportChange, RegisterImportQuery, RegisterKind,
    RegisterPerson, RegisterProblem, RegisterProject, RegisterQuery, RegisterReceiver, RegisterRecord,
    RegisterTag,
};
pub use routing::{
    SeaRoute, SeaRouteAnswer, SeaRouteClosed, SeaRouteCurrent, SeaRouteCurrentGrid, SeaRouteGaveUp,
    SeaRouteLeg, SeaRouteMoved, SeaRouteNarrow, SeaRouteObjective, SeaRoutePassable, SeaRouteProgress,
    SeaRouteRefusal, SeaRouteRequest, SeaRouteTraffic, SeaRouteZone, SeaRouteZoneKind,
};
pub use said::{Fixed, Said, Wording, fixed, say};
pub use samples::{
    Buckets, BucketsQuery, Label, Next, SampleRow, Samples, SamplesQuery, Series, SeriesField, SeriesQuery,
    ValueKind,
};
pub use table::{
    TableChoice, TableDetection, TableDetections, TableDetectionsQuery, TableQuery, TableRow,
    TableSeriesQuery,
};
pub use teleop::{TeleopMessage, TeleopPhase, TeleopSample, TeleopStatus, TeleopStop};
pub use transfer::{ExportQuery, Import, ImportNote, ImportQuery, ImportState, LogQuery};
pub use vessel_reports::{
    EntityReport, ParameterAbout, ParameterReport, PlanUnderWay, RouteLeg, VesselParameters, VesselQuery,
    VesselQuerySent,
};

#[cfg(test)]
mod typescript;
