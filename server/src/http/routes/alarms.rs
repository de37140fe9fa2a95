//! Routes of alarms.

use crate::http::alarms;
use crate::web::{Need, Route};
use api::{Alarm, AlarmHistory, AlarmHistoryQuery, AlarmList, Role, ShelveRequest};

/// Alarms. Who may acknowledge one depends on its vessel.
pub(super) fn alarms_table() -> Vec<Route> {
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
