//! Permissions, tested for every row of the table of routes, and sessions from login to logout.

use crate::AppState;
use crate::backups::Watched;
use crate::config::Config;
use crate::pages::Manual;
use crate::serve::{self, router};
use crate::web::{Kind, Need, peer::Peer};
use api::{AuditEntry, Role};
use axum::Router;
use axum::body::{Body, Bytes, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode, header};
use shore::Opened;
use shore::clock::{self, Clock};
use shore::identity::audit::Entries;
use shore::identity::testing::NewScript;
use shore::identity::{People, persons, vessels};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use tower::ServiceExt as _;

/// The vessel on which some people have a role.
const OWN: u16 = 7;

pub(super) struct Shore {
    router: Router,
    people: People,
    first_password: String,
    pub(super) state: AppState,
    folder: tempfile::TempDir,
}

#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: StatusCode,
    pub(super) headers: HeaderMap,
    pub(super) body: String,
    pub(super) bytes: Bytes,
}

impl Answer {
    /// Whether the guard refused the request.
    pub(super) fn is_refused(&self) -> bool {
        let to = self.headers.get(header::LOCATION).and_then(|to| to.to_str().ok()).unwrap_or_default();
        matches!(self.status, StatusCode::UNAUTHORIZED | StatusCode::FORBIDDEN)
            || (self.status == StatusCode::SEE_OTHER && (to.starts_with("/login?") || to == "/account"))
    }

    pub(super) fn cookies(&self) -> String {
        let set = self.headers.get_all(header::SET_COOKIE).iter().map(|value| value.to_str().unwrap());
        set.map(|cookie| cookie.split(';').next().unwrap()).collect::<Vec<_>>().join("; ")
    }

    /// The token in the page's first form that has one.
    fn csrf(&self) -> String {
        let after = self.body.split("name=\"csrf\" value=\"").nth(1).expect("a form");
        after.split('"').next().unwrap().to_owned()
    }
}

impl Shore {
    async fn start() -> Self {
        Self::with(|_| ()).await
    }

    /// A server on a prepared data folder.
    pub(super) async fn with(fill: impl FnOnce(&Path)) -> Self {
        Self::by(Clock::real(), fill).await
    }

    /// The same, with another clock.
    pub(super) async fn by(clock: Clock, fill: impl FnOnce(&Path)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fill(folder.path());
        Self::of(folder, clock, |_| ()).await
    }

    /// A server with another configuration.
    pub(super) async fn changed(change: impl FnOnce(&mut Config)) -> Self {
        Self::of(tempfile::tempdir().unwrap(), Clock::real(), change).await
    }

    async fn of(folder: tempfile::TempDir, clock: Clock, change: impl FnOnce(&mut Config)) -> Self {
        let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
        change(&mut config);
        // Without background tasks: tests drive what they test.
        let running = Opened::open(config.shore(), clock).unwrap().assemble().await.unwrap();
        let metrics = serve::figures();
        let shore = running.shore.clone();
        let state = AppState {
            config: Arc::new(config),
            shore,
            backup: Watched::new(),
            metrics,
            manual: Manual::default(),
        };
        let people = state.shore.people.clone();
        let first = running.first_admin;
        let first_password = first.unwrap().one_time_password;
        Self { router: router::router(state.clone()), people, first_password, state, folder }
    }

    pub(super) fn data(&self) -> &Path {
        self.folder.path()
    }

    /// The answer to a request with `token`.
    pub(super) async fn get(&self, path: &str, token: &str) -> Answer {
        let request = Request::get(path);
        self.ask(if token.is_empty() { request } else { bearer(request, token) }, "").await
    }

    async fn ask(&self, request: axum::http::request::Builder, body: &str) -> Answer {
        self.send(request, Body::from(body.to_owned())).await
    }

    pub(super) async fn send(&self, request: axum::http::request::Builder, body: Body) -> Answer {
        let mut request = request.body(body).unwrap();
        request
            .extensions_mut()
            .insert(Peer { address: "198.51.100.9:40000".parse().unwrap(), encrypted: false });
        let response = self.router.clone().oneshot(request).await.unwrap();
        let (parts, body) = response.into_parts();
        let bytes = to_bytes(body, 64 << 20).await.unwrap();
        let body = String::from_utf8_lossy(&bytes).into_owned();
        Answer { status: parts.status, headers: parts.headers, body, bytes }
    }

