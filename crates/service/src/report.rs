//! Findings of the programs' doctors, for people and for monitoring (Nagios, Icinga, Zabbix, a script).
//!
//! A code is a stable word for what was checked; texts are for people and may change. Several findings may have one code:
//! monitoring takes the worst. Values from a configuration are left out of the output for machines, which is often sent
//! by mail: [`masked`].

use serde_json::{Value, json};

/// How good something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// As it should be.
    Ok,
    /// It works, but an operator should look at it.
    Warn,
    /// It must be repaired.
    Fail,
}

impl Status {
    /// The word for machines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }

    /// The exit code for monitoring, by its convention: 0, 1, 2.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::Ok => 0,
            Self::Warn => 1,
            Self::Fail => 2,
        }
    }
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// What: words without figures, like `data folder`; machines get it with `_` for blanks.
    pub part: &'static str,
    /// How good it is.
    pub status: Status,
    /// The finding.
    pub text: String,
    /// The remedy; empty where none is needed, or the text has it.
    pub remedy: String,
}

impl Finding {
    /// A finding that needs no action.
    pub fn ok(part: &'static str, text: impl Into<String>) -> Self {
        Self { part, status: Status::Ok, text: text.into(), remedy: String::new() }
    }

    /// An operator should look at it.
    pub fn warn(part: &'static str, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { part, status: Status::Warn, text: text.into(), remedy: remedy.into() }
    }

    /// It must be repaired.
    pub fn fail(part: &'static str, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { part, status: Status::Fail, text: text.into(), remedy: remedy.into() }
    }
}

/// The worst of all; good where nothing was checked.
pub fn worst(findings: &[Finding]) -> Status {
    findings.iter().map(|finding| finding.status).max().unwrap_or(Status::Ok)
}

/// All of it as a JSON object. `time` is written as the program writes times.
pub fn to_json(program: &str, version: &str, time: &str, findings: &[Finding]) -> String {
    let one = |finding: &Finding| {
        let (text, remedy) = (masked_where_written(finding), &finding.remedy);
        json!({
            "code": finding.part.replace([' ', '-'], "_").to_lowercase(),
            "status": finding.status.name(),
            "text": text,
            "remedy": remedy,
        })
    };
    let checks: Vec<Value> = findings.iter().map(one).collect();
    let all = json!({
        "program": program,
        "version": version,
        "time": time,
        "status": worst(findings).name(),
        "checks": checks,
    });
    format!("{all:#}")
}

/// Of invalid settings the values are left out: a password may be in the wrong place.
fn masked_where_written(finding: &Finding) -> String {
    match (finding.part, finding.status) {
        ("configuration", Status::Warn | Status::Fail) => masked(&finding.text),
        _ => finding.text.clone(),
    }
}

/// A text without what it quotes of a file: lines that show a source, and what stands in quotes or backticks.
pub fn masked(text: &str) -> String {
    let shows_source = |line: &&str| {
        let rest = line.trim_start().trim_start_matches(|one: char| one.is_ascii_digit());
        rest.trim_start().starts_with('|')
    };
    let mut out = String::with_capacity(text.len());
    let mut until = None;
    for letter in text.lines().filter(|line| !shows_source(line)).flat_map(|line| line.chars().chain(['\n']))
    {
        match until {
            // A quote that is not ended ends with its line.
            Some(end) if letter == end || letter == '\n' => {
                until = None;
                out.push(letter);
            }
            Some(_) => {}
            None => {
                out.push(letter);
                if matches!(letter, '`' | '"') {
                    until = Some(letter);
                    out.push('…');
                }
            }
        }
    }
    out.trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(part: &'static str, status: Status, text: &str) -> Finding {
        Finding { part, status, text: text.to_owned(), remedy: String::new() }
    }

    #[test]
    fn the_worst_counts_and_codes_have_no_blanks() {
        let all = [
            finding("data folder", Status::Warn, "made at the first start"),
            finding("disk", Status::Ok, "500 MiB free"),
        ];
        let told: Value =
            serde_json::from_str(&to_json("lutra-x", "1.2.3", "2026-03-01 12:00:00Z", &all)).unwrap();
        assert_eq!(told["status"], "warn");
        assert_eq!(
            told["checks"][0],
            json!({"code": "data_folder", "status": "warn", "text": "made at the first start", "remedy": ""})
        );
        assert_eq!((worst(&all).exit_code(), worst(&[]).exit_code(), Status::Fail.exit_code()), (1, 0, 2));
    }

    #[test]
    fn what_somebody_wrote_into_a_configuration_is_left_out() {
        let text = "configuration a.toml: TOML parse error at line 3, column 1\n  |\n3 | tokn = \"hush\"\n  | ^^^^\nunknown field \
                    `hush`, \"hush";
        let found = [finding("configuration", Status::Fail, text)];
        let told = to_json("p", "1", "t", &found);
        assert!(!told.contains("hush") && told.contains("line 3, column 1"), "{told}");
    }
}
