//! `web/src/api/types.gen.ts`, made from the types here and compared with the file that is committed.

use crate::{
    AuditEntry, Field, Fix, LiveFrame, LiveRequest, Liveness, Me, NewToken, Permission, Person, Recorded,
    Role, Session, Subscription, System, Token, TokenMade, TrackPoint, Update, Vessel,
};
use ts_rs::TS;

fn text() -> String {
    let declarations = [
        <AuditEntry as TS>::decl(),
        Field::decl(),
        Fix::decl(),
        LiveFrame::decl(),
        LiveRequest::decl(),
        Liveness::decl(),
        Me::decl(),
        NewToken::decl(),
        Permission::decl(),
        Person::decl(),
        Recorded::decl(),
        Role::decl(),
        Session::decl(),
        Subscription::decl(),
        System::decl(),
        Token::decl(),
        TokenMade::decl(),
        TrackPoint::decl(),
        Update::decl(),
        Vessel::decl(),
    ];
    let mut text = "// Made from crates/api by `make types`. Do not edit.\n".to_owned();
    for declaration in declarations {
        text.push_str("\nexport ");
        text.push_str(&declaration);
        text.push('\n');
    }
    text
}

#[test]
fn the_committed_types_are_these() {
    let path = testkit::repository().join("web/src/api/types.gen.ts");
    if std::env::var_os("LUTRA_WRITE_TYPES").is_some() {
        std::fs::write(&path, text()).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(committed, text(), "run `make types` and commit {}", path.display());
}