    /// A token for a new person with this role on `vessel` (`None`: all).
    pub(super) async fn token(&self, vessel: Option<u16>, role: Role) -> String {
        let name = format!("person{}", self.people.ask(persons::List).await.unwrap().len());
        let new = NewScript { name, vessel, role, most: Role::Admin };
        self.people.change(new).await.unwrap().1
    }

    /// The audit log, the newest first.
    pub(super) async fn audit(&self) -> Vec<AuditEntry> {
        self.people.write_notes().await;
        self.people.ask(Entries { count: 100, ..Default::default() }).await.unwrap()
    }

    pub(super) async fn form(&self, path: &str, cookies: &str, fields: &[(&str, &str)]) -> Answer {
        let body = form_urlencoded::Serializer::new(String::new()).extend_pairs(fields).finish();
        let request = Request::post(path)
            .header(header::COOKIE, cookies)
            .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
            .header(header::HOST, "boat:8080")
            .header(header::ORIGIN, "http://boat:8080");
        self.ask(request, &body).await
    }

    pub(super) async fn page(&self, path: &str, cookies: &str) -> Answer {
        self.ask(Request::get(path).header(header::COOKIE, cookies), "").await
    }

    pub(super) async fn login(&self, name: &str, password: &str) -> Answer {
        let page = self.page("/login", "").await;
        self.form(
            "/login",
            &page.cookies(),
            &[("name", name), ("password", password), ("csrf", &page.csrf())],
        )
        .await
    }

    /// The cookies of the first admin, with a password of their own.
    pub(super) async fn admin(&self) -> String {
        let cookies = self.login("admin", &self.first_password).await.cookies();
        let csrf = self.page("/account", &cookies).await.csrf();
        let fields = [
            ("csrf", &*csrf),
            ("old", &self.first_password),
            ("new", "nine grey otters"),
            ("again", "nine grey otters"),
        ];
        let changed = self.form("/account/password", &cookies, &fields).await;
        assert_eq!(changed.headers[header::LOCATION], "/account?done=password");
        cookies
    }
}

pub(super) fn request(route: &crate::web::Route) -> axum::http::request::Builder {
    let path =
        route.path.replace("{vessel}", &OWN.to_string()).replace("{id}", "999999").replace("{name}", "x.js");
    let path = path.replace("{number}", "1").replace("{share}", "1").replace("{token}", &"0".repeat(64));
    let path = path.replace("{z}", "0").replace("{x}", "0").replace("{y}", "0");
    Request::builder().method(route.method.clone()).uri(path)
}

pub(super) fn bearer(request: axum::http::request::Builder, token: &str) -> axum::http::request::Builder {
    request.header(header::AUTHORIZATION, format!("Bearer {token}"))
}

#[tokio::test]
async fn every_route_refuses_the_anonymous_unless_it_says_anyone() {
    let shore = Shore::start().await;
    for route in router::table() {
        let answer = shore.ask(request(&route), "").await;
        assert_eq!(answer.is_refused(), route.need != Need::Anyone, "{} {}", route.method, route.path);
        let wrong = shore.ask(bearer(request(&route), &format!("lutra_api_{}", "0".repeat(64))), "").await;
        assert!(wrong.is_refused(), "{} {} with a wrong token", route.method, route.path);
        if route.kind == Kind::Api && wrong.is_refused() {
            assert!(wrong.body.contains("\"code\":\"not_logged_in\""), "{}", wrong.body);
        }
    }
}

