//! The ranks that divide the selected detections into equal parts, for samples.

use super::sighting::{Pieces, Sightings};
use super::summary::{Question, Series, wanted};
use crate::study::Study;

/// The detections of a question, in parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranks {
    /// How many there are.
    pub detections: u64,
    /// The parts, in order; none where nothing is wanted.
    pub parts: Vec<Rank>,
}

/// A part of the detections, in the order in which they were reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rank {
    /// When the first one was reported (µs since 1970 UTC).
    pub from_us: i64,
    /// How many were reported from then on, before the next part begins.
    pub detections: u64,
}

/// Divides the detections of a question into at most so many parts of about equally many. What was reported at the same time stays
/// together. It does not look beyond the question: `pieces` are as for [`super::summary()`], and all of it.
pub fn ranks(pieces: &[&Sightings], study: &Study, question: &Question, parts: usize) -> Ranks {
    let pieces = Pieces::new(pieces);
    let series: Vec<Series<'_>> =
        pieces.names.iter().map(|name| Series::new(name, study, question)).collect();
    let mut times: Vec<i64> =
        wanted(&pieces, &series, question).0.iter().map(|one| one.row.reported_us).collect();
    times.sort_unstable();
    let mut begins: Vec<i64> =
        (0..parts).filter_map(|part| times.get(part * times.len() / parts)).copied().collect();
    begins.dedup();
    let before = |us: i64| times.partition_point(|time_us| *time_us < us);
    let ends = begins.iter().skip(1).map(|begin_us| before(*begin_us)).chain([times.len()]);
    let part = |(from_us, end): (&i64, usize)| Rank {
        from_us: *from_us,
        detections: (end - before(*from_us)) as u64,
    };
    Ranks { detections: times.len() as u64, parts: begins.iter().zip(ends).map(part).collect() }
}
