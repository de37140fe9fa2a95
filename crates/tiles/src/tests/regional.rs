//! Charts that are read when a tile touches them give the tiles of a sheet that holds all of them.

use super::{cells, in_tile, source};
use crate::sheet::{SheetChart, SheetReader, Unread};
use crate::{Changed, MOST_ZOOM, NoTile, Sheet};
use charts::coverage::{ChartCoverage, Polygon};
use charts::s57::{Cell, Feature, NamedBytes};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Sums of tiles of the archipelago by zoom, as a sheet gave them that was made of all charts at once and held whole.
const ARCHIPELAGO: [u64; 19] = [
    0x149d_043d_6ef8_62f1,
    0xbf06_1e7f_6596_0c11,
    0x95a0_6538_022a_98fd,
    0x5617_3c6b_a38c_1d6b,
    0x12b2_47dc_06f8_3daf,
    0x3c29_0a1b_2231_43b3,
    0xf02e_9d6d_3259_3b1d,
    0xaa9b_ff07_65b6_f475,
    0xb2b8_cdbe_45e0_9d9f,
    0x80d5_ca44_69b7_645d,
    0xf986_4329_c6c8_8a95,
    0x0e36_c46b_d906_7ef8,
    0xa33d_7771_d3f4_4645,
    0x3e36_78a7_89cb_741b,
    0xc252_0f67_7fa6_a1fe,
    0x91c7_54fa_9a2d_0749,
    0x3a0b_a8f5_f0a8_2cf5,
    0x5027_f381_10f3_15a0,
    0xdc44_c233_08af_72ed,
];
/// With the shared cells, likewise.
const SHARED: [u64; 19] = [
    0x88ff_706d_62ea_3225,
    0x9057_9796_637a_06cb,
    0x2b61_eab5_c7f2_25e4,
    0xd934_94cf_9160_fc17,
    0xa72b_52ef_f3df_3963,
    0x6bd4_65fa_16d4_b242,
    0xe92e_75e8_dbb0_ceb8,
    0xcd57_b5a4_bd95_1ee7,
    0x6890_c737_ee79_cd59,
    0x89b2_0d66_e79e_9113,
    0xc87f_2b01_1911_a91b,
    0x5007_8f99_aae1_df10,
    0xdeb5_08c7_6673_975e,
    0xc07b_37f0_f819_827c,
    0x91df_80e1_b2a4_73db,
    0xa78c_21d1_8062_0d80,
    0x125f_6ad9_d5d9_86b1,
    0x1512_32f0_1e99_21e8,
    0x12c1_7f88_1a9d_9314,
];

/// By chart and zoom.
type Kept = BTreeMap<(usize, u8), Vec<u8>>;

/// Cells in memory, and what is kept of them.
#[derive(Debug, Clone, Default)]
struct Held {
    /// The best first.
    cells: Arc<Vec<Cell>>,
    kept: Arc<Mutex<Kept>>,
    /// Numbers of the charts whose features were read.
    read: Arc<Mutex<Vec<usize>>>,
    trouble: Arc<Mutex<BTreeMap<usize, Unread>>>,
}

impl Held {
    fn of(cells: &[Cell]) -> Self {
        let mut cells = cells.to_vec();
        cells.sort_by_cached_key(|cell| source(cell).rank());
        Self { cells: Arc::new(cells), ..Self::default() }
    }

    fn sheet(&self, most_bytes: usize) -> Sheet {
        let chart = |cell: &Cell| {
            let points = || cell.features.iter().flat_map(|feature| feature.geometry.points());
            let bounds = points().map(|at| [at.lon_deg, at.lat_deg, at.lon_deg, at.lat_deg]);
            let around =
                |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
            let features = cell.features.len() as u32;
            SheetChart { source: source(cell), bounds_deg: bounds.reduce(around), features }
        };
        Sheet::new(self.cells.iter().map(chart).collect(), Box::new(self.clone()), most_bytes)
    }

    fn check(&self, chart: usize) -> Result<&Cell, Unread> {
        let trouble = self.trouble.lock().unwrap().get(&chart).cloned();
        trouble.map_or_else(|| Ok(&self.cells[chart]), Err)
    }
}

