//! The no-go areas. The script asks the API for everything in the page.

use super::frame::{Frame, PageError, html};
use askama::Template;
use axum::response::Response;

#[derive(Template)]
#[template(path = "areas.html")]
struct AreasPage {
    frame: Frame,
}

/// `GET /no-go-areas`.
pub(super) async fn page(frame: Frame) -> Result<Response, PageError> {
    Ok(html(&AreasPage { frame }))
}
