//! A page of detections, each with its nearest neighbour and its flags.

use crate::decode;
use detections::{Detection, TagFilter};
use research::{HORIZON_S, Lag, Lags, Narrowed, Study};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use store::{DetectionsWanted, Order, Page, Reader, StoreError, TimeRange};

/// Detections that are read to tell the neighbours of a page.
const NEIGHBOURS: usize = 200_000;

/// A page of the detections that are wanted, of projects and places, each with its nearest neighbour and its flags. Where more
/// than 200,000 would have to be read for that, the rest has no neighbour and no flags.
///
/// # Errors
/// The history cannot be read.
pub fn page(
    data: &Path,
    reader: &mut Reader,
    wanted: &DetectionsWanted,
    (order, page): (Order, Page),
    study: &Study,
    (narrowed, flags): (&Narrowed, bool),
) -> store::Result<api::Detections> {
    let is_wanted =
        |one: &Detection| narrowed.is_all() || narrowed.admits(&study.heard(one, "", Lag::Unknown));
    let found = reader.detections_where(wanted, order, page, is_wanted)?;
    let next = found.next.map(|rest| super::super::next(rest, wanted.range, order));
    let lags = if flags { lags(data, wanted, &found.items)? } else { BTreeMap::new() };
    let told = |one: Detection| {
        let lag = lags.get(&(one.origin.system.0, one.id())).copied();
        let told = lag.map(|lag| (lag.seconds(), study.heard(&one, "", lag).flags()));
        let (min_lag_s, flags) = told.unzip();
        api::Detection { min_lag_s: min_lag_s.flatten(), flags, ..decode::detection(one) }
    };
    Ok(api::Detections { detections: found.items.into_iter().map(told).collect(), next })
}

/// The nearest neighbours of detections, by vessel and id.
fn lags(
    data: &Path,
    wanted: &DetectionsWanted,
    items: &[Detection],
) -> store::Result<BTreeMap<(u16, String), Lag>> {
    let times = || items.iter().map(|one| one.origin.reported.micros());
    let (Some(first_us), Some(last_us)) = (times().min(), times().max()) else { return Ok(BTreeMap::new()) };
    let beside_us = HORIZON_S * 1_000_000;
    let range =
        TimeRange { from_us: first_us.saturating_sub(beside_us), to_us: last_us.saturating_add(beside_us) };
    let mut tags: Vec<TagFilter> = items.iter().filter_map(|one| one.tag().parse().ok()).collect();
    tags.sort_by_key(|tag| format!("{tag:?}"));
    tags.dedup();
    let near = DetectionsWanted { range, tags, came_from: None, ..wanted.clone() };
    let ids: BTreeSet<(u16, String)> = items.iter().map(|one| (one.origin.system.0, one.id())).collect();
    let (mut lags, mut told, mut read) = (Lags::default(), BTreeMap::new(), 0);
    let mut tell = |(one, lag): (Detection, Lag)| {
        let reported_us = one.origin.reported.micros();
        let key = (one.origin.system.0, one.id());
        if (first_us..=last_us).contains(&reported_us) && ids.contains(&key) {
            told.insert(key, lag);
        }
    };
    let read_all = store::each_detection(data, &near, &mut |one, _| {
        read += 1;
        if read > NEIGHBOURS {
            return Err(StoreError::Cancelled);
        }
        lags.push(one);
        while let Some(one) = lags.pop() {
            tell(one);
        }
        Ok(())
    });
    match read_all {
        // What still waits may have a neighbour that was not read.
        Err(StoreError::Cancelled) => return Ok(told),
        read => read?,
    }
    while let Some(one) = lags.take() {
        tell(one);
    }
    Ok(told)
}
