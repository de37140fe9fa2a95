//! Attributes that are missing, contradict each other, or are not values.

use super::chart::{CORNERS, Chart, MIDDLE, at, square};
use super::{BLOCKS, Row};
use charts::s57::write::FeatureDraft;
use charts::s57::{AttributeCode as Attr, ObjectClass as Class, ObjectId, Sounding};

/// A chart whose only depth area has these attributes.
fn depths(class: Class, attributes: &[(Attr, &str)]) -> Chart {
    let mut chart = Chart::bare();
    chart.cover();
    let area = FeatureDraft::area(class, &chart.outline());
    chart.add(attributes.iter().fold(area, |area, (code, value)| area.with(*code, *value)));
    chart
}

/// A rock with these attributes in water of 20 m.
fn rock(attributes: &[(Attr, &str)]) -> Chart {
    let mut chart = Chart::deep();
    chart.rock(attributes);
    chart
}

fn bridge(attributes: &[(Attr, &str)]) -> Chart {
    let mut chart = Chart::deep();
    chart.area(Class::BRIDGE, &square((63.009, 10.019), (63.011, 10.021)), attributes);
    chart
}

fn soundings(depth_m: f64) -> Chart {
    let mut chart = Chart::deep();
    let node = chart.cell.records.soundings(&[Sounding { at: at(MIDDLE), depth_m }]);
    chart.add(FeatureDraft::point(Class::SOUNDG, node));
    chart
}

/// Two objects with one identity: the second is the danger.
fn twins() -> Chart {
    let mut chart = Chart::deep();
    let object = ObjectId { agency: 540, number: 77, subdivision: 1 };
    for place in [CORNERS[0], MIDDLE] {
        let node = chart.cell.records.isolated_node(at(place));
        chart.add(FeatureDraft::point(Class::UWTROC, node).identity(object));
    }
    chart
}

const D1: Attr = Attr::DRVAL1;
const D2: Attr = Attr::DRVAL2;
const V: Attr = Attr::VALSOU;

pub(super) const ROWS: &[Row] = &[
    ("a depth area without DRVAL1", || depths(Class::DEPARE, &[(D2, "30")]), BLOCKS),
    ("a depth area with an empty DRVAL1", || depths(Class::DEPARE, &[(D1, ""), (D2, "30")]), BLOCKS),
    ("a depth area whose DRVAL1 is not a number", || depths(Class::DEPARE, &[(D1, "20 m")]), BLOCKS),
    ("a depth area whose DRVAL1 is not finite", || depths(Class::DEPARE, &[(D1, "inf")]), BLOCKS),
    ("a depth area with DRVAL1 beyond DRVAL2", || depths(Class::DEPARE, &[(D1, "20"), (D2, "2")]), BLOCKS),
    ("a depth area with two DRVAL1", || depths(Class::DEPARE, &[(D1, "20"), (D1, "2")]), BLOCKS),
    (
        "a depth area with two DRVAL1, one no number",
        || depths(Class::DEPARE, &[(D1, "20"), (D1, "x")]),
        BLOCKS,
    ),
    ("a depth area deeper than any sea", || depths(Class::DEPARE, &[(D1, "200000")]), BLOCKS),
    (
        "a depth area of unknown depth with a depth",
        || depths(Class::DEPARE, &[(D1, "20"), (Attr::QUASOU, "2")]),
        BLOCKS,
    ),
    ("a dredged area without DRVAL1", || depths(Class::DRGARE, &[(D2, "30")]), BLOCKS),
    ("a dredged area with DRVAL1 beyond DRVAL2", || depths(Class::DRGARE, &[(D1, "20"), (D2, "2")]), BLOCKS),
    ("an unsurveyed area with a depth", || depths(Class::UNSARE, &[(D1, "20")]), BLOCKS),
    ("a rock without VALSOU", || rock(&[]), BLOCKS),
    ("a rock with an empty VALSOU", || rock(&[(V, "")]), BLOCKS),
    ("a rock whose VALSOU is not a number", || rock(&[(V, "20,5")]), BLOCKS),
    ("a rock with two VALSOU", || rock(&[(V, "20"), (V, "1")]), BLOCKS),
    ("a rock deeper than any sea", || rock(&[(V, "200000")]), BLOCKS),
    ("a rock of unknown depth with a depth", || rock(&[(V, "20"), (Attr::QUASOU, "2")]), BLOCKS),
    (
        "a rock of unknown depth in a second QUASOU",
        || rock(&[(V, "20"), (Attr::QUASOU, "1"), (Attr::QUASOU, "2")]),
        BLOCKS,
    ),
    ("a rock that covers and uncovers 20 m down", || rock(&[(V, "20"), (Attr::WATLEV, "4")]), BLOCKS),
    ("a rock that is always dry 20 m down", || rock(&[(V, "20"), (Attr::WATLEV, "2")]), BLOCKS),
    ("a rock that is partly under water 20 m down", || rock(&[(V, "20"), (Attr::WATLEV, "1")]), BLOCKS),
    ("a rock awash 20 m down", || rock(&[(V, "20"), (Attr::WATLEV, "5")]), BLOCKS),
    (
        "a rock shoaler than the water around it, without VALSOU",
        || rock(&[(Attr::EXPSOU, "2"), (Attr::WATLEV, "3")]),
        BLOCKS,
    ),
    (
        "a rock as deep as the water around it, with and without",
        || rock(&[(Attr::EXPSOU, "1"), (Attr::EXPSOU, "2"), (Attr::WATLEV, "3")]),
        BLOCKS,
    ),
    (
        "a rock as deep as the water around it, of unknown water level",
        || rock(&[(Attr::EXPSOU, "1")]),
        BLOCKS,
    ),
    ("a sounding shoaler than its depth area", || soundings(1.0), BLOCKS),
    ("a sounding that dries in deep water", || soundings(-2.0), BLOCKS),
    (
        "soundings at a node without depths",
        || {
            let mut chart = Chart::deep();
            let node = chart.cell.records.isolated_node(at(MIDDLE));
            chart.add(FeatureDraft::point(Class::SOUNDG, node));
            chart
        },
        BLOCKS,
    ),
    ("a bridge without a clearance", || bridge(&[]), BLOCKS),
    ("a bridge whose clearance is not a number", || bridge(&[(Attr::VERCLR, "high")]), BLOCKS),
    ("a bridge with two clearances", || bridge(&[(Attr::VERCLR, "20"), (Attr::VERCLR, "1")]), BLOCKS),
    (
        "a bridge with two clearances, one no number",
        || bridge(&[(Attr::VERCLR, "20"), (Attr::VERCLR, "x")]),
        BLOCKS,
    ),
    ("two rocks with one identity", twins, BLOCKS),
    (
        "a depth area of the second group beside none of the first",
        || {
            let mut chart = Chart::bare();
            chart.cover();
            let water = chart.water("20");
            let head = |group| {
                [&[100][..], &water.record.to_le_bytes(), &[3, group], &42_u16.to_le_bytes()].concat()
            };
            chart.patches.push((head(1), head(2)));
            chart.rock(&[]);
            chart
        },
        BLOCKS,
    ),
];
