//! Routes of the log book and missions.

use crate::http::{logbook, missions};
use crate::web::{Need, Route};
use api::{
    LogNote, LogNoteChange, LogNoteQuery, LogNoteRequest, LogNoteRevision, LogNotes, LogNotesFileQuery,
    LogNotesQuery, Mission, MissionChange, MissionQuery, MissionRequest, MissionSummary, Missions,
    MissionsQuery, Role,
};
use shore::logbook::PHOTO_BYTES;

/// The log book. Who may see and change a note depends on its vessel and author.
pub(super) fn log_book() -> Vec<Route> {
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

/// Recorded missions. Who may see and change one depends on its vessels.
pub(super) fn missions_table() -> Vec<Route> {
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
