//! Bringing logs in. The script of the page uploads them and shows how far they are.

use crate::pages::frame::{Frame, PageError, html};
use askama::Template;
use axum::response::Response;

#[derive(Template)]
#[template(path = "admin_import.html")]
struct ImportPage {
    frame: Frame,
}

/// `GET /admin/import`.
pub(in crate::pages) async fn page(frame: Frame) -> Result<Response, PageError> {
    Ok(html(&ImportPage { frame }))
}
