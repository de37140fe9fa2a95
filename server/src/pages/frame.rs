//! What all pages share: head, navigation, palette, and how a refusal looks.

use super::words::{self, Text, word};
use crate::web::{ApiError, Kind, NO_ROLE, Remote, asset_path, cookie_name, language, plain_cookie};
use api::Role;
use askama::Template;
use axum::extract::{Form, FromRequestParts};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Html, IntoResponse, Redirect, Response};
use serde::Deserialize;
use shore::identity::{Grants, Language, Principal, Via};
use std::convert::Infallible;

/// The cookie that remembers the palette.
const PALETTE_COOKIE: &str = "lutra_palette";

/// What the base template needs.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Who is logged in; empty for nobody.
    pub(crate) name: String,
    pub(crate) csrf: String,
    pub(crate) palette: &'static str,
    pub(crate) admin: bool,
    /// Whether the person has no role, and sees nothing but what is shared with them.
    pub(crate) guest: bool,
    /// Which vessels the person may stop: `all`, or addresses with commas; empty for none.
    pub(crate) stops: String,
    /// Where the page is, to come back to.
    pub(crate) path: String,
    pub(crate) style: String,
    /// Empty while nothing may be seen that it could show.
    pub(crate) script: String,
    /// The language of the page.
    pub(crate) language: Language,
    /// What the person chose; `None` follows what the browser asks for.
    pub(crate) chosen: Option<Language>,
    /// The script that gives the others the words of the language; empty where they have them.
    pub(crate) words: String,
}

impl Frame {
    fn new(headers: &HeaderMap, who: Option<&Principal>, path: &str) -> Self {
        let may_see = who.filter(|who| {
            let locked = matches!(who.via, Via::Session { must_change_password: true, .. });
            !locked && who.grants.somewhere().is_some()
        });
        let language = language::of(headers, who);
        Self {
            language,
            chosen: who.and_then(|who| who.language),
            words: words_path(language, path),
            name: who.map(|who| who.name.clone()).unwrap_or_default(),
            csrf: who.map(|who| who.csrf().to_owned()).unwrap_or_default(),
            palette: palette(plain_cookie(headers, PALETTE_COOKIE).unwrap_or_default()),
            guest: who.is_some_and(|who| who.grants.somewhere().is_none()),
            admin: who.is_some_and(|who| who.grants.everywhere() == Some(Role::Admin)),
            stops: may_see.map(|who| stops(&who.grants)).unwrap_or_default(),
            path: path.to_owned(),
            style: asset_path("main.css"),
            script: may_see.map(|_| asset_path("main.js")).unwrap_or_default(),
        }
    }

    /// `english` in the page's language.
    pub(crate) fn t(&self, english: &'static str) -> Text {
        words::t(self.language, english)
    }

    /// A word that the server has for people and machines, as `acknowledged`, in the page's language.
    pub(crate) fn said<'a>(&self, english: &'a str) -> &'a str {
        words::said(self.language, english)
    }
}

/// The script with the words of a language for the page at this path; empty for English, which the other scripts have.
fn words_path(language: Language, path: &str) -> String {
    match (language, bundle_of(path)) {
        (Language::English, _) => String::new(),
        (Language::Bokmal, Some(bundle)) => asset_path(&format!("nb-{bundle}.js")),
        (Language::Bokmal, None) => asset_path("nb.js"),
    }
}

/// The words of a page with many texts of its own, which `web/scripts/words.mjs` has by the same name; other pages share
/// theirs.
fn bundle_of(path: &str) -> Option<&'static str> {
    let mut parts = path.split('/').skip(1);
    Some(match (parts.next().unwrap_or_default(), parts.next()) {
        ("", None) => "fleet",
        ("vessels", Some(_)) => "vessel",
        ("plans", Some(_)) => "plan",
        ("no-go-areas", None) => "nogo",
        ("detections", None) => "detections",
        ("data", None) => "data",
        ("explore", None) => "explore",
        ("register", None) => "register",
        ("logbook", None) => "logbook",
        ("missions", None) => "missions",
        ("missions", Some(_)) => "mission",
        ("datasets", None) => "datasets",
        ("datasets", Some(_)) => "dataset",
        _ => return None,
    })
}

/// The vessels that somebody may stop, for the script.
fn stops(grants: &Grants) -> String {
    if grants.everywhere() >= Some(Role::Operator) {
        return "all".to_owned();
    }
    let vessels = grants.vessels_with(Role::Operator).map(|vessel| vessel.to_string());
    vessels.collect::<Vec<_>>().join(",")
}

impl<S: Sync> FromRequestParts<S> for Frame {
    type Rejection = Infallible;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self::new(&parts.headers, parts.extensions.get(), parts.uri.path()))
    }
}

/// A palette by its name; anything else follows the computer's own setting.
fn palette(name: &str) -> &'static str {
    ["sun", "day", "dusk", "night"].into_iter().find(|known| *known == name).unwrap_or("auto")
}

/// The chosen palette and where to go back to.
#[derive(Debug, Deserialize)]
pub(super) struct Chosen {
    palette: String,
    #[serde(default)]
    next: String,
}

