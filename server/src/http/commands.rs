//! Orders to vessels.

use super::asked::Asked;
use super::caller::Caller;
use super::error::ApiError;
use super::guard::{OfVessel, Who};
use super::orders::Issuer;
use super::stop;
use crate::shore::AppState;
use api::{Ordered, StopQuery};
use axum::Json;
use axum::extract::State;

/// `POST /api/v1/vessels/{vessel}/abort`.
pub(crate) async fn abort(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    caller: Caller,
    Asked(StopQuery { window, key }): Asked<StopQuery>,
) -> Result<Json<Ordered>, ApiError> {
    let by = Issuer { who, from: caller.address.to_string(), window };
    stop::stop(&state, vessel, by, &key).await.map(Json)
}
