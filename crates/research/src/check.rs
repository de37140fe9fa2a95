//! Errors of entries: each alone, and all of them together.

use crate::column::{NAME_LETTERS, Rule, Slot, shown};
use crate::fields::{columns, kind_of, kind_said, maker_of, name_of, slots};
use api::{
    RegisterAnimal, RegisterDeployment, RegisterKind, RegisterReceiver, RegisterRecord, RegisterTag, Wording,
    say,
};
use std::collections::BTreeMap;
use units::UtcTime;

/// What is wrong with an entry.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Which of the entries.
    pub entry: usize,
    /// Which field.
    pub column: &'static str,
    /// What, and what to do.
    pub text: Wording,
    /// Another one of the entries, which the text names.
    pub other: Option<usize>,
}

/// Faults up to which similar names are searched for, which takes long.
const SUGGESTIONS: usize = 20;

/// Trims the texts of an entry and gives it a name where it may have none; then all that is wrong with it by itself, as field
/// and text.
pub fn check(record: &mut RegisterRecord) -> Vec<(&'static str, Wording)> {
    let mut wrong = Vec::new();
    let fields = columns(kind_of(record));
    for slot in slots(record) {
        if let Slot::Text(text) = slot {
            let trimmed = text.replace("\r\n", "\n").trim().to_owned();
            *text = trimmed;
        }
    }
    name(record);
    for (column, slot) in fields.iter().zip(slots(record)) {
        if column.needed && slot.is_empty() {
            wrong.push((column.name, say("empty; write {about}").with_said("about", column.meaning())));
        } else if let Some(text) = column.rule.wrong(&slot) {
            wrong.push((column.name, text));
        }
    }
    wrong.extend(pairs(record));
    wrong
}

/// All that is wrong with entries together: names that are taken, references to nothing, spans that overlap.
pub fn check_all(records: &[RegisterRecord]) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut named: BTreeMap<(RegisterKind, String), usize> = BTreeMap::new();
    for (entry, record) in records.iter().enumerate() {
        let kind = kind_of(record);
        if named.insert((kind, folded(name_of(record))), entry).is_some() {
            let text = name_taken(kind, name_of(record));
            faults.push(Fault { entry, column: "name", text, other: None });
        }
    }
    for (entry, record) in records.iter().enumerate() {
        references(entry, record, &named, records, &mut faults);
    }
    serials(records, &mut faults);
    tags_apart(records, &mut faults);
    deployments_apart(records, &mut faults);
    faults.sort_by_key(|fault| fault.entry);
    faults
}

/// Names are the same in whatever case they are written.
pub(crate) fn folded(name: &str) -> String {
    name.trim().to_lowercase()
}

/// Another entry of the kind has this name.
pub fn name_taken(kind: RegisterKind, name: &str) -> Wording {
    let text = say("another {kind} is called `{name}`; choose another name");
    text.with_said("kind", kind_said(kind)).with("name", name)
}

/// A name where people gave none.
fn name(record: &mut RegisterRecord) {
    let made = match &*record {
        RegisterRecord::Tag(RegisterTag { name, protocol, tag_id: Some(id), .. }) if name.is_empty() => {
            format!("{protocol}-{id}")
        }
        RegisterRecord::Receiver(RegisterReceiver { name, model, serial: Some(serial), .. })
            if name.is_empty() =>
        {
            let model = if model.is_empty() { "receiver" } else { model };
            format!("{model}-{serial}")
        }
        RegisterRecord::Deployment(RegisterDeployment { name, receiver, from_us: Some(from_us), .. })
            if name.is_empty() =>
        {
            let begin: String = UtcTime::from_micros(*from_us).to_string().chars().take(16).collect();
            format!("{receiver} {begin}Z")
        }
        _ => return,
    };
    let made: String = made.chars().take(NAME_LETTERS).collect();
    if let Some(Slot::Text(name)) = slots(record).into_iter().next() {
        *name = made;
    }
}

/// Fields that belong together.
fn pairs(record: &RegisterRecord) -> Vec<(&'static str, Wording)> {
    let mut wrong = Vec::new();
    match record {
        RegisterRecord::Animal(RegisterAnimal {
            capture_us,
            release_us,
            capture_lat_deg,
            capture_lon_deg,
            release_lat_deg,
            release_lon_deg,
            ..
        }) => {
            for (column, one, other) in [
                ("capture_lat_deg", capture_lat_deg, capture_lon_deg),
                ("release_lat_deg", release_lat_deg, release_lon_deg),
            ] {
                if one.is_some() != other.is_some() {
                    wrong.push((column, say("a place has latitude and longitude: give both or neither")));
                }
            }
            if capture_us.zip(*release_us).is_some_and(|(capture, release)| release < capture) {
                wrong.push(("release_time", say("is before capture_time; look at both")));
            }
        }
        RegisterRecord::Tag(RegisterTag {
            interval_min_s,
            interval_max_s,
            from_us,
            to_us,
            sensor_slope,
            sensor_intercept,
            ..
        }) => {
            if interval_min_s.zip(*interval_max_s).is_some_and(|(least, most)| most < least) {
                wrong.push(("interval_max_s", say("is less than interval_min_s; look at both")));
            }
            if sensor_slope.is_none() && sensor_intercept.is_some() {
                wrong.push(("sensor_slope", say("empty beside sensor_intercept; give both")));
            }
            wrong.extend(order(*from_us, *to_us));
        }
        RegisterRecord::Deployment(RegisterDeployment { from_us, to_us, lat_deg, lon_deg, .. }) => {
            if lat_deg.is_some() != lon_deg.is_some() {
                wrong.push(("lat_deg", say("a place has latitude and longitude: give both or neither")));
            }
            wrong.extend(order(*from_us, *to_us));
        }
        RegisterRecord::Project(_) | RegisterRecord::Person(_) | RegisterRecord::Receiver(_) => {}
    }
    wrong
}

