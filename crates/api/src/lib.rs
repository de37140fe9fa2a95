//! What browsers and scripts send to the server and get from it.
//!
//! One definition serves three readers: `serde` for the wire, `utoipa` for the OpenAPI document and, in tests,
//! `ts-rs` for `web/src/api/types.gen.ts`, which is committed and compared.
//!
//! Times are microseconds since 1970 UTC, as whole numbers that JavaScript holds exactly until the year 2255.
//! Angles are radians and lengths metres as in IMC, unless a name says otherwise; values carry their unit.
//!
//! Data only: it knows no other crate of Lutra. Begin at `LiveFrame` (the fleet as it changes), `OrderAsk` and `Command`
//! (orders), `PlanDocument` (plans).

mod alarms;
mod charts;
mod commands;
mod doors;
mod events;
mod history;
mod live;
mod logbook;
mod missions;
mod people;
mod plans;
mod routing;
mod samples;
mod teleop;
mod told;
mod transfer;

pub use alarms::{
    Alarm, AlarmHistory, AlarmHistoryQuery, AlarmList, AlarmNote, AlarmShelf, AlarmWord, ShelveAsk,
};
pub use charts::{
    ChartAtQuery, ChartAttribute, ChartBounds, ChartCell, ChartCorridor, ChartCorridorAsk, ChartDepth,
    ChartNear, ChartObject, ChartPiece, ChartProfilePoint, ChartSet, ChartTileQuery, Guard, GuardReason,
    GuardWarning,
};
pub use commands::{
    Command, CommandStep, Lease, LeaseAction, LeaseAsk, LeaseChange, LeaseHolder, LeaseWaiting, Order,
    OrderAsk, Ordered, Parameter, PlanAboard, PlanGiven, PlansAboard, StopQuery,
};
pub use doors::{DoorPeer, LinkStatus, Recording, VesselChart};
pub use events::{
    Detection, Detections, DetectionsFileQuery, DetectionsQuery, Entity, EventsQuery, FleetDetectionsQuery,
    Gap, GapKind, GapsQuery, LogBook, LogBookEntry, ReceiverClock,
};
pub use history::{At, AtQuery, ExportSize, Recorded, RecordedDay, TrackPoint, TrackQuery};
pub use live::{
    Field, Fix, LiveAnswer, LiveFrame, LiveRequest, LiveSample, LiveSeries, LiveStop, LiveStopped, Liveness,
    Subscription, System, Update,
};
pub use logbook::{
    LogNote, LogNoteAsk, LogNoteChange, LogNoteEarlier, LogNotes, LogNotesFileQuery, LogNotesQuery, LogWord,
};
pub use missions::{
    Mission, MissionAsk, MissionChange, MissionSummary, MissionVessel, Missions, MissionsQuery,
};
pub use people::{AuditEntry, Me, NewToken, Permission, Person, Role, Session, Token, TokenMade, Vessel};
pub use plans::{
    ImportedPlan, PlanChange, PlanCheck, PlanCost, PlanDocument, PlanExportQuery, PlanImportQuery, PlanLeg,
    PlanPlace, PlanQuery, PlanRevision, PlanSpeed, PlanStep, PlanSummary, PlanTask, PlanTrouble,
    PlanUploadAsk, SpeedUnit, StoredPlan,
};
pub use routing::{SeaRoute, SeaRouteAnswer, SeaRouteAsk, SeaRouteLeg, SeaRouteMoved, SeaRouteRefusal};
pub use samples::{
    Buckets, BucketsQuery, Label, Next, SampleRow, Samples, SamplesQuery, Series, SeriesField, SeriesQuery,
    ValueKind,
};
pub use teleop::{TeleopPhase, TeleopSample, TeleopSay, TeleopStop, TeleopTold};
pub use told::{
    EntityTold, ParameterAbout, ParameterTold, PlanUnderWay, RouteLeg, VesselAsk, VesselAsked,
    VesselParameters,
};
pub use transfer::{ExportQuery, Import, ImportQuery, ImportState, LogQuery};

#[cfg(test)]
mod typescript;
