//! `web/src/api/types.gen.ts`, made from the types here and compared with the file that is committed.

use crate::{
    Alarm, AlarmList, AlarmNote, AlarmShelf, AlarmWord, At, AuditEntry, Buckets, ChartAttribute, ChartBounds,
    ChartCell, ChartCorridor, ChartCorridorAsk, ChartDepth, ChartNear, ChartObject, ChartPiece,
    ChartProfilePoint, ChartSet, Command, CommandStep, Detection, Detections, DoorPeer, Entity, Field, Fix,
    Gap, GapKind, Guard, GuardReason, GuardWarning, Import, ImportState, ImportedPlan, Label, Lease,
    LeaseAction, LeaseAsk, LeaseChange, LeaseHolder, LeaseWaiting, LinkStatus, LiveFrame, LiveRequest,
    Liveness, LogBook, LogBookEntry, Me, NewToken, Next, Order, OrderAsk, Ordered, Parameter, Permission,
    Person, PlanAboard, PlanChange, PlanCheck, PlanCost, PlanDocument, PlanGiven, PlanLeg, PlanPlace,
    PlanRevision, PlanSpeed, PlanStep, PlanSummary, PlanTask, PlanTrouble, PlanUploadAsk, PlansAboard,
    Recorded, Recording, Role, SampleRow, Samples, Series, SeriesField, Session, ShelveAsk, SpeedUnit,
    StoredPlan, Subscription, System, Token, TokenMade, TrackPoint, Update, ValueKind, Vessel, VesselChart,
};
use ts_rs::TS;

#[expect(clippy::too_many_lines, reason = "a list, one line for each type")]
fn text() -> String {
    let declarations = [
        <Alarm as TS>::decl(),
        At::decl(),
        AlarmList::decl(),
        AlarmNote::decl(),
        AlarmShelf::decl(),
        AlarmWord::decl(),
        AuditEntry::decl(),
        Buckets::decl(),
        ChartAttribute::decl(),
        ChartBounds::decl(),
        ChartCell::decl(),
        ChartCorridor::decl(),
        ChartCorridorAsk::decl(),
        ChartDepth::decl(),
        ChartNear::decl(),
        ChartObject::decl(),
        ChartPiece::decl(),
        ChartProfilePoint::decl(),
        ChartSet::decl(),
        Command::decl(),
        CommandStep::decl(),
        Detection::decl(),
        Detections::decl(),
        DoorPeer::decl(),
        Entity::decl(),
        Field::decl(),
        Fix::decl(),
        Gap::decl(),
        GapKind::decl(),
        Guard::decl(),
        GuardReason::decl(),
        GuardWarning::decl(),
        Import::decl(),
        ImportState::decl(),
        ImportedPlan::decl(),
        Label::decl(),
        Lease::decl(),
        LeaseAction::decl(),
        LeaseAsk::decl(),
        LeaseChange::decl(),
        LeaseHolder::decl(),
        LeaseWaiting::decl(),
        LinkStatus::decl(),
        LiveFrame::decl(),
        LiveRequest::decl(),
        Liveness::decl(),
        LogBook::decl(),
        LogBookEntry::decl(),
        Me::decl(),
        NewToken::decl(),
        Next::decl(),
        Order::decl(),
        OrderAsk::decl(),
        Ordered::decl(),
        Parameter::decl(),
        Permission::decl(),
        Person::decl(),
        PlanAboard::decl(),
        PlanChange::decl(),
        PlanCheck::decl(),
        PlanCost::decl(),
        PlanDocument::decl(),
        PlanGiven::decl(),
        PlanLeg::decl(),
        PlanPlace::decl(),
        PlanRevision::decl(),
        PlanSpeed::decl(),
        PlanStep::decl(),
        PlanSummary::decl(),
        PlanTask::decl(),
        PlanTrouble::decl(),
        PlanUploadAsk::decl(),
        PlansAboard::decl(),
        Recorded::decl(),
        Recording::decl(),
        Role::decl(),
        SampleRow::decl(),
        Samples::decl(),
        Series::decl(),
        SeriesField::decl(),
        Session::decl(),
        ShelveAsk::decl(),
        SpeedUnit::decl(),
        StoredPlan::decl(),
        Subscription::decl(),
        System::decl(),
        Token::decl(),
        TokenMade::decl(),
        TrackPoint::decl(),
        Update::decl(),
        ValueKind::decl(),
        Vessel::decl(),
        VesselChart::decl(),
    ];
    let mut text = "// Made from crates/api by `make types`. Do not edit.\n".to_owned();
    for declaration in declarations {
        text.push_str("\nexport ");
        text.push_str(&declaration);
        text.push('\n');
    }
    text
}

#[test]
fn the_committed_types_are_these() {
    let path = testkit::repository().join("web/src/api/types.gen.ts");
    if std::env::var_os("LUTRA_WRITE_TYPES").is_some() {
        std::fs::write(&path, text()).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(committed, text(), "run `make types` and commit {}", path.display());
}
