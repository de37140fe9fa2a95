//! `imc list`: finds messages.

use crate::info::meaning;
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use crate::style::Paint;
use crate::table::Table;
use imc::catalogue::{FieldDesc, MESSAGES, MessageDesc, VERSION, unit_name};
use serde_json::json;
use std::io::Write as _;

const EXAMPLES: &str = "\
Examples:
  imc list                 every message
  imc list salinity        what speaks of salinity, by message, summary or field
  imc list plan db         what speaks of both
  imc list rad/s           fields in radians per second
  imc list --json gps | jq .abbrev

Searched are ids, names, categories, summaries, and the names and units of fields; case does not matter.
Exit status 1 when nothing is found.";

/// Lists messages, all or those that speak of something.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct List {
    /// What to look for; of several words, all must be found
    #[arg(value_name = "TEXT")]
    words: Vec<String>,
    /// One JSON object a line for programs
    #[arg(long)]
    json: bool,
}

impl List {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let words: Vec<String> = self.words.iter().map(|word| word.to_lowercase()).collect();
        let mut table = Table::new(&[">id", "message", "meaning", "fields found"]);
        let mut found = 0;
        for message in MESSAGES {
            let Some(fields) = search(message, &words) else { continue };
            found += 1;
            if self.json {
                let names: Vec<&str> = fields.iter().map(|field| field.abbrev).collect();
                let line = json!({
                    "abbrev": message.abbrev, "id": message.id, "name": message.name,
                    "category": message.category, "summary": message.summary, "fields_found": names,
                });
                writeln!(out, "{line}")?;
            } else {
                let fields = fields.iter().map(|field| shown(field)).collect::<Vec<_>>().join(", ");
                table.row([message.id.to_string(), message.abbrev.to_owned(), meaning(message), fields]);
            }
        }
        if found == 0 {
            report::note(&format!("not found in any of the {} messages", MESSAGES.len()));
            return Ok(Outcome::Damaged);
        }
        if !self.json {
            let paint = Paint::stdout();
            write!(out, "{}", table.render(0, paint))?;
            let count = format!("{found} of {} messages of IMC {VERSION}", MESSAGES.len());
            writeln!(out, "{}", paint.aside(&count))?;
        }
        Ok(Outcome::Sound)
    }
}

/// The fields that mention one of the words; `None` when a word is not found at all.
fn search(message: &'static MessageDesc, words: &[String]) -> Option<Vec<&'static FieldDesc>> {
    let of_message = [message.abbrev, message.name, message.category, message.summary.unwrap_or_default()];
    let id = message.id.to_string();
    let mut found: Vec<&FieldDesc> = Vec::new();
    for word in words {
        let fields: Vec<&FieldDesc> = message.fields.iter().filter(|field| speaks(field, word)).collect();
        if fields.is_empty() && id != *word && !of_message.iter().any(|text| contains(text, word)) {
            return None;
        }
        found.extend(fields);
    }
    found.dedup_by_key(|field| field.abbrev);
    Some(found)
}

fn speaks(field: &FieldDesc, word: &str) -> bool {
    let unit = field.unit.unwrap_or_default();
    contains(field.abbrev, word)
        || contains(field.name, word)
        || unit.to_lowercase() == word
        || unit_name(unit).is_some_and(|name| contains(name, word))
}

fn contains(text: &str, word: &str) -> bool {
    text.to_lowercase().contains(word)
}

fn shown(field: &FieldDesc) -> String {
    match field.unit {
        Some(unit) => format!("{} ({unit})", field.abbrev),
        None => field.abbrev.to_owned(),
    }
}
