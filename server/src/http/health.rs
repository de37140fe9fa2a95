//! Health of the server, and its metrics for Prometheus.
//!
//! `/healthz` is for monitoring. It answers 503 while nothing can be recorded, while the audit log cannot be written, or
//! while an owner of the server's state hangs or is lost: a server that loses data is not healthy, even if it runs. It must
//! not trigger a restart: that frees no disk space, and queued data would be lost. systemd watches the process itself,
//! which ends when an owner is lost. `/readyz` is for load balancers: 503 while the server ends. Both answer from published
//! state, without a request to another task.

use crate::AppState;
use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use shore::router::PeerFigures;
use std::collections::BTreeMap;

/// `GET /readyz`.
pub(crate) async fn readyz(State(state): State<AppState>) -> Response {
    if state.shore.owners.are_there() && !state.shore.stop.is_cancelled() {
        return Json(json!({ "status": "ready" })).into_response();
    }
    (StatusCode::SERVICE_UNAVAILABLE, Json(json!({ "status": "ending" }))).into_response()
}

/// `GET /healthz`. Accessible to anyone, so without the names of folders.
pub(crate) async fn healthz(State(state): State<AppState>) -> Response {
    let recording =
        || state.shore.recorder.state().borrow().trouble.as_ref().map(|trouble| trouble.short.to_owned());
    let trouble = state.shore.owners.trouble().or_else(recording);
    let trouble = trouble.or_else(|| state.shore.people.trouble().map(str::to_owned));
    let version = env!("CARGO_PKG_VERSION");
    match trouble {
        None => Json(json!({ "status": "ok", "version": version })).into_response(),
        Some(reason) => {
            let more = if state.shore.owners.are_there() {
                "the log and /api/v1/recording say more; a restart does not help"
            } else {
                "the log says where the fault is"
            };
            let body = json!({ "status": "trouble", "reason": reason, "more": more, "version": version });
            (StatusCode::SERVICE_UNAVAILABLE, Json(body)).into_response()
        }
    }
}

/// `GET /metrics` in Prometheus' text format.
pub(crate) async fn metrics(State(state): State<AppState>) -> Response {
    measure(&state).await;
    let kind = [(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")];
    (kind, state.metrics.render()).into_response()
}

/// Updates metrics from the state of other services.
async fn measure(state: &AppState) {
    let recorder = state.shore.recorder.state().borrow().clone();
    metrics::gauge!("lutra_recording_trouble").set(f64::from(u8::from(recorder.trouble.is_some())));
    metrics::gauge!("lutra_history_behind").set(f64::from(u8::from(recorder.history_behind.is_some())));
    metrics::gauge!("lutra_waiting_bytes").set(state.shore.recorder.waiting_bytes() as f64);
    if let Some(certificate) = state.shore.alarms.known_certificate() {
        let left_us = certificate.until.micros().saturating_sub(state.shore.clock.utc().micros());
        metrics::gauge!("lutra_certificate_expiry_seconds").set(left_us as f64 / 1e6);
        metrics::gauge!("lutra_certificate_trouble").set(f64::from(u8::from(certificate.refused.is_some())));
    }
    if let Some(backup) = state.backup.state() {
        if let Some(made) = backup.made {
            let age_us = state.shore.clock.utc().micros().saturating_sub(made.micros());
            metrics::gauge!("lutra_backup_age_seconds").set(age_us as f64 / 1e6);
        }
        metrics::gauge!("lutra_backup_trouble").set(f64::from(u8::from(backup.trouble.is_some())));
    }
    let Ok(peers) = state.shore.router.peers().await else { return };
    let mut transports: BTreeMap<&str, u32> =
        ["link", "imcproxy", "tcp", "udp"].into_iter().map(|transport| (transport, 0)).collect();
    for PeerFigures { state, .. } in &peers {
        *transports.entry(state.peer.transport.name()).or_default() += 1;
    }
    for (transport, count) in transports {
        metrics::gauge!("lutra_transport_peers", "transport" => transport).set(f64::from(count));
    }
    let Ok(counters) = state.shore.router.counters().await else { return };
    for (what, count) in [
        ("received", counters.received),
        ("damaged", counters.damaged),
        ("refused", counters.refused),
        ("duplicates", counters.duplicates),
        ("delivered", counters.delivered),
        ("unroutable", counters.unroutable),
    ] {
        metrics::counter!("lutra_relay_packets_total", "what" => what).absolute(count);
    }
}