/// `POST /palette`.
pub(super) async fn choose_palette(remote: Remote, Form(chosen): Form<Chosen>) -> Response {
    let cookie = set_cookie(PALETTE_COOKIE, palette(&chosen.palette), 400 * 86_400, remote);
    ([(header::SET_COOKIE, cookie)], Redirect::to(inside(&chosen.next))).into_response()
}

/// A cookie that scripts cannot read. `seconds` 0 removes it.
pub(super) fn set_cookie(name: &str, value: &str, seconds: u32, remote: Remote) -> String {
    let secure = if remote.encrypted { "; Secure" } else { "" };
    format!("{name}={value}; Path=/; Max-Age={seconds}; HttpOnly; SameSite=Lax{secure}")
}

/// As [`set_cookie`], under the name for this connection.
pub(super) fn set_secret_cookie(name: &str, value: &str, seconds: u32, remote: Remote) -> String {
    set_cookie(&cookie_name(name, remote), value, seconds, remote)
}

/// `next` when it is a path of ours, else the first page.
pub(super) fn inside(next: &str) -> &str {
    // Browsers pass over control characters in an address: `/<tab>/elsewhere` would lead elsewhere.
    let odd = |letter: char| letter == '\\' || letter.is_control();
    let ours = next.starts_with('/') && !next.starts_with("//") && !next.contains(odd);
    if ours { next } else { "/" }
}

/// Renders a template.
pub(super) fn html(template: &impl Template) -> Response {
    match template.render() {
        Ok(text) => Html(text).into_response(),
        Err(error) => ApiError::internal(&error).into_response(),
    }
}

/// What the pages' worker shows where the server is not reached: it names nobody and tells no values.
#[derive(Template)]
#[template(path = "offline.html")]
struct OfflinePage {
    frame: Frame,
    script: String,
}

/// `GET /offline`.
pub(super) async fn offline(frame: Frame) -> Response {
    html(&OfflinePage { frame, script: asset_path("offline.js") })
}

#[derive(Template)]
#[template(path = "error.html")]
struct ErrorPage {
    frame: Frame,
    title: String,
    text: String,
}

/// An error that is shown as a page.
#[derive(Debug)]
pub(super) struct PageError(ApiError);

impl<E: Into<ApiError>> From<E> for PageError {
    fn from(error: E) -> Self {
        Self(error.into())
    }
}

impl IntoResponse for PageError {
    fn into_response(self) -> Response {
        refusal(Kind::Page, None, self.0)
    }
}

/// What a page that refuses is headed by.
fn title(status: StatusCode) -> &'static str {
    match status {
        StatusCode::BAD_REQUEST => word("Not understood"),
        StatusCode::FORBIDDEN => word("Not allowed"),
        StatusCode::NOT_FOUND => word("Not found"),
        StatusCode::CONFLICT | StatusCode::UNPROCESSABLE_ENTITY => word("Not done"),
        StatusCode::GONE => word("Not there any more"),
        StatusCode::TOO_MANY_REQUESTS | StatusCode::SERVICE_UNAVAILABLE => word("Not at present"),
        _ => word("Error"),
    }
}

/// A refusal as its reader expects it, in the language of [`language::current`]. `next` is where somebody who logs in wants to
/// go on.
pub(crate) fn refusal(kind: Kind, next: Option<&str>, error: ApiError) -> Response {
    if kind != Kind::Page {
        return error.into_response();
    }
    if error.status == StatusCode::UNAUTHORIZED {
        let next: String = form_urlencoded::byte_serialize(inside(next.unwrap_or("/")).as_bytes()).collect();
        return Redirect::to(&format!("/login?next={next}")).into_response();
    }
    if error.code == "password_change_required" {
        return Redirect::to("/account").into_response();
    }
    // The first page after a login, and what the brand leads to.
    if error.code == NO_ROLE && next == Some("/") {
        return Redirect::to("/shared").into_response();
    }
    let language = language::current();
    let frame =
        Frame { language, words: words_path(language, "/"), ..Frame::new(&HeaderMap::new(), None, "/") };
    let title = words::said(language, title(error.status)).to_owned();
    let text = words::worded(language, &error.text);
    let mut response = html(&ErrorPage { frame, title, text });
    *response.status_mut() = error.status;
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_gets_its_own_words_and_others_share_theirs() {
        for (path, wanted) in [
            ("/", Some("fleet")),
            ("/vessels/2068", Some("vessel")),
            ("/plans/7", Some("plan")),
            ("/plans", None),
            ("/datasets/3", Some("dataset")),
            ("/admin/vessels", None),
            ("", Some("fleet")),
        ] {
            assert_eq!(bundle_of(path), wanted, "{path}");
        }
        assert_eq!(words_path(Language::English, "/"), "");
    }

    #[test]
    fn nobody_is_sent_elsewhere_after_login() {
        for outside in
            ["https://evil.example", "//evil.example", "/\\evil.example", "javascript:x", "", "/a\nb"]
        {
            assert_eq!(inside(outside), "/", "{outside}");
        }
        assert_eq!(inside("/\t/evil.example"), "/");
        assert_eq!(inside("/vessel/7?a=b"), "/vessel/7?a=b");
    }
}
