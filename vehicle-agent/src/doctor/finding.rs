//! What was found, for people and for programs.

use crate::say::say;
use serde_json::{Value, json};

/// How good something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Verdict {
    /// As it should be.
    Good,
    /// The vessel sails, and somebody should look at it.
    Doubt,
    /// It must be mended before the vessel sails.
    Bad,
}

impl Verdict {
    const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Doubt => "doubt",
            Self::Bad => "bad",
        }
    }
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Finding {
    /// What was looked at.
    pub(crate) part: &'static str,
    /// How good it is.
    pub(crate) verdict: Verdict,
    /// What was seen.
    pub(crate) text: String,
    /// What to do; empty where nothing is to be done, or the text says it.
    pub(crate) remedy: String,
}

impl Finding {
    /// Nothing is to be done.
    pub(crate) fn good(part: &'static str, text: impl Into<String>) -> Self {
        Self { part, verdict: Verdict::Good, text: text.into(), remedy: String::new() }
    }

    /// Somebody should look at it.
    pub(crate) fn doubt(part: &'static str, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { part, verdict: Verdict::Doubt, text: text.into(), remedy: remedy.into() }
    }

    /// It must be mended.
    pub(crate) fn bad(part: &'static str, text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { part, verdict: Verdict::Bad, text: text.into(), remedy: remedy.into() }
    }

    fn to_json(&self) -> Value {
        json!({"part": self.part, "verdict": self.verdict.name(), "text": self.text, "remedy": self.remedy})
    }
}

/// Prints all; answers the worst.
pub(crate) fn print(findings: &[Finding], json: bool) -> Verdict {
    let worst = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Good);
    if json {
        let all: Vec<Value> = findings.iter().map(Finding::to_json).collect();
        say!("{:#}", json!({"verdict": worst.name(), "findings": all}));
        return worst;
    }
    for Finding { part, verdict, text, remedy } in findings {
        say!("{:5}  {part}: {text}", verdict.name());
        if !remedy.is_empty() {
            say!("       -> {remedy}");
        }
    }
    let count = |wanted| findings.iter().filter(|finding| finding.verdict == wanted).count();
    say!("{} bad, {} in doubt, {} good", count(Verdict::Bad), count(Verdict::Doubt), count(Verdict::Good));
    worst
}
