//! Names of messages and fields on the command line: known, or with the one that was meant.

use anyhow::{Context as _, bail};
use imc::catalogue::{MESSAGES, by_abbrev};
use store::Reader;
use suggest::nearest;

/// What the catalogue does not explain is asked for by this name.
const RAW: &str = "_raw";

/// Looks whether there are such messages, and fields of them.
///
/// # Errors
/// There is none; the error names the nearest.
pub(super) fn known(reader: &Reader, messages: &[String], fields: &[String]) -> anyhow::Result<()> {
    for name in messages {
        if by_abbrev(name).is_none() && name != RAW {
            let abbrevs = MESSAGES.iter().map(|desc| desc.abbrev);
            bail!(
                "IMC has no message `{name}`; {}",
                meant(nearest(name, abbrevs), "`imc list` tells them all")
            );
        }
    }
    if messages.iter().any(|name| name == RAW) {
        return Ok(());
    }
    fields.iter().try_for_each(|wanted| field(reader, messages, wanted))
}

fn field(reader: &Reader, messages: &[String], wanted: &str) -> anyhow::Result<()> {
    let (message, name) =
        wanted.split_once('.').map_or((None, wanted), |(message, name)| (Some(message), name));
    let asked: Vec<&str> = match message {
        Some(message) => {
            known(reader, &[message.to_owned()], &[]).with_context(|| format!("--field {wanted}"))?;
            vec![message]
        }
        None if messages.is_empty() => MESSAGES.iter().map(|desc| desc.abbrev).collect(),
        None => messages.iter().map(String::as_str).collect(),
    };
    let mut columns = Vec::new();
    for message in &asked {
        columns.extend(reader.table(message)?.columns.iter().map(|column| column.name));
    }
    if columns.contains(&name) {
        return Ok(());
    }
    let of = match asked.as_slice() {
        [one] => (*one).to_owned(),
        _ if messages.is_empty() => "IMC".to_owned(),
        several => format!("none of {}", several.join(", ")),
    };
    let no = if of.starts_with("none") { "has a" } else { "has no" };
    columns.sort_unstable();
    columns.dedup();
    let remedy = match asked.len() {
        1 => format!("it has {}", columns.join(", ")),
        _ => "`imc info MESSAGE` tells a message's fields".to_owned(),
    };
    bail!("{of} {no} field `{name}`; {}", meant(nearest(name, columns.into_iter()), &remedy));
}

fn meant(nearest: Option<&str>, otherwise: &str) -> String {
    nearest.map_or_else(|| otherwise.to_owned(), |nearest| format!("did you mean `{nearest}`?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(messages: &[&str], fields: &[&str]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let reader = Reader::open(folder.path()).unwrap();
        let [messages, fields] =
            [messages, fields].map(|names| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
        known(&reader, &messages, &fields).map_or_else(|error| format!("{error:#}"), |()| String::new())
    }

    #[test]
    fn a_slip_of_the_finger_is_told_with_what_was_meant() {
        assert_eq!(
            told(&["EstimatdState"], &[]),
            "IMC has no message `EstimatdState`; did you mean `EstimatedState`?"
        );
        assert_eq!(
            told(&["Temperature"], &["vlaue"]),
            "Temperature has no field `vlaue`; did you mean `value`?"
        );
        let told_two = told(&["Temperature", "Voltage"], &["valeu"]);
        assert_eq!(told_two, "none of Temperature, Voltage has a field `valeu`; did you mean `value`?");
        assert_eq!(told(&[], &["EulerAngles.pssi"]), "EulerAngles has no field `pssi`; did you mean `psi`?");
        let nested = told(&[], &["EulerAngle.psi"]);
        assert!(nested.ends_with("did you mean `EulerAngles`?"), "{nested}");
        assert_eq!(told(&["Temperature"], &["zzz"]), "Temperature has no field `zzz`; it has value");
    }

    #[test]
    fn what_is_known_passes() {
        assert_eq!(told(&["EstimatedState", "TBRFishTag"], &["psi", "EstimatedState.true_lat_deg"]), "");
        assert_eq!(told(&[], &["SNR"]), "");
        assert_eq!(told(&["_raw"], &["payload"]), "");
    }
}
