//! One vessel: map, instruments, plots, values, log book. What moves is drawn by the script.

use super::frame::{Frame, PageError, html};
use super::names_for;
use crate::AppState;
use crate::web::{OfVessel, Who};
use api::Role;
use askama::Template;
use axum::extract::State;
use axum::response::Response;

#[derive(Template)]
#[template(path = "vessel.html")]
struct VesselPage {
    frame: Frame,
    /// Its name, or its address.
    name: String,
    address: u16,
    /// The name that people gave it; empty for none.
    given: String,
    /// Names that people gave to the vessels that this one may see, as JSON by address, for the script.
    names: String,
    /// Whether the person may stop it.
    operator: bool,
    /// Whether the person may export its data.
    researcher: bool,
}

/// `GET /vessels/{vessel}`.
pub(super) async fn page(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    frame: Frame,
) -> Result<Response, PageError> {
    let address = vessel.0;
    let names = names_for(&state, &who);
    let given = names.get(&address).cloned();
    let role = who.grants.on(address);
    Ok(html(&VesselPage {
        frame,
        name: given.clone().unwrap_or_else(|| format!("0x{address:04X}")),
        address,
        given: given.unwrap_or_default(),
        names: serde_json::to_string(&names).unwrap_or_default(),
        operator: role >= Some(Role::Operator),
        researcher: role >= Some(Role::Researcher),
    }))
}
