//! What the audit log calls what people did, in words.

/// Codes and words, in the order in which they are offered.
pub(super) const ACTIONS: [(&str, &str); 40] = [
    ("vessel.abort", "STOP"),
    ("plan.start", "Start plan"),
    ("plan.stop", "Stop plan"),
    ("goto", "Go to"),
    ("teleop.begin", "Begin steering by hand"),
    ("teleop.end", "End steering by hand"),
    ("lease.take", "Take control"),
    ("lease.request", "Request control"),
    ("lease.grant", "Grant control"),
    ("lease.granted", "Control granted"),
    ("lease.decline", "Decline control"),
    ("lease.unanswered", "Control given, unanswered"),
    ("lease.release", "Release control"),
    ("lease.expired", "Control expired"),
    ("plan.create", "Create plan"),
    ("plan.save", "Save plan"),
    ("plan.duplicate", "Duplicate plan"),
    ("plan.restore", "Restore plan"),
    ("plan.import", "Import plan"),
    ("plan.upload", "Upload plan"),
    ("plan.delete", "Delete plan"),
    ("parameters.query", "Read parameters"),
    ("parameters.set", "Set parameters"),
    ("parameters.save", "Save parameters"),
    ("alarm.acknowledge", "Acknowledge alarm"),
    ("alarm.shelve", "Shelve alarm"),
    ("log.import", "Import log"),
    ("log.import.cancel", "Cancel import"),
    ("login", "Log in"),
    ("logout", "Log out"),
    ("password.change", "Change password"),
    ("person.add", "Add person"),
    ("person.role", "Change role"),
    ("person.password", "Set one-time password"),
    ("person.remove", "Remove person"),
    ("vessel.add", "Name vessel"),
    ("vessel.remove", "Forget vessel"),
    ("session.end", "End session"),
    ("token.make", "Make token"),
    ("token.revoke", "Revoke token"),
];

/// An action in words; the code itself where there are none.
pub(super) fn words(code: &str) -> &str {
    ACTIONS.iter().find(|(known, _)| *known == code).map_or(code, |(_, words)| words)
}
