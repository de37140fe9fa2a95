//! Prints findings for people and programs.

use crate::clock::Clock;
use crate::say::say;
pub(crate) use service::report::{Finding, Status};
use service::report::{to_json, worst};

/// The word for people.
const fn word(status: Status) -> &'static str {
    match status {
        Status::Ok => "good",
        Status::Warn => "doubt",
        Status::Fail => "bad",
    }
}

/// Prints all; returns the worst status.
pub(crate) fn print(findings: &[Finding], json: bool) -> Status {
    let worst = worst(findings);
    if json {
        let now = Clock::system().utc().to_string();
        say!("{}", to_json("lutra-agent", env!("CARGO_PKG_VERSION"), &now, findings));
        return worst;
    }
    for Finding { part, status, text, remedy } in findings {
        say!("{:5}  {part}: {text}", word(*status));
        if !remedy.is_empty() {
            say!("       -> {remedy}");
        }
    }
    let count = |wanted| findings.iter().filter(|finding| finding.status == wanted).count();
    say!("{} bad, {} in doubt, {} good", count(Status::Fail), count(Status::Warn), count(Status::Ok));
    worst
}