#[tokio::test]
async fn every_route_refuses_the_wrong_role_and_lets_the_right_one_in() {
    let shore = Shore::start().await;
    let mut tokens = Vec::new();
    for role in Role::ALL {
        let elsewhere = shore.token(Some(OWN + 1), role).await;
        tokens.push((role, shore.token(None, role).await, shore.token(Some(OWN), role).await, elsewhere));
    }
    for route in router::table() {
        for (role, everywhere, own, elsewhere) in &tokens {
            let (all, some, other) = match route.need {
                Need::Anyone | Need::Account => (true, true, true),
                Need::Session | Need::Link => (false, false, false),
                Need::Somewhere(least) => (*role >= least, *role >= least, *role >= least),
                Need::OnVessel(least) => (*role >= least, *role >= least, false),
                Need::Everywhere(least) => (*role >= least, false, false),
                Need::Figures => (*role == Role::Admin, false, false),
            };
            for (token, may) in [(everywhere, all), (own, some), (elsewhere, other)] {
                // Making tokens, revoking others and ending sessions by token is refused by the handlers.
                let by_token = route.path.ends_with("/tokens") || route.path == "/account/token";
                let ends = route.path.ends_with("/tokens/{id}") || route.path.ends_with("/sessions/{id}");
                if may && (by_token && route.method == "POST" || ends && route.method == "DELETE") {
                    continue;
                }
                let answer = shore.ask(bearer(request(&route), token), "").await;
                assert_eq!(answer.is_refused(), !may, "{} {} as {role}", route.method, route.path);
            }
        }
    }
}

#[tokio::test]
async fn a_one_time_password_opens_nothing_but_its_own_change() {
    let shore = Shore::start().await;
    let login = shore.login("admin", &shore.first_password).await;
    assert_eq!(
        (login.status, &login.headers[header::LOCATION]),
        (StatusCode::SEE_OTHER, &"/account".parse().unwrap())
    );
    let cookies = login.cookies();
    for route in router::table().iter().filter(|route| !matches!(route.need, Need::Anyone | Need::Session)) {
        let answer = shore.ask(request(route).header(header::COOKIE, &cookies), "").await;
        assert!(answer.is_refused(), "{} {}", route.method, route.path);
    }
    let page = shore.page("/account", &cookies).await;
    assert!(page.body.contains("Choose a password of your own"));
    let short =
        [("csrf", &*page.csrf()), ("old", &*shore.first_password), ("new", "short"), ("again", "short")];
    assert_eq!(
        shore.form("/account/password", &cookies, &short).await.status,
        StatusCode::UNPROCESSABLE_ENTITY
    );
}

#[tokio::test]
async fn from_login_to_logout() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    assert_eq!(shore.page("/", &cookies).await.status, StatusCode::OK);
    assert!(shore.login("admin", &shore.first_password).await.body.contains("Name or password is wrong"));
    let again = shore.login("admin", "nine grey otters").await.cookies();
    let csrf = shore.page("/", &cookies).await.csrf();
    let out = shore.form("/logout", &cookies, &[("csrf", &csrf)]).await;
    assert_eq!(out.headers[header::LOCATION], "/login");
    assert!(shore.page("/", &cookies).await.is_refused(), "the session is over on the server too");
    assert_eq!(shore.page("/", &again).await.status, StatusCode::OK, "the other session goes on");
}

#[tokio::test]
async fn changes_need_the_token_and_our_own_origin() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    let csrf = shore.page("/admin", &cookies).await.csrf();
    let fields = |csrf| [("csrf", csrf), ("name", "eve"), ("role", "admin"), ("vessel", "")];
    let forged = shore.form("/admin/person", &cookies, &fields("0000")).await;
    assert_eq!(forged.status, StatusCode::FORBIDDEN);
    let body = format!("csrf={csrf}&name=eve&role=admin&vessel=");
    let post = |origin: (&'static str, &'static str)| {
        Request::post("/admin/person")
            .header(header::COOKIE, &cookies)
            .header(header::CONTENT_TYPE, "application/x-www-form-urlencoded")
            .header(header::HOST, "boat:8080")
            .header(origin.0, origin.1)
    };
    for origin in [("origin", "http://evil.example"), ("origin", "null"), ("sec-fetch-site", "cross-site")] {
        assert_eq!(shore.ask(post(origin), &body).await.status, StatusCode::FORBIDDEN, "{origin:?}");
    }
    assert!(!shore.page("/admin", &cookies).await.body.contains(">eve"));
    let good = shore.ask(post(("origin", "http://boat:8080")), &body).await;
    assert!(good.body.contains("One-time password of eve"), "{}", good.body);
    let login = shore.form("/login", "", &[("name", "eve"), ("password", "x"), ("csrf", "0000")]).await;
    assert!(login.body.contains("too old"), "a login form that we did not show is refused");
}

