//! Which packets of a log are wanted.

use super::condition::Condition;
use super::moment::Moment;
use super::names;
use super::scan::start_s;
use crate::pick::Pick;
use anyhow::bail;
use imc::names::Names;
use imc::{PacketView, reflect};
use std::collections::BTreeSet;
use std::path::Path;

/// Flags that choose packets of a log.
#[derive(Debug, clap::Args)]
pub(crate) struct Select {
    #[command(flatten)]
    pub(crate) pick: Pick,
    /// Not before this time: 2026-11-21T07:43:27Z (or with an offset, +02:00), seconds since 1970, or +SECONDS after the log's
    /// start
    #[arg(long, value_name = "TIME")]
    from: Option<Moment>,
    /// Not after this time
    #[arg(long, value_name = "TIME")]
    to: Option<Moment>,
    /// Only from this entity, by number, or by the label that it had then; may be given several times
    #[arg(long, short = 'e', value_name = "ENTITY")]
    entity: Vec<String>,
    /// Only where a field has such a value, such as 'sog>0.5'; of several, all must hold
    #[arg(long = "where", short = 'w', value_name = "FIELD OP VALUE")]
    conditions: Vec<Condition>,
}

/// The choice for one log.
pub(crate) struct Selection<'s> {
    select: &'s Select,
    from_s: f64,
    to_s: f64,
    /// The log's names, if needed.
    pub(crate) names: Names,
}

impl Select {
    /// Prepares the selection for a log; reads its names if `with_names` or the selection needs them.
    ///
    /// # Errors
    /// When the log cannot be read, or the field of a condition, or the entity of a label, does not exist.
    pub(crate) fn on(&self, path: &Path, with_names: bool) -> anyhow::Result<Selection<'_>> {
        for condition in &self.conditions {
            condition.check(&self.pick.messages).map_err(anyhow::Error::msg)?;
        }
        let by_label = self.entity.iter().any(|entity| entity.parse::<u8>().is_err());
        let names = if with_names || by_label { names::of_log(path)? } else { Names::default() };
        let relative = |moment: &Option<Moment>| matches!(moment, Some(Moment::AfterStart(_)));
        let start_s = if relative(&self.from) || relative(&self.to) { start_s(path)? } else { 0.0 };
        self.check_entities(path, &names)?;
        Ok(Selection {
            select: self,
            from_s: self.from.map_or(f64::NEG_INFINITY, |from| from.seconds(start_s)),
            to_s: self.to.map_or(f64::INFINITY, |to| to.seconds(start_s)),
            names,
        })
    }

    fn check_entities(&self, path: &Path, names: &Names) -> anyhow::Result<()> {
        for entity in self.entity.iter().filter(|entity| entity.parse::<u8>().is_err()) {
            if names::labels(names).any(|label| label.eq_ignore_ascii_case(entity)) {
                continue;
            }
            let labels: BTreeSet<&str> = names::labels(names).collect();
            let hint = match suggest::alike(entity, labels.iter().copied()).as_slice() {
                [] if labels.is_empty() => "it tells no labels; give a number".to_owned(),
                [] => format!("there are {}", labels.into_iter().collect::<Vec<_>>().join(", ")),
                names => format!("did you mean {}?", names.join(" or ")),
            };
            bail!("{}: no entity is called `{entity}`; {hint}", path.display());
        }
        Ok(())
    }
}

impl Selection<'_> {
    /// Whether a packet is wanted.
    pub(crate) fn admits(&self, view: &PacketView<'_>) -> bool {
        self.select.pick.admits(view)
            && self.is_in_time(view)
            && self.is_of_entity(view)
            && self.is_where(view)
    }

    /// A packet without a time is in no span.
    fn is_in_time(&self, view: &PacketView<'_>) -> bool {
        if self.select.from.is_none() && self.select.to.is_none() {
            return true;
        }
        (self.from_s..=self.to_s).contains(&view.timestamp())
    }

    fn is_of_entity(&self, view: &PacketView<'_>) -> bool {
        let wanted = &self.select.entity;
        let label =
            || self.names.entity(view.src(), view.src_ent(), names::time_us(view)).unwrap_or_default();
        wanted.is_empty()
            || wanted
                .iter()
                .any(|entity| entity.parse() == Ok(view.src_ent()) || entity.eq_ignore_ascii_case(label()))
    }

    /// A packet that cannot be read has no values.
    fn is_where(&self, view: &PacketView<'_>) -> bool {
        let conditions = &self.select.conditions;
        if conditions.is_empty() {
            return true;
        }
        let Some(Ok(fields)) = reflect::fields(view) else { return false };
        conditions.iter().all(|condition| condition.holds(&fields))
    }
}
