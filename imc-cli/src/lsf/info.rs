//! `imc lsf info`: what is in a log.

use super::names::label_or_number;
use super::scan::{Printing, log_file, scan};
use super::select::Select;
use super::shown::iso;
use super::tally::{Count, Sender, Tally};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report::counted;
use crate::style::{Paint, plain};
use crate::table::Table;
use imc::catalogue;
use imc::lsf::LogItem;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  imc lsf info Data.lsf.gz
  imc lsf info Data.lsf.gz --entities               every entity on a line of its own
  imc lsf info Data.lsf.gz -m GpsFix --from +60      of the chosen packets only
  imc lsf info --json logs/*/Data.lsf.gz | jq '[.file, .packets, .span_s]'

Times are the senders'. The span is from the first packet of the log to the latest time; messages from \
before it, which a vehicle remembers and repeats at the start of a log, are mentioned. Rates are counts \
divided by the span. Names of entities are those that the log tells (EntityInfo, EntityList).
Exit status 1 when anything was damaged.";

/// Entities named in one cell.
const NAMED: usize = 3;

/// Shows time span, sources, counts and rates per message and entity, and damage.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Info {
    /// Logs, or their folders
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    select: Select,
    /// One line for each entity that sends a message
    #[arg(long)]
    entities: bool,
    /// One JSON object for each file, with all counts per message and entity
    #[arg(long)]
    json: bool,
}

impl Info {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let mut damaged = false;
        for (at, file) in self.files.iter().enumerate() {
            let path = log_file(file)?;
            let tally = self.tally(&path)?;
            damaged |= tally.is_damaged();
            if self.json {
                writeln!(out, "{}", to_json(&path, &tally))?;
            } else {
                let gap = if at == 0 { "" } else { "\n" };
                write!(out, "{gap}{}", self.text(&path, &tally))?;
            }
            out.flush()?;
        }
        Ok(Outcome::damaged_if(damaged))
    }

    fn tally(&self, path: &Path) -> anyhow::Result<Tally> {
        let selection = self.select.on(path, false)?;
        let mut tally = Tally::default();
        scan(path, Printing::AtTheEnd, |item| {
            if let LogItem::Packet { view, .. } = item {
                tally.learn(view);
                if selection.admits(view) {
                    tally.packet(view);
                }
            } else {
                tally.other(item);
            }
            Ok(())
        })?;
        Ok(tally)
    }

    fn text(&self, path: &Path, tally: &Tally) -> String {
        let paint = Paint::stdout();
        let mut out = format!("{}\n", paint.title(&path.display().to_string()));
        let (packets, bytes) = (counted(tally.all.packets, "packet"), counted(tally.all.bytes, "byte"));
        writeln!(out, "  {packets}, {bytes}").ok();
        if let (Some(start), Some(latest)) = (tally.start_s, tally.all.latest_s) {
            writeln!(out, "  {} to {}, {:.1} s", iso(start), iso(latest), tally.span_s()).ok();
        }
        if let (Some(start), Some(earliest)) = (tally.start_s, tally.all.earliest_s)
            && earliest < start - 1.0
        {
            let text =
                format!("  remembered messages go back {:.1} s, to {}", start - earliest, iso(earliest));
            writeln!(out, "{}", paint.aside(&text)).ok();
        }
        out.push_str(&damage_text(tally, paint));
        if tally.all.packets > 0 {
            write!(out, "\n{}", sources_table(tally).render(2, paint)).ok();
            write!(out, "\n{}", self.messages_table(tally).render(2, paint)).ok();
        }
        out
    }

    fn messages_table(&self, tally: &Tally) -> Table {
        let who = if self.entities { "entity" } else { "entities" };
        let mut table = Table::new(&["message", ">id", ">packets", ">bytes", ">per second", who]);
        let rate = |packets| tally.rate_hz(packets).map(|rate| format!("{rate:.3}")).unwrap_or_default();
        for (id, senders) in &tally.messages {
            let mut line = |count: &Count, who: String| {
                let numbers = [count.packets.to_string(), count.bytes.to_string(), rate(count.packets)];
                table.row([name(*id).to_owned(), id.to_string()].into_iter().chain(numbers).chain([who]));
            };
            if self.entities {
                for (sender, count) in senders {
                    line(count, full_name(tally, *sender));
                }
            } else {
                line(&total(senders), entity_names(tally, senders));
            }
        }
        table
    }
}

fn name(id: u16) -> &'static str {
    catalogue::by_id(id).map_or("(unknown)", |message| message.abbrev)
}

fn total(senders: &BTreeMap<Sender, Count>) -> Count {
    let mut total = Count::default();
    for count in senders.values() {
        total.merge(count);
    }
    total
}

fn full_name(tally: &Tally, (source, entity): Sender) -> String {
    let names = &tally.names;
    plain(&format!("{}/{}", names.system(source), label_or_number(names, source, entity)))
}

/// The names of a few entities, or how many there are.
fn entity_names(tally: &Tally, senders: &BTreeMap<Sender, Count>) -> String {
    let label = |sender: &Sender| plain(&label_or_number(&tally.names, sender.0, sender.1));
    let names: BTreeSet<String> = senders.keys().map(label).collect();
    if names.len() > NAMED {
        return format!("{} entities", senders.len());
    }
    names.into_iter().collect::<Vec<_>>().join(", ")
}

fn damage_text(tally: &Tally, paint: Paint) -> String {
    let mut out = String::new();
    let damage = &tally.damage;
    if let Some(first) = damage.first {
        let text = format!(
            "damage: {} in {} are not packets, the first at byte {first}",
            counted(damage.bytes, "byte"),
            counted(damage.runs, "place")
        );
        writeln!(out, "  {}", paint.alert(&text)).ok();
    }
    if let Some((offset, problem)) = &damage.cut {
        let text = format!("damage: packed data ends early, after {offset} unpacked bytes ({problem})");
        writeln!(out, "  {}", paint.alert(&text)).ok();
    }
    for (class, count) in &tally.undecodable {
        let packets = counted(*count, "packet");
        writeln!(out, "  {}", paint.alert(&format!("damage: {packets} cannot be read: {class}"))).ok();
    }
    out
}

fn sources_table(tally: &Tally) -> Table {
    let mut table = Table::new(&["source", ">number", ">packets", ">bytes", "kind"]);
    for (source, count) in tally.sources() {
        table.row([
            plain(&tally.names.system(source)),
            format!("{:#06x}", source.0),
            count.packets.to_string(),
            count.bytes.to_string(),
            source.kind().to_string(),
        ]);
    }
    table
}

fn to_json(path: &Path, tally: &Tally) -> Value {
    let messages: Vec<Value> =
        tally.messages.iter().map(|(id, senders)| message_json(tally, *id, senders)).collect();
    let sources: Vec<Value> = tally
        .sources()
        .iter()
        .map(|(source, count)| {
            json!({
                "name": tally.names.system(*source), "id": source.0, "kind": source.kind().to_string(),
                "packets": count.packets, "bytes": count.bytes,
            })
        })
        .collect();
    let damage = &tally.damage;
    json!({
        "file": path.display().to_string(),
        "packets": tally.all.packets,
        "bytes": tally.all.bytes,
        "start": tally.start_s,
        "earliest": tally.all.earliest_s,
        "latest": tally.all.latest_s,
        "span_s": tally.span_s(),
        "sources": sources,
        "messages": messages,
        "damage": {
            "runs": damage.runs,
            "bytes": damage.bytes,
            "first_offset": damage.first,
            "cut": damage.cut.as_ref().map(|(offset, problem)| json!({"offset": offset, "problem": problem})),
            "undecodable": tally.undecodable,
        },
    })
}

fn message_json(tally: &Tally, id: u16, senders: &BTreeMap<Sender, Count>) -> Value {
    let all = total(senders);
    let entity = |((source, entity), count): (&Sender, &Count)| {
        json!({
            "src": source.0, "src_ent": entity, "entity": tally.names.latest_entity(*source, *entity).unwrap_or_default(),
            "packets": count.packets, "bytes": count.bytes, "rate_hz": tally.rate_hz(count.packets),
            "earliest": count.earliest_s, "latest": count.latest_s,
        })
    };
    json!({
        "abbrev": catalogue::by_id(id).map(|message| message.abbrev), "id": id,
        "packets": all.packets, "bytes": all.bytes, "rate_hz": tally.rate_hz(all.packets),
        "entities": senders.iter().map(entity).collect::<Vec<_>>(),
    })
}