fn order(from_us: Option<i64>, to_us: Option<i64>) -> Option<(&'static str, Wording)> {
    let wrong = from_us.zip(to_us).is_some_and(|(from, to)| to <= from);
    wrong.then(|| ("to_time", say("is not after from_time; look at both")))
}

/// Names of other entries must be those of some.
fn references(
    entry: usize,
    record: &RegisterRecord,
    named: &BTreeMap<(RegisterKind, String), usize>,
    records: &[RegisterRecord],
    faults: &mut Vec<Fault>,
) {
    let mut record = record.clone();
    for (column, slot) in columns(kind_of(&record)).iter().zip(slots(&mut record)) {
        let (Rule::Name(kind), Slot::Text(name)) = (column.rule, slot) else { continue };
        if name.is_empty() || named.contains_key(&(kind, folded(name))) {
            continue;
        }
        let known = records.iter().filter(|one| kind_of(one) == kind).map(name_of);
        let alike = if faults.len() < SUGGESTIONS { suggest::alike(name, known) } else { Vec::new() };
        let remedy = match alike.as_slice() {
            [] => say("register the {kind} first, or leave this empty").with_said("kind", kind_said(kind)),
            names => say("did you mean `{names}`?").with("names", names.join("` or `")),
        };
        let text = say("no {kind} is called `{name}`; {remedy}")
            .with_said("kind", kind_said(kind))
            .with("name", shown(name))
            .with_said("remedy", remedy);
        faults.push(Fault { entry, column: column.name, text, other: None });
    }
}

/// A serial number is a maker's own: two makers may give the same one.
fn serials(records: &[RegisterRecord], faults: &mut Vec<Fault>) {
    let mut known: BTreeMap<i64, Vec<&RegisterReceiver>> = BTreeMap::new();
    for (entry, record) in records.iter().enumerate() {
        let RegisterRecord::Receiver(receiver) = record else { continue };
        let Some(serial) = receiver.serial else { continue };
        let same = known.entry(serial).or_default();
        let maker = maker_of(receiver);
        let other =
            same.iter().find(|other| maker.zip(maker_of(other)).is_none_or(|(one, other)| one == other));
        if let Some(other) = other {
            let text = say("{serial} is the serial number of `{other}` already; look at both, or give the manufacturer of each where they differ")
                .with("serial", serial)
                .with("other", &other.name);
            faults.push(Fault { entry, column: "serial", text, other: None });
        }
        same.push(receiver);
    }
}

/// From when to when something holds, and which entry says so.
type Span<'r> = (i64, i64, usize, &'r str);

/// The same on a carrier (kHz), or on any.
type OnCarrier<'r> = (Span<'r>, Option<i64>);

/// A code is one tag at a time.
fn tags_apart(records: &[RegisterRecord], faults: &mut Vec<Fault>) {
    let mut by_code: BTreeMap<(String, i64), Vec<OnCarrier<'_>>> = BTreeMap::new();
    for (entry, record) in records.iter().enumerate() {
        let RegisterRecord::Tag(tag) = record else { continue };
        let Some(id) = tag.tag_id else { continue };
        let span = (tag.from_us.unwrap_or(i64::MIN), tag.to_us.unwrap_or(i64::MAX), entry, &*tag.name);
        by_code.entry((folded(&tag.protocol), id)).or_default().push((span, tag.frequency_khz));
    }
    for ((_, id), spans) in by_code {
        for (at, (span, frequency)) in spans.iter().enumerate() {
            let same = |other: &Option<i64>| frequency.is_none() || other.is_none() || frequency == other;
            let other = spans[..at].iter().find(|(other, khz)| same(khz) && overlap(*other, *span));
            if let Some(((_, _, _, name), _)) = other {
                let text = say("the tag `{name}` has this protocol and number ({id}) at the same time; end one by to_time before the other begins").with("name", name).with("id", id);
                faults.push(Fault { entry: span.2, column: "from_time", text, other: None });
            }
        }
    }
}

/// A receiver is on one vessel at a time.
fn deployments_apart(records: &[RegisterRecord], faults: &mut Vec<Fault>) {
    let mut by_receiver: BTreeMap<String, Vec<Span<'_>>> = BTreeMap::new();
    for (entry, record) in records.iter().enumerate() {
        let RegisterRecord::Deployment(one) = record else { continue };
        let span = (one.from_us.unwrap_or(i64::MIN), one.to_us.unwrap_or(i64::MAX), entry, &*one.name);
        by_receiver.entry(folded(&one.receiver)).or_default().push(span);
    }
    for spans in by_receiver.into_values() {
        for (at, span) in spans.iter().enumerate() {
            if let Some((_, _, other, name)) = spans[..at].iter().find(|other| overlap(**other, *span)) {
                let text = say("the receiver is deployed as `{name}` at the same time; end that by to_time before this begins").with("name", name);
                faults.push(Fault { entry: span.2, column: "from_time", text, other: Some(*other) });
            }
        }
    }
}

fn overlap(one: Span<'_>, other: Span<'_>) -> bool {
    one.0 < other.1 && other.0 < one.1
}

#[cfg(test)]
mod tests;
