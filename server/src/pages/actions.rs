//! What the audit log calls what people did, in words.

use super::words::word;

/// What may become of it, of an order each stage, and how that is said.
const STAGES: [(&str, &str); 11] = [
    ("done", word("done")),
    ("asked", word("asked")),
    ("accepted", word("accepted")),
    ("waiting", word("waiting")),
    ("sent", word("sent")),
    ("received", word("received by the vessel")),
    ("executing", word("executing")),
    ("effect seen", word("done")),
    ("refused", word("refused")),
    ("expired", word("expired")),
    ("timed out", word("timed out without an effect")),
];

/// A stage in words. An outcome that does not begin with a stage begins with a reason.
pub(super) fn stage(code: &str) -> Option<&'static str> {
    STAGES.iter().find(|(known, _)| *known == code).map(|(_, words)| *words)
}

/// Codes and words, in the order in which they are offered.
pub(super) const ACTIONS: [(&str, &str); 70] = [
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
    ("area.close", word("Close area")),
    ("area.change", word("Change no-go area")),
    ("area.lift", word("Lift no-go area")),
    ("register.create", word("Register something")),
    ("register.change", word("Change register")),
    ("register.delete", word("Delete from register")),
    ("register.import", word("Import register")),
    ("dataset.create", word("Make dataset")),
    ("dataset.change", word("Change dataset")),
    ("dataset.publish", word("Publish dataset")),
    ("dataset.version", word("Make new version of dataset")),
    ("dataset.withdraw", word("Withdraw dataset")),
    ("dataset.share", word("Make link to dataset")),
    ("dataset.share.revoke", word("Revoke link to dataset")),
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
    ("token.expire", word("End token")),
    ("fleet.apply", word("Set up fleet")),
    ("fleet.bundle", word("Make bundle for vessel")),
    ("fleet.rotate", word("Change keys of vessel")),
    ("fleet.revoke", word("Revoke access of vessel")),
    ("fleet.vpn", word("Make VPN key")),
];

/// An action in words; the code itself where there are none.
pub(super) fn words(code: &str) -> &str {
    ACTIONS.iter().find(|(known, _)| *known == code).map_or(code, |(_, words)| words)
}

#[cfg(test)]
mod tests {
    use super::ACTIONS;
    use std::collections::BTreeSet;
    use std::path::Path;

    /// Texts of the same shape that are not actions: kinds of messages, and a setting.
    const OTHERS: [&str; 3] = ["alarm.over", "alarm.raised", "log.level"];
    /// Endings of files.
    const FILES: [&str; 4] = [".html", ".ini", ".lock", ".toml"];

    /// All texts in quotation marks that begin with the family of a known action, as `token.` is one.
    fn said(folder: &Path, families: &BTreeSet<&str>, all: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy();
            if path.is_dir() {
                said(&path, families, all);
            } else if name.ends_with(".rs") && !name.contains("tests") {
                let text = std::fs::read_to_string(&path).unwrap();
                let pieces = text.split('"').filter(|piece| {
                    let mut letters = piece.chars();
                    letters.all(|letter| letter.is_ascii_lowercase() || letter == '.')
                        && piece.split_once('.').is_some_and(|(family, _)| families.contains(family))
                        && !FILES.iter().any(|ending| piece.ends_with(ending))
                });
                all.extend(pieces.map(str::to_owned));
            }
        }
    }

    #[test]
    fn each_action_that_comes_into_the_audit_log_has_words() {
        let families = ACTIONS.iter().filter_map(|(code, _)| Some(code.split_once('.')?.0)).collect();
        let server = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut all = BTreeSet::new();
        said(&server.join("src"), &families, &mut all);
        said(&server.join("../shore/src"), &families, &mut all);
        let known: BTreeSet<_> = ACTIONS.iter().map(|(code, _)| *code).chain(OTHERS).collect();
        let without: Vec<_> = all.iter().filter(|code| !known.contains(code.as_str())).collect();
        assert!(without.is_empty(), "no words for {without:?}");
        assert!(all.len() > 50, "only {} were found", all.len());
    }
}
