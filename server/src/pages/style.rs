//! What pages are made of, for who works on them: sizes, colours, icons and parts, drawn by the script.

use super::frame::{Frame, html};
use askama::Template;
use axum::response::Response;

#[derive(Template)]
#[template(path = "style.html")]
struct StylePage {
    frame: Frame,
}

/// `GET /style`.
pub(super) async fn page(frame: Frame) -> Response {
    html(&StylePage { frame })
}
