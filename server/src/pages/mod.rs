//! Pages for people, made on the server; they work without scripts, except for what moves.

mod account;
mod actions;
mod admin;
mod alarms;
mod areas;
mod data;
mod datasets;
mod detections;
mod explore;
mod fleet;
mod form;
mod frame;
mod help;
mod logbook;
mod login;
mod missions;
mod notices;
mod plans;
mod register;
mod rows;
mod rules;
mod share;
mod style;
mod vessel;
mod words;

pub(crate) use frame::refusal;
pub(crate) use help::Manual;

use crate::AppState;
use crate::web::{Need, Route};
use api::Role;
use shore::identity::Principal;
use std::collections::BTreeMap;

/// All pages and forms.
pub(crate) fn routes() -> Vec<Route> {
    let admin = Need::Everywhere(Role::Admin);
    vec![
        Route::page("/", Need::Somewhere(Role::Viewer), "The fleet.", fleet::page),
        Route::page("/vessels/{vessel}", Need::OnVessel(Role::Viewer), "One vessel.", vessel::page),
        Route::page("/plans", Need::Somewhere(Role::Viewer), "Plans.", plans::list),
        Route::page("/plans/{id}", Need::Somewhere(Role::Viewer), "One plan, to be edited.", plans::editor),
        Route::page("/no-go-areas", Need::Somewhere(Role::Viewer), "No-go areas.", areas::page),
        Route::page(
            "/offline",
            Need::Anyone,
            "What is shown while the server is not reached.",
            frame::offline,
        ),
        Route::page("/detections", Need::Somewhere(Role::Viewer), "Tags heard.", detections::page),
        Route::page("/explore", Need::Somewhere(Role::Viewer), "Detections in plots.", explore::page),
        Route::page("/alarms", Need::Somewhere(Role::Viewer), "What happened to alarms.", alarms::page),
        Route::page("/logbook", Need::Somewhere(Role::Viewer), "Notes by people.", logbook::page),
        Route::page("/missions", Need::Somewhere(Role::Viewer), "Missions.", missions::list),
        Route::page("/missions/{id}", Need::Somewhere(Role::Viewer), "One mission.", missions::one),
        Route::page("/data", Need::Somewhere(Role::Viewer), "Recordings and files of them.", data::page),
        Route::page(
            "/register",
            Need::Somewhere(Role::Viewer),
            "Tags, animals and receivers.",
            register::page,
        ),
        Route::page("/datasets", Need::Somewhere(Role::Viewer), "Datasets.", datasets::list),
        Route::page("/datasets/{id}", Need::Somewhere(Role::Viewer), "One dataset.", datasets::one),
        Route::page("/shared", Need::Account, "What is shared with one's account.", share::shared),
        Route::page("/s/{token}", Need::Anyone, "What a link gives.", share::page),
        Route::form("/s/{token}", Need::Anyone, "Open a link by its password.", share::unlock),
        Route::page("/style", Need::Somewhere(Role::Viewer), "What pages are made of.", style::page),
        // The manual says nothing of this fleet. Who cannot log in needs it most, and who reaches the login may read it.
        Route::page("/help", Need::Anyone, "The manual, and its search.", help::first),
        Route::page("/help/{chapter}", Need::Anyone, "A chapter of the manual.", help::chapter),
        Route::page("/help/pictures/{name}", Need::Anyone, "A picture of the manual.", help::picture),
        Route::page("/login", Need::Anyone, "The login.", login::page),
        Route::form("/login", Need::Anyone, "Log in.", login::login),
        Route::form("/logout", Need::Session, "Log out.", login::logout),
        Route::form("/palette", Need::Anyone, "Choose sun, day, dusk or night.", frame::choose_palette),
        Route::page("/account", Need::Session, "Password, messages, sessions and tokens.", account::page),
        Route::form("/account/password", Need::Session, "Change the password.", account::password),
        Route::form(
            "/account/language",
            Need::Session,
            "Choose the language of the pages.",
            account::language,
        ),
        Route::form("/account/session/end", Need::Session, "End a session.", account::session_end),
        Route::form("/account/token", Need::Account, "Make a token.", account::token_make),
        Route::form("/account/token/revoke", Need::Session, "Revoke a token.", account::token_revoke),
        Route::form("/account/notice", Need::Somewhere(Role::Viewer), "Ask for messages.", notices::add),
        Route::form(
            "/account/notice/change",
            Need::Somewhere(Role::Viewer),
            "Change a rule.",
            notices::change,
        ),
        Route::form("/account/notice/test", Need::Somewhere(Role::Viewer), "Try a rule.", notices::test),
        Route::form("/account/notice/remove", Need::Session, "Remove a rule.", notices::remove),
        Route::page("/admin", admin, "People.", admin::people::page),
        Route::form("/admin/person", admin, "Add a person.", admin::people::add),
        Route::form("/admin/person/role", admin, "Give or take a role.", admin::people::role),
        Route::form("/admin/person/password", admin, "Set a one-time password.", admin::people::password),
        Route::form("/admin/person/remove", admin, "Remove a person.", admin::people::remove),
        Route::page("/admin/vessels", admin, "Vessels.", admin::vessels::page),
        Route::form("/admin/vessel", admin, "Name a vessel.", admin::vessels::add),
        Route::form("/admin/vessel/remove", admin, "Forget a vessel.", admin::vessels::remove),
        Route::form("/admin/vessel/token", admin, "Make a link token.", admin::vessels::token),
        Route::page("/admin/connections", admin, "Connections.", admin::connections::page),
        Route::page("/admin/storage", admin, "Storage.", admin::storage::page),
        Route::page("/admin/import", admin, "Bring logs in.", admin::import::page),
        Route::page("/admin/tokens", admin, "Tokens.", admin::access::tokens),
        Route::form("/admin/token/revoke", admin, "Revoke a token.", admin::access::token_revoke),
        Route::page("/admin/sessions", admin, "Sessions.", admin::access::sessions),
        Route::form("/admin/session/end", admin, "End a session.", admin::access::session_end),
        Route::page("/admin/audit", admin, "Audit log.", admin::access::audit),
    ]
}

/// The names that people gave to the vessels that `who` may see, by address.
fn names_for(state: &AppState, who: &Principal) -> BTreeMap<u16, String> {
    let named = state.shore.people.vessels();
    let seen = named.iter().filter(|vessel| who.grants.on(vessel.address).is_some());
    seen.map(|vessel| (vessel.address, vessel.name.clone())).collect()
}