impl SheetReader for Held {
    fn features(&self, chart: usize) -> Result<Vec<Feature>, Unread> {
        self.read.lock().unwrap().push(chart);
        self.check(chart).map(|cell| cell.features.clone())
    }

    fn coverage(&self, chart: usize) -> Result<Vec<Polygon>, Unread> {
        self.check(chart).map(|cell| ChartCoverage::of(source(cell), &cell.features).areas)
    }

    fn kept(&self, chart: usize, _: &[usize], zoom: u8) -> Option<Vec<u8>> {
        self.kept.lock().unwrap().get(&(chart, zoom)).cloned()
    }

    fn keep(&self, chart: usize, _: &[usize], zooms: &[Vec<u8>]) {
        let all = (0..).zip(zooms).map(|(zoom, bytes)| ((chart, zoom), bytes.clone()));
        self.kept.lock().unwrap().extend(all);
    }

    fn sweep(&self, better: &[Vec<usize>]) {
        assert_eq!(better.len(), self.cells.len());
    }
}

pub(super) fn sheet(cells: &[Cell], most_bytes: usize) -> Sheet {
    Held::of(cells).sheet(most_bytes)
}

/// The shared cells and those of the archipelago; `None` without the shared ones.
fn many_cells() -> Option<Vec<Cell>> {
    let mut all = cells();
    for name in
        ["GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE", "GB5X02SE", "US4MD81M", "US5MD1MC", "US5WA22M"]
    {
        let bytes = std::fs::read(testkit::shared(&format!("data/charts/{name}.000"))?).unwrap();
        let name = format!("{name}.000");
        all.push(Cell::read(NamedBytes { name: &name, bytes: &bytes }, &[]).unwrap());
    }
    Some(all)
}

