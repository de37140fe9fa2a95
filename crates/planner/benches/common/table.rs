//! Rows of the table of all planners, which `scripts/bench-routes` prints at its end.

use std::io::Write as _;

/// What one planner did with one start and goal.
#[derive(Debug, Default)]
pub(crate) struct Row<'a> {
    pub(crate) water: &'a str,
    pub(crate) planner: &'a str,
    /// To prepare the water (ms), where that is apart from the first answer.
    pub(crate) prepared_ms: Option<f64>,
    pub(crate) first_ms: f64,
    pub(crate) again_ms: Option<f64>,
    pub(crate) length_m: f64,
    /// Cells that were closed, or intervals that were looked at.
    pub(crate) nodes: usize,
}

impl Row<'_> {
    /// Adds it to the file that `LUTRA_TABLE` names, with the memory of this process at most so far.
    pub(crate) fn note(&self) {
        let Some(file) = std::env::var_os("LUTRA_TABLE") else { return };
        let mut table = std::fs::File::options().create(true).append(true).open(file).unwrap();
        let ms = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.2}"));
        let Self { water, planner, prepared_ms, first_ms, again_ms, length_m, nodes } = self;
        let (prepared, again) = (ms(*prepared_ms), ms(*again_ms));
        let most_mib = most_mib();
        writeln!(
            table,
            "{water}\t{planner}\t{prepared}\t{first_ms:.2}\t{again}\t{length_m:.1}\t{nodes}\t{most_mib}"
        )
        .unwrap();
    }
}

/// Memory of this process at most (MiB), as Linux reports it.
fn most_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap_or(0) >> 10
}
