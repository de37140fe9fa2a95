//! Orders to vessels.

use super::caller::Caller;
use super::error::ApiError;
use super::guard::{OfVessel, Who};
use crate::people::Fault;
use crate::shore::AppState;
use api::Ordered;
use axum::Json;
use axum::extract::State;
use imc::messages::Abort;
use imc::{Header, Packet};
use std::time::Duration;

/// How long a stop waits for the audit log. A disk that hangs must not keep a boat going.
const AUDIT_PATIENCE: Duration = Duration::from_millis(500);

/// `POST /api/v1/vessels/{vessel}/abort`: sends Abort from the server's own address.
///
/// The audit log is written first, but a stop that it cannot take goes out all the same, and the answer says so. A
/// stop that no door leads to gets a second line in the log.
pub(crate) async fn abort(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    caller: Caller,
) -> Result<Json<Ordered>, ApiError> {
    let from = caller.address.to_string();
    let audit = |outcome: Result<(), Fault>| {
        let written =
            state.people.act(&who, from.clone(), "vessel.abort", vessel.to_string(), move |_| outcome);
        async move {
            match tokio::time::timeout(AUDIT_PATIENCE, written).await {
                Ok(Ok(()) | Err(Fault::Refused(_))) => true,
                Ok(Err(error)) => {
                    tracing::error!(%error, %vessel, "a stop is not in the audit log");
                    false
                }
                Err(_) => {
                    tracing::error!(%vessel, "the audit log hangs; a stop went out before it was written");
                    false
                }
            }
        }
    };
    let audited = audit(Ok(())).await;
    let now = state.relay.clock().now().utc;
    let header = Header {
        timestamp: now.seconds(),
        src: state.relay.address(),
        src_ent: u8::MAX,
        dst: vessel,
        dst_ent: u8::MAX,
    };
    let packet = Packet::new(header, Abort).encode().map_err(|error| ApiError::internal(&error))?;
    let reached = state.relay.send(packet.into()).await.map_err(|_| ApiError::stopping())?;
    tracing::warn!(%vessel, person = who.name, reached, "stop");
    if !reached {
        audit(Err(Fault::Refused("not sent: no door leads to the vessel".to_owned()))).await;
    }
    Ok(Json(Ordered { time_us: now.micros(), reached, audited }))
}
