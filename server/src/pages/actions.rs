//! What the audit log calls what people did, in words.

use super::words::word;

/// Codes and words, in the order in which they are offered.
pub(super) const ACTIONS: [(&str, &str); 50] = [
    ("vessel.abort", word("STOP")),
    ("plan.start", word("Start plan")),
    ("plan.stop", word("Stop plan")),
    ("goto", word("Go to")),
    ("teleop.begin", word("Begin steering by hand")),
    ("teleop.end", word("End steering by hand")),
    ("lease.take", word("Take control")),
    ("lease.request", word("Request control")),
    ("lease.grant", word("Grant control")),
    ("lease.granted", word("Control granted")),
    ("lease.decline", word("Decline control")),
    ("lease.unanswered", word("Control given, unanswered")),
    ("lease.release", word("Release control")),
    ("lease.expired", word("Control expired")),
    ("plan.create", word("Create plan")),
    ("plan.save", word("Save plan")),
    ("plan.duplicate", word("Duplicate plan")),
    ("plan.restore", word("Restore plan")),
    ("plan.import", word("Import plan")),
    ("plan.upload", word("Upload plan")),
    ("plan.delete", word("Delete plan")),
    ("parameters.query", word("Read parameters")),
    ("parameters.set", word("Set parameters")),
    ("parameters.save", word("Save parameters")),
    ("alarm.acknowledge", word("Acknowledge alarm")),
    ("alarm.shelve", word("Shelve alarm")),
    ("notice.rule.make", word("Ask for messages about alarms")),
    ("notice.rule.change", word("Change rule for messages")),
    ("notice.rule.remove", word("Remove rule for messages")),
    ("logbook.write", word("Write note")),
    ("logbook.correct", word("Correct note")),
    ("logbook.withdraw", word("Withdraw note")),
    ("logbook.photo", word("Add photo to note")),
    ("mission.create", word("Create mission")),
    ("mission.change", word("Change mission")),
    ("mission.withdraw", word("Withdraw mission")),
    ("log.import", word("Import log")),
    ("log.import.cancel", word("Cancel import")),
    ("login", word("Log in")),
    ("logout", word("Log out")),
    ("password.change", word("Change password")),
    ("person.add", word("Add person")),
    ("person.role", word("Change role")),
    ("person.password", word("Set one-time password")),
    ("person.remove", word("Remove person")),
    ("vessel.add", word("Name vessel")),
    ("vessel.remove", word("Forget vessel")),
    ("session.end", word("End session")),
    ("token.make", word("Make token")),
    ("token.revoke", word("Revoke token")),
];

/// An action in words; the code itself where there are none.
pub(super) fn words(code: &str) -> &str {
    ACTIONS.iter().find(|(known, _)| *known == code).map_or(code, |(_, words)| words)
}