/// Of each zoom a sum over the bytes of tiles all over the cells (FNV-1a, 64 bits).
fn sums(cells: &[Cell], tile: impl Fn(u8, u32, u32) -> Vec<u8>) -> Vec<u64> {
    let sum = |zoom: u8| {
        let mut sum = 0xcbf2_9ce4_8422_2325_u64;
        for cell in cells {
            let points = || cell.features.iter().flat_map(|feature| feature.geometry.points());
            let places: Vec<[u32; 2]> = points().map(|at| in_tile(at, zoom).0).collect();
            let (x, y) = (places.iter().map(|at| at[0]), places.iter().map(|at| at[1]));
            let columns: Vec<u32> = (x.clone().min().unwrap()..=x.max().unwrap()).collect();
            let rows: Vec<u32> = (y.clone().min().unwrap()..=y.max().unwrap()).collect();
            for column in columns.iter().step_by(columns.len().div_ceil(6)) {
                for row in rows.iter().step_by(rows.len().div_ceil(6)) {
                    for byte in tile(zoom, *column, *row) {
                        sum = (sum ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
                    }
                }
            }
        }
        sum
    };
    (0..=MOST_ZOOM).map(sum).collect()
}

/// Of every sum, those that are others.
fn others(found: &[u64], expected: &[u64]) -> Vec<usize> {
    (0..expected.len()).filter(|zoom| found[*zoom] != expected[*zoom]).collect()
}

#[test]
fn tiles_have_the_bytes_of_a_sheet_that_was_held_whole() {
    // Kept whole; so little kept that each tile reads its charts again, but for their overviews; some of it kept.
    let archipelago = (Some(cells()), &ARCHIPELAGO, &[usize::MAX, 1][..]);
    for (cells, expected, kept) in [archipelago, (many_cells(), &SHARED, &[32 << 20])] {
        let Some(cells) = cells else { return };
        let held = Held::of(&cells);
        for most_bytes in kept.iter().copied() {
            let sheet = held.sheet(most_bytes);
            let found = sums(&cells, |zoom, x, y| sheet.tile(zoom, x, y).unwrap());
            assert_eq!(others(&found, expected), [0; 0], "zooms that differ");
            assert!(sheet.unreadable().is_empty());
        }
    }
}

#[test]
fn a_tile_reads_the_charts_that_it_touches_and_small_zooms_what_is_kept_of_them() {
    let Some(cells) = many_cells() else { return };
    let held = Held::of(&cells);
    let sheet = held.sheet(64 << 20);
    let read = || std::mem::take(&mut *held.read.lock().unwrap());
    let number = |name: &str| held.cells.iter().position(|cell| cell.id.name.starts_with(name)).unwrap();
    // Far from all others, within the box of one chart.
    let at = held.cells[number("US5MD1MC")].features.iter().find_map(|one| one.geometry.points().next());
    let ([x, y], _) = in_tile(at.unwrap(), 16);
    assert!(!sheet.tile(16, x, y).unwrap().is_empty());
    assert!(read().iter().all(|one| [number("US5MD1MC"), number("US4MD81M")].contains(one)));
    sheet.tile(16, x, y).unwrap();
    assert_eq!(read(), [0; 0], "kept in memory");
    sheet.prepare(|| true).unwrap();
    read();
    // Another start: nothing is made again.
    let sheet = held.sheet(64 << 20);
    sheet.prepare(|| true).unwrap();
    assert!(!sheet.tile(0, 0, 0).unwrap().is_empty() || !sheet.tile(7, x >> 9, y >> 9).unwrap().is_empty());
    assert_eq!(read(), [0; 0], "overviews are kept");
}

#[test]
fn damaged_overviews_are_made_again_and_lead_nowhere() {
    let cells = cells();
    let held = Held::of(&cells);
    let whole = held.sheet(usize::MAX).tile(8, 135, 69).unwrap();
    assert!(!whole.is_empty());
    let kept = held.kept.lock().unwrap().clone();
    for (key, bytes) in kept.iter().filter(|((_, zoom), _)| *zoom == 8) {
        for length in (0..bytes.len()).step_by(bytes.len() / 50 + 1) {
            held.kept.lock().unwrap().insert(*key, bytes[..length].to_vec());
            assert_eq!(held.sheet(usize::MAX).tile(8, 135, 69).unwrap(), whole, "{key:?} cut at {length}");
        }
    }
}

#[test]
fn where_a_chart_is_damaged_nothing_is_drawn_and_the_coarser_does_not_pass_for_it() {
    let cells = cells();
    let held = Held::of(&cells);
    let finer = held.cells.iter().position(|cell| cell.id.name.starts_with("XX5")).unwrap();
    let place = charts::s57::GeoPoint { lon_deg: 10.345, lat_deg: 63.446 };
    for zoom in [6, 8, 12, 16] {
        let ([x, y], local) = in_tile(place, zoom);
        let drawn = |sheet: &Sheet| {
            let layers = super::decoded(&sheet.tile(zoom, x, y).unwrap());
            layers.into_values().flatten().any(|got| got.kind == 3 && got.holds(local))
        };
        assert!(zoom < 8 || drawn(&held.sheet(usize::MAX)), "zoom {zoom}");
        let damaged = Held::of(&cells);
        damaged.trouble.lock().unwrap().insert(finer, Unread::Damaged("rubbish".to_owned()));
        let sheet = damaged.sheet(usize::MAX);
        assert!(!drawn(&sheet), "zoom {zoom}");
        assert_eq!(sheet.unreadable(), ["XX5LUTRA: rubbish"]);
        assert!(damaged.kept.lock().unwrap().keys().all(|(chart, _)| *chart != finer), "not kept");
    }
}

#[test]
fn a_set_that_changed_is_told_and_nothing_of_it_is_kept() {
    let held = Held::of(&cells());
    for chart in 0..held.cells.len() {
        held.trouble.lock().unwrap().insert(chart, Unread::Changed);
    }
    let sheet = held.sheet(usize::MAX);
    let place = charts::s57::GeoPoint { lon_deg: 10.345, lat_deg: 63.446 };
    for zoom in [8, 14] {
        let ([x, y], _) = in_tile(place, zoom);
        assert_eq!(sheet.tile(zoom, x, y), Err(NoTile::Changed(Changed)));
    }
    held.trouble.lock().unwrap().clear();
    let ([x, y], _) = in_tile(place, 14);
    assert!(!sheet.tile(14, x, y).unwrap().is_empty() && sheet.unreadable().is_empty());
}
