//! The compact form of a client's frames: a series is described once, then only its values are sent, and all frames are one
//! stream of raw DEFLATE, so that repeated parts cost almost nothing.
//!
//! The frames contain no secret of the client, so compressed lengths cannot reveal one.

use api::{Field, LiveFrame, LiveSample, LiveSeries, Update};
use bytes::Bytes;
use flate2::{Compress, Compression, FlushCompress, Status};
use std::collections::BTreeMap;

/// Key of a series: system, message, entity, instance.
type Key = (u16, u16, u8, Option<u8>);

/// One connection's frames in the compact form.
pub(super) struct Compact {
    deflate: Compress,
    /// Numbers of the series described since the snapshot, and the number of described fields.
    described: BTreeMap<Key, (u32, usize)>,
}

impl Compact {
    pub(super) fn new() -> Self {
        Self { deflate: Compress::new(Compression::default(), false), described: BTreeMap::new() }
    }

    /// The bytes of the next message: the frame with its values as samples.
    ///
    /// # Errors
    /// The frame cannot be written as JSON.
    pub(super) fn message(&mut self, mut frame: LiveFrame) -> serde_json::Result<Bytes> {
        if frame.snapshot {
            self.described.clear();
        }
        for value in std::mem::take(&mut frame.values) {
            let series = self.number(&value, &mut frame.series);
            frame.samples.push(sample(series, value));
        }
        let mut text = serde_json::to_vec(&frame)?;
        text.push(b'\n');
        Ok(self.packed(&text).into())
    }

    /// The number of a value's series, which is described again if the value has fields not described before.
    fn number(&mut self, value: &Update, described: &mut Vec<LiveSeries>) -> u32 {
        let next = u32::try_from(self.described.len()).unwrap_or(u32::MAX);
        let key = (value.system, value.id, value.entity, value.instance);
        let (series, fields) = self.described.entry(key).or_insert((next, 0));
        // A message's fields are fixed by its id: a truncated message has the first of them.
        if *series == next || value.fields.len() > *fields {
            *fields = value.fields.len();
            described.push(LiveSeries {
                series: *series,
                system: value.system,
                id: value.id,
                abbrev: value.abbrev.clone(),
                entity: value.entity,
                instance: value.instance,
                names: value.fields.iter().map(|field| field.name.clone()).collect(),
                units: value.fields.iter().map(|field| field.unit.clone()).collect(),
            });
        }
        *series
    }

    /// The stream's next bytes, up to a sync flush, by which the client can read all of `text`.
    fn packed(&mut self, text: &[u8]) -> Vec<u8> {
        let begun = self.deflate.total_in();
        let mut packed = Vec::with_capacity(text.len() / 4 + 64);
        loop {
            let taken = usize::try_from(self.deflate.total_in() - begun).unwrap_or(usize::MAX);
            let rest = text.get(taken..).unwrap_or_default();
            let status = self.deflate.compress_vec(rest, &mut packed, FlushCompress::Sync);
            // Everything is written if room is left after the flush; another flush without data would add a second mark.
            let whole = packed.len() < packed.capacity();
            if whole || !matches!(status, Ok(Status::Ok | Status::BufError)) {
                return packed;
            }
            packed.reserve(text.len() / 4 + 64);
        }
    }
}

fn sample(series: u32, value: Update) -> LiveSample {
    let Update { time_us, received_us, count, period_s, fields, .. } = value;
    let mut meanings: Vec<_> = fields.iter().map(|field| field.meaning.clone()).collect();
    if meanings.iter().all(Option::is_none) {
        meanings.clear();
    }
    let values = fields.into_iter().map(|Field { value, .. }| value).collect();
    LiveSample { series, time_us, received_us, count, period_s, values, meanings }
}