#[tokio::test]
async fn a_stranger_who_guesses_does_not_lock_the_person_out() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    let mut status = StatusCode::OK;
    for _ in 0..8 {
        status = shore.login("admin", "guess").await.status;
    }
    assert_eq!(status, StatusCode::TOO_MANY_REQUESTS);
    let page = shore.page("/login", "").await;
    let device = cookies.split("; ").find(|cookie| cookie.starts_with("lutra_device")).unwrap();
    let cookies = format!("{}; {device}", page.cookies());
    let fields = [("name", "admin"), ("password", "nine grey otters"), ("csrf", &*page.csrf())];
    assert_eq!(shore.form("/login", &cookies, &fields).await.status, StatusCode::SEE_OTHER);
}

#[tokio::test]
async fn what_people_write_reaches_pages_as_text() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    let csrf = shore.page("/account", &cookies).await.csrf();
    let label = "<script>alert(1)</script>\"'";
    let fields = [("csrf", &*csrf), ("label", label), ("role", "viewer"), ("vessel", ""), ("days", "1")];
    let page = shore.form("/account/token", &cookies, &fields).await;
    assert!(page.body.contains("lutra_api_") && !page.body.contains("<script>alert"), "{}", page.body);
    let page = shore.page("/admin/audit", &cookies).await;
    assert!(page.body.contains("token.make") && !page.body.contains("<script>alert"));
}

#[tokio::test]
async fn nobody_reads_names_of_vessels_that_they_may_not_see() {
    let shore = Shore::start().await;
    for (address, name) in [(OWN, "mine"), (OWN + 1, "theirs")] {
        let add = vessels::Add { address, name: name.to_owned(), now: clock::now() };
        shore.people.change(add).await.unwrap();
    }
    let operator = shore.token(Some(OWN), Role::Operator).await;
    for path in ["/".to_owned(), format!("/vessels/{OWN}"), "/plans".to_owned()] {
        let page = shore.get(&path, &operator).await;
        assert!(page.body.contains("mine") && !page.body.contains("theirs"), "{path}: {}", page.body);
    }
}

#[tokio::test]
async fn an_address_that_leads_nowhere_is_answered_by_a_page() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    for path in ["/plans/new", "/plans/99", "/missions/x", "/missions/99", "/vessels/otter", "/nowhere"] {
        let answer = shore.page(path, &cookies).await;
        assert!(answer.status.is_client_error(), "{path}: {}", answer.status);
        assert!(
            answer.body.contains("<!doctype html>") && answer.body.contains("href=\"/\""),
            "{path}: {}",
            answer.body
        );
    }
}

#[tokio::test]
async fn every_answer_carries_the_headers() {
    let shore = Shore::start().await;
    let mut numbers = BTreeSet::new();
    for path in ["/login", "/nowhere", "/api/v1/me", "/static/nothing.js", "/favicon.ico"] {
        let answer = shore.page(path, "").await;
        let number: u64 = answer.headers["x-request-id"].to_str().unwrap().parse().unwrap();
        assert!(numbers.insert(number), "{path}: the log speaks of two requests by one number");
        let policy = answer.headers[header::CONTENT_SECURITY_POLICY].to_str().unwrap();
        assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{path}");
        assert_eq!(answer.headers[header::X_CONTENT_TYPE_OPTIONS], "nosniff", "{path}");
    }
    assert_eq!(shore.page("/api/v1/nowhere", "").await.status, StatusCode::NOT_FOUND);
}

