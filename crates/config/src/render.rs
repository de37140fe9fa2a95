//! Writes the schema as a complete, commented configuration: the defaults, and where an Otter needs another
//! value, that one with the default named beside it.

use std::fmt::Write as _;

use crate::ini::{Unwritable, write_setting};
use crate::read::{allowed_values, default};
use crate::schema::common::{ENABLED, ENTITY_LABEL, OF_EVERY_TASK};
use crate::schema::{SECTIONS, not_honoured, otter_value};
use crate::spec::{Form, Kind, ParamSpec, SectionSpec};

/// How wide comments are.
const WIDTH: usize = 100;
/// Items of a list per line.
const LONG_LIST: usize = 90;

/// What a generated configuration is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vessel {
    /// The vessel's name.
    pub name: String,
    /// Its IMC address.
    pub address: u16,
}

impl Default for Vessel {
    fn default() -> Self {
        Self { name: "ntnu-otter-01".to_owned(), address: 0x2810 }
    }
}

/// The schema as a documented `.ini` file: every section and parameter that Lutra obeys with its documentation, unit, range
/// and default, or the Otter's value ([`OTTER_VALUES`](crate::schema::OTTER_VALUES)). Two instances are written of what an Otter has two of.
///
/// # Errors
/// When the vessel's name cannot be written.
pub fn documented_ini(vessel: &Vessel) -> Result<String, Unwritable> {
    let mut text = String::new();
    comment(&mut text, "Complete configuration of an Otter for lutra-agent, generated from its schema.");
    comment(
        &mut text,
        "The format is DUNE's. `#` and `;` begin comments, also behind a value; lists go on in the next \
         line. Assignments override earlier ones: keep what is common in one file, begin the file of a \
         vessel with [Require that-file.ini] and write below it only what differs.",
    );
    // A task that is not there needs no section.
    for spec in SECTIONS.iter().filter(|spec| not_honoured(spec.name(), ENABLED.spec.name).is_none()) {
        match spec.form {
            Form::OpenData(_) => open_data(&mut text, spec, vessel)?,
            Form::DataFor { example } => {
                section(&mut text, spec, &format!("{}{example}", spec.name()), vessel)?;
            }
            Form::Task { .. } if spec.name() == "Simulators.Motor" => {
                section(&mut text, spec, "Simulators.Motor/Port", vessel)?;
                section(&mut text, spec, "Simulators.Motor/Starboard", vessel)?;
            }
            Form::Data | Form::Task { .. } => section(&mut text, spec, spec.name(), vessel)?,
        }
    }
    Ok(text)
}

/// Whether a parameter is written in its section: not so the options of every task but for two.
fn is_written(param: &ParamSpec) -> bool {
    let common = OF_EVERY_TASK.contains(param);
    let written = [ENABLED.spec.name, ENTITY_LABEL.spec.name].contains(&param.name);
    param.kind != Kind::Unused && (written || !common)
}

fn open_data(text: &mut String, spec: &SectionSpec, vessel: &Vessel) -> Result<(), Unwritable> {
    heading(text, spec, spec.name());
    if spec.name() == "IMC Addresses" {
        write_setting(text, spec.name(), &vessel.name, &format!("{:#06x}", vessel.address))?;
    } else {
        comment(text, "Bench = hardware on the bench with a simulated hull");
    }
    Ok(())
}

fn section(text: &mut String, spec: &SectionSpec, name: &str, vessel: &Vessel) -> Result<(), Unwritable> {
    heading(text, spec, name);
    let starboard = name.ends_with("/Starboard");
    let obeyed = |param: &&ParamSpec| not_honoured(spec.name(), param.name).is_none();
    for param in spec.params().filter(|param| is_written(param)).filter(obeyed) {
        comment(text, &documentation(param));
        if param.is_repeated() {
            for key in param.keys() {
                match otter_value(spec.name(), &key) {
                    Some(value) => write_setting(text, spec.name(), &key, value)?,
                    None => comment(text, &format!("{key} =")),
                }
            }
            continue;
        }
        let usual = default(&param.kind).map(|value| value.to_string()).unwrap_or_default();
        let otter = otter_value(spec.name(), param.name);
        if otter.is_some() {
            comment(text, &format!("An Otter's value; the default is {usual}."));
        }
        let value = match (param.name, spec.form) {
            ("Enabled", Form::Task { enabled, .. }) => enabled.to_owned(),
            ("Entity Label", Form::Task { .. }) if starboard => "Motor 1".to_owned(),
            ("Entity Label", Form::Task { label, .. }) => label.to_owned(),
            ("Vehicle", _) => vessel.name.clone(),
            ("Thruster Id", _) if starboard => "1".to_owned(),
            _ => otter.map_or(usual, str::to_owned),
        };
        setting(text, name, param.name, &value)?;
    }
    Ok(())
}

fn heading(text: &mut String, spec: &SectionSpec, name: &str) {
    let _ = writeln!(text, "\n{}", "#".repeat(WIDTH));
    comment(text, spec.doc);
    if spec.names.len() > 1 {
        comment(text, &format!("Also read under the names {}.", spec.names[1..].join(", ")));
    }
    let _ = writeln!(text, "[{name}]");
}

fn documentation(param: &ParamSpec) -> String {
    let mut text = param.doc.to_owned();
    match allowed_values(param) {
        Some(allowed) => {
            let _ = write!(text, " ({allowed})");
        }
        None if !param.unit.symbol().is_empty() => {
            let _ = write!(text, " (in {})", param.unit);
        }
        None => {}
    }
    text
}

/// Writes a setting, a long list one item a line.
fn setting(text: &mut String, section: &str, key: &str, value: &str) -> Result<(), Unwritable> {
    if value.len() <= LONG_LIST {
        return write_setting(text, section, key, value);
    }
    let mut items = value.split(", ");
    let _ = write!(text, "{key} = {}", items.next().unwrap_or_default());
    for item in items {
        let _ = write!(text, ",\n    {item}");
    }
    text.push('\n');
    Ok(())
}

/// Writes a comment, broken at blanks.
fn comment(text: &mut String, words: &str) {
    let mut line = "#".to_owned();
    for word in words.split_whitespace() {
        if line.len() + 1 + word.len() > WIDTH {
            let _ = writeln!(text, "{line}");
            "#".clone_into(&mut line);
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(text, "{line}");
}
