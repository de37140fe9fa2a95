//! The first page: the fleet on a map and in a list, alive.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::http::Who;
use api::{Role, System, Vessel};
use askama::Template;
use axum::extract::State;
use axum::response::Response;
use shore::Wanted;
use std::collections::BTreeMap;
use std::sync::Arc;

#[derive(Template)]
#[template(path = "fleet.html")]
struct FleetPage {
    frame: Frame,
    /// Whether data may be exported.
    researcher: bool,
    /// To export from: all that have names, and all that are there.
    vessels: Vec<Vessel>,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
}

/// `GET /`.
pub(super) async fn page(
    State(state): State<AppState>,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let names = names_for(&state, &who);
    let wanted = Arc::new(Wanted { grants: who.grants.clone(), ..Wanted::default() });
    let mut exportable: BTreeMap<u16, String> =
        state.shore.fleet.systems(wanted).await.unwrap_or_default().into_iter().map(named).collect();
    exportable.extend(names.clone());
    exportable.retain(|address, _| who.grants.on(*address) >= Some(Role::Researcher));
    let vessel = |(address, name)| Vessel { address, name };
    Ok(html(&FleetPage {
        vessels: exportable.into_iter().map(vessel).collect(),
        frame,
        researcher: who.grants.somewhere() >= Some(Role::Researcher),
        names: serde_json::to_string(&names).unwrap_or_default(),
    }))
}

/// A system's address with its own name, or the address again.
fn named(system: System) -> (u16, String) {
    let name = system.name.unwrap_or_else(|| format!("0x{:04X}", system.address));
    (system.address, name)
}