#[tokio::test]
async fn pages_speak_what_the_browser_asks_for_until_the_person_chooses() {
    let shore = Shore::start().await;
    let norwegian = |path: &str, cookies: &str| {
        let wants = Request::get(path).header(header::ACCEPT_LANGUAGE, "nb-NO,nb;q=0.9,en;q=0.8");
        wants.header(header::COOKIE, cookies)
    };
    let login = shore.ask(norwegian("/login", ""), "").await.body;
    assert!(login.contains("<html lang=\"nb\"") && login.contains("<h1>Logg inn</h1>"), "{login}");
    assert!(shore.page("/login", "").await.body.contains("<h1>Log in</h1>"));
    let cookies = shore.admin().await;
    let account = shore.ask(norwegian("/account", &cookies), "").await;
    assert!(account.body.contains("<html lang=\"nb\"") && account.body.contains("Bytt passord"));

    let choose = async |language: &str| {
        let csrf = account.csrf();
        shore.form("/account/language", &cookies, &[("csrf", &csrf), ("language", language)]).await
    };
    assert_eq!(choose("en").await.headers[header::LOCATION], "/account?done=language");
    let english = shore.ask(norwegian("/account", &cookies), "").await.body;
    assert!(english.contains("<html lang=\"en\"") && english.contains("Change password"));
    choose("nb").await;
    let elsewhere = shore.login("admin", "nine grey otters").await.cookies();
    let chosen = shore.page("/account", &elsewhere).await.body;
    assert!(chosen.contains("<html lang=\"nb\"") && chosen.contains("value=\"nb\" lang=\"nb\" selected"));
    choose("").await;
    assert!(shore.page("/account", &cookies).await.body.contains("<html lang=\"en\""));
    let refused = choose("tlh").await;
    assert_eq!(refused.status, StatusCode::BAD_REQUEST);
    assert!(refused.body.contains("give en, nb or nothing"), "{}", refused.body);
}

#[tokio::test]
async fn what_is_refused_is_said_in_the_reader_s_language() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    let norwegian = |path: &str, cookies: &str| {
        let wants = Request::get(path).header(header::ACCEPT_LANGUAGE, "nb");
        wants.header(header::COOKIE, cookies)
    };
    for (path, heading) in [
        ("/nowhere", "<h1>Ikke funnet</h1>"),
        ("/plans/99", "<h1>Ikke funnet</h1>"),
        ("/vessels/otter", "<h1>Ikke funnet</h1>"),
    ] {
        let refused = shore.ask(norwegian(path, &cookies), "").await;
        assert!(refused.status.is_client_error(), "{path}: {}", refused.status);
        for part in ["<html lang=\"nb\"", heading, "Til flåten"] {
            assert!(refused.body.contains(part), "{path}: {part}: {}", refused.body);
        }
    }
    assert!(shore.ask(norwegian("/nowhere", ""), "").await.body.contains("Her er det ingenting."));
    assert!(shore.page("/nowhere", &cookies).await.body.contains("<h1>Not found</h1>"));

    let csrf = shore.page("/account", &cookies).await.csrf();
    shore.form("/account/language", &cookies, &[("csrf", &csrf), ("language", "nb")]).await;
    for path in ["/nowhere", "/plans/99"] {
        assert!(shore.page(path, &cookies).await.body.contains("<h1>Ikke funnet</h1>"), "{path}: as chosen");
    }
}

#[tokio::test]
async fn options_send_the_same_words_in_every_language() {
    let shore = Shore::start().await;
    let cookies = shore.admin().await;
    let values = |body: &str| -> Vec<String> {
        let options = body.split("<option").skip(1).map(|one| one.split("</option>").next().unwrap());
        let text = |one: &str| one.rsplit('>').next().unwrap().to_owned();
        let value =
            |one: &str| one.split("value=\"").nth(1).map(|rest| rest.split('"').next().unwrap().to_owned());
        options.map(|one| value(one).unwrap_or_else(|| text(one))).collect()
    };
    for path in ["/account", "/admin", "/admin/audit", "/alarms", "/data"] {
        let english = shore.page(path, &cookies).await.body;
        let norwegian =
            Request::get(path).header(header::COOKIE, &cookies).header(header::ACCEPT_LANGUAGE, "nb");
        let norwegian = shore.ask(norwegian, "").await.body;
        assert!(norwegian.contains("lang=\"nb\"") && values(&english).len() > 1, "{path}");
        assert_eq!(values(&english), values(&norwegian), "{path}");
    }
}
