//! Edges, rings and areas that do not fit together.

use super::chart::{At, Chart, MIDDLE, at, square};
use super::{BLOCKS, Must, Row};
use charts::s57::write::{FeatureDraft, VectorRef, VectorUse};
use charts::s57::{AttributeCode as Attr, ObjectClass as Class};

/// Within the chart: west and east of its middle, and north-east of it.
pub(super) const WEST: At = (63.01, 10.01);
pub(super) const EAST: At = (63.01, 10.03);
pub(super) const CORNER: At = (63.015, 10.03);
const NORTH: At = (63.014, 10.02);
const SOUTH: At = (63.006, 10.02);
const BLOCKS_EAST: Must = Must::Block(&[EAST]);

/// Corners of an area of some 1.3 by 1.2 km around the middle.
const LARGE: [At; 4] = [(63.004, 10.008), (63.016, 10.008), (63.016, 10.032), (63.004, 10.032)];

/// A danger over edges that `pick` takes of the ring of [`LARGE`].
fn danger(pick: fn(&[VectorUse]) -> Vec<VectorUse>) -> Chart {
    let mut chart = Chart::deep();
    let ring: Vec<_> = chart.ring(&LARGE).into_iter().map(VectorRef::forward).collect();
    chart.add(FeatureDraft::area(Class::OBSTRN, &pick(&ring)));
    chart
}

/// A danger over a ring of its own.
fn ring_of(corners: &[At]) -> Chart {
    let mut chart = Chart::deep();
    chart.area(Class::OBSTRN, corners, &[]);
    chart
}

/// A danger whose record says that it is a point, a line, or nothing.
fn as_primitive(primitive: u8) -> Chart {
    let mut chart = Chart::deep();
    let area = chart.area(Class::OBSTRN, &LARGE, &[]);
    chart.as_primitive(area, primitive);
    chart
}

/// A danger bounded by a straight edge in the south and one over the middle, of which `pick` takes some.
fn bulge(class: Class, pick: fn(&Chart, VectorUse) -> Vec<VectorUse>) -> Chart {
    let mut chart = Chart::deep();
    let nodes = [(63.002, 10.01), (63.002, 10.03)].map(|one| chart.cell.records.connected_node(at(one)));
    let _over = chart.cell.records.edge(nodes[0], nodes[1], &[at((63.015, 10.01)), at((63.015, 10.03))]);
    let straight = chart.cell.records.edge(nodes[1], nodes[0], &[]).forward();
    let edges = pick(&chart, straight);
    chart.add(if class == Class::COALNE {
        FeatureDraft::line(class, &edges)
    } else {
        FeatureDraft::area(class, &edges)
    });
    chart
}

/// A western and an eastern half of the covered water, each as deep as given and with its own border to the other.
fn halves(west: (&str, [At; 2]), east: (&str, [At; 2])) -> Chart {
    let mut chart = Chart::bare();
    chart.cover();
    let (least_m, [south, north]) = west;
    chart.area(Class::DEPARE, &[(63.0, 10.0), (63.02, 10.0), north, south], &[(Attr::DRVAL1, least_m)]);
    let (least_m, [south, north]) = east;
    chart.area(Class::DEPARE, &[south, north, (63.02, 10.04), (63.0, 10.04)], &[(Attr::DRVAL1, least_m)]);
    chart
}

const AXIS: [At; 2] = [(63.0, 10.02), (63.02, 10.02)];
/// Borders that cross each other without a node, 500 m apart at their ends.
const LEANING: [At; 2] = [(63.0, 10.015), (63.02, 10.025)];
const COUNTER: [At; 2] = [(63.0, 10.025), (63.02, 10.015)];

/// Water all over, with a hole in the middle as `pick` uses its ring.
fn hole(corners: [At; 4], pick: fn(VectorUse) -> VectorUse) -> Chart {
    let mut chart = Chart::bare();
    chart.cover();
    let ring = chart.ring(&corners);
    let bounds: Vec<_> =
        chart.outline().into_iter().chain(ring.iter().map(|edge| pick(edge.forward()))).collect();
    chart.add(FeatureDraft::area(Class::DEPARE, &bounds).with(Attr::DRVAL1, "20"));
    chart
}

const ISLAND: [At; 4] = [(63.008, 10.016), (63.012, 10.016), (63.012, 10.024), (63.008, 10.024)];

/// Covered and deep in the west alone, and something beyond.
fn western(beyond: fn(&mut Chart)) -> Chart {
    let mut chart = Chart::bare();
    let ring: Vec<_> =
        chart.ring(&square((63.0, 10.0), (63.02, 10.02))).into_iter().map(VectorRef::forward).collect();
    chart.add(FeatureDraft::area(Class::M_COVR, &ring).with(Attr::CATCOV, "1"));
    chart.add(FeatureDraft::area(Class::DEPARE, &ring).with(Attr::DRVAL1, "20"));
    beyond(&mut chart);
    chart
}

const EASTERN: [At; 4] = [(63.004, 10.022), (63.016, 10.022), (63.016, 10.038), (63.004, 10.038)];

/// An object without any pointer, in deep water.
fn nowhere(class: Class) -> Chart {
    let mut chart = Chart::deep();
    chart.add(FeatureDraft::collection(class));
    chart
}

fn ghost_point(class: Class) -> Chart {
    let mut chart = Chart::deep();
    let ghost = chart.ghost_node();
    chart.add(FeatureDraft::point(class, ghost));
    chart
}

pub(super) const ROWS: &[Row] = &[
    ("a rock without a pointer", || nowhere(Class::UWTROC), Must::Refuse("UWTROC 3 has no position")),
    ("a wreck without a pointer", || nowhere(Class::WRECKS), Must::Refuse("WRECKS 3 has no position")),
    ("a bridge without a pointer", || nowhere(Class::BRIDGE), Must::Refuse("BRIDGE 3 has no position")),
    ("land without a pointer", || nowhere(Class::LNDARE), Must::Refuse("LNDARE 3 has no position")),
    ("soundings without a pointer", || nowhere(Class::SOUNDG), Must::Refuse("SOUNDG 3 has no position")),
    (
        "a rock whose node is not there",
        || ghost_point(Class::UWTROC),
        Must::Refuse("UWTROC 3 has no position"),
    ),
    (
        "an islet whose node is not there",
        || ghost_point(Class::LNDARE),
        Must::Refuse("LNDARE 3 has no position"),
    ),
    (
        "soundings whose node is not there",
        || ghost_point(Class::SOUNDG),
        Must::Refuse("SOUNDG 3 has no position"),
    ),
    (
        "a rock that points to an edge",
        || {
            let mut chart = Chart::deep();
            let edge = chart.cell.records.edge(chart.corners[0], chart.corners[2], &[]);
            chart.add(FeatureDraft::point(Class::UWTROC, edge));
            chart
        },
        BLOCKS,
    ),
    (
        "a rock at two nodes",
        || {
            let mut chart = Chart::deep();
            let nodes = [WEST, EAST].map(|place| chart.cell.records.isolated_node(at(place)).forward());
            let rock = chart.add(FeatureDraft::line(Class::UWTROC, &nodes));
            chart.as_primitive(rock, 1);
            chart
        },
        Must::Block(&[WEST, EAST]),
    ),
    (
        "a line of nodes",
        || {
            let mut chart = Chart::deep();
            let nodes = [WEST, EAST].map(|place| chart.cell.records.isolated_node(at(place)).forward());
            chart.add(FeatureDraft::line(Class::OBSTRN, &nodes));
            chart
        },
        Must::Block(&[WEST, EAST]),
    ),
    (
        "a danger one of whose two edges is not there",
        || bulge(Class::OBSTRN, |chart, straight| vec![chart.ghost_edge().forward(), straight]),
        Must::Refuse("OBSTRN 3"),
    ),
    (
        "a danger that leaves one of its two edges out",
        || bulge(Class::OBSTRN, |_, straight| vec![straight]),
        Must::Refuse("OBSTRN 3"),
    ),
    (
        "land one of whose two edges is not there",
        || bulge(Class::LNDARE, |chart, straight| vec![chart.ghost_edge().forward(), straight]),
        Must::Refuse("LNDARE 3"),
    ),
    (
        "a coastline one of whose edges is not there",
        || bulge(Class::COALNE, |chart, straight| vec![straight, chart.ghost_edge().forward()]),
        Must::Refuse("COALNE 3"),
    ),
    (
        "a danger at the end of whose edge there is no node",
        || {
            let mut chart = Chart::deep();
            let ghost = chart.ghost_node();
            let edge = chart.cell.records.edge(chart.corners[0], ghost, &[]).forward();
            chart.add(FeatureDraft::line(Class::OBSTRN, &[edge]));
            chart
        },
        Must::Refuse("OBSTRN 3"),
    ),
    (
        "a danger one of whose edges runs the wrong way",
        || danger(|ring| vec![ring[0], ring[1].turned(), ring[2], ring[3]]),
        BLOCKS,
    ),
    ("a danger whose ring is there twice", || danger(|ring| [ring, ring].concat()), BLOCKS),
    (
        "a danger that is its own hole",
        || danger(|ring| ring.iter().copied().chain(ring.iter().map(|edge| edge.interior())).collect()),
        BLOCKS,
    ),
    (
        "a danger that is a hole alone",
        || danger(|ring| ring.iter().map(|edge| edge.interior()).collect()),
        BLOCKS,
    ),
    (
        "a danger whose ring crosses itself",
        || ring_of(&[LARGE[0], LARGE[2], LARGE[1], LARGE[3]]),
        Must::Block(&[NORTH, SOUTH]),
    ),
    (
        "a danger whose ring runs round its middle twice",
        || {
            ring_of(&[
                (63.004, 10.012),
                (63.017, 10.02),
                (63.004, 10.028),
                (63.013, 10.009),
                (63.013, 10.031),
            ])
        },
        BLOCKS,
    ),
    ("a danger of one edge from a node to itself", || ring_of(&[MIDDLE]), BLOCKS),
    ("a danger of one edge there and back", || ring_of(&[(63.005, 10.02), (63.015, 10.02)]), BLOCKS),
    ("an area that says it is a point", || as_primitive(1), BLOCKS),
    ("an area that says it is a line", || as_primitive(2), BLOCKS),
    ("an area that says it is not a shape", || as_primitive(255), Must::Refuse("OBSTRN 3 has no position")),
    (
        "an area of a primitive that does not exist",
        || as_primitive(0),
        Must::Refuse("OBSTRN 3 has no position"),
    ),
    (
        "an edge round the globe",
        || {
            let mut chart = Chart::deep();
            let far = chart.cell.records.connected_node(at((63.0, -175.0)));
            let edge = chart.cell.records.edge(chart.corners[0], far, &[]).forward();
            chart.add(FeatureDraft::line(Class::OBSTRN, &[edge]));
            chart
        },
        Must::Refuse("more than 180 degrees of longitude"),
    ),
    (
        "depth areas with a gap",
        || halves(("20", [(63.0, 10.018), (63.02, 10.018)]), ("20", [(63.0, 10.022), (63.02, 10.022)])),
        BLOCKS,
    ),
    (
        "depth areas that overlap, the shallow one under the other",
        || halves(("20", [(63.0, 10.039), (63.02, 10.039)]), ("1", AXIS)),
        BLOCKS_EAST,
    ),
    (
        "depth areas that overlap, a deep and an unknown one",
        || halves(("20", [(63.0, 10.039), (63.02, 10.039)]), ("", AXIS)),
        BLOCKS_EAST,
    ),
    (
        "depth areas whose borders cross without a node",
        || halves(("20", LEANING), ("20", COUNTER)),
        Must::Block(&[(63.003, 10.02)]),
    ),
    (
        "a deep area whose border crosses that of a shallow one",
        || halves(("20", LEANING), ("1", AXIS)),
        Must::Block(&[(63.015, 10.0215), EAST]),
    ),
    (
        "a depth area that is missing",
        || {
            let mut chart = Chart::bare();
            chart.cover();
            chart
        },
        Must::Refuse("no depth areas"),
    ),
    (
        "half of the depth areas missing",
        || {
            let mut chart = western(|_| ());
            chart.cover();
            chart
        },
        BLOCKS_EAST,
    ),
    ("a hole with nothing in it", || hole(ISLAND, VectorUse::interior), BLOCKS),
    ("an island that is a second exterior", || hole(ISLAND, |edge| edge), BLOCKS),
    (
        "a hole beyond its area",
        || {
            let mut chart = Chart::bare();
            chart.cover();
            let mut bounds: Vec<_> = chart
                .ring(&square((63.0, 10.0), (63.02, 10.02)))
                .into_iter()
                .map(VectorRef::forward)
                .collect();
            bounds.extend(chart.ring(&EASTERN).into_iter().map(|edge| edge.forward().interior()));
            chart.add(FeatureDraft::area(Class::DEPARE, &bounds).with(Attr::DRVAL1, "20"));
            chart
        },
        BLOCKS_EAST,
    ),
    (
        "land with depths over it",
        || {
            let mut chart = Chart::deep();
            chart.area(Class::LNDARE, &ISLAND, &[]);
            chart
        },
        BLOCKS,
    ),
    (
        "a depth area one of whose edges is not there",
        || {
            let mut chart = Chart::bare();
            chart.cover();
            let mut ring = chart.outline();
            ring[2] = chart.ghost_edge().forward();
            chart.add(FeatureDraft::area(Class::DEPARE, &ring).with(Attr::DRVAL1, "20"));
            chart.area(Class::DEPARE, &ISLAND, &[(Attr::DRVAL1, "2")]);
            chart
        },
        BLOCKS,
    ),
    (
        "a depth area that leaves an edge out",
        || {
            let mut chart = Chart::bare();
            chart.cover();
            let ring = &chart.outline()[..3];
            chart.cell.records.feature(FeatureDraft::area(Class::DEPARE, ring).with(Attr::DRVAL1, "20"));
            chart.area(Class::DEPARE, &ISLAND, &[(Attr::DRVAL1, "2")]);
            chart
        },
        BLOCKS,
    ),
    (
        "coverage one of whose edges is not there",
        || {
            western(|chart| {
                let mut ring = chart.ring(&square((63.0, 10.02), (63.02, 10.04)));
                chart.area(Class::DEPARE, &square((63.0, 10.02), (63.02, 10.04)), &[(Attr::DRVAL1, "1")]);
                ring[1] = chart.ghost_edge();
                let ring: Vec<_> = ring.into_iter().map(VectorRef::forward).collect();
                chart.add(FeatureDraft::area(Class::M_COVR, &ring).with(Attr::CATCOV, "1"));
            })
        },
        Must::Refuse("M_COVR 4"),
    ),
    (
        "coverage whose ring crosses itself",
        || {
            let mut chart = Chart::bare();
            let crossed = [LARGE[0], (63.018, 10.034), (63.018, 10.008), LARGE[3]];
            chart.area(Class::M_COVR, &crossed, &[(Attr::CATCOV, "1")]);
            chart.water("1");
            chart
        },
        Must::Block(&[NORTH, SOUTH]),
    ),
    (
        "coverage without its category",
        || {
            let mut chart = Chart::bare();
            let outline = chart.outline();
            chart.add(FeatureDraft::area(Class::M_COVR, &outline));
            chart.water("20");
            chart
        },
        Must::Refuse("M_COVR"),
    ),
    (
        "a rock beyond what the cell covers",
        || {
            western(|chart| {
                let node = chart.cell.records.isolated_node(at(EAST));
                chart.add(FeatureDraft::point(Class::UWTROC, node));
            })
        },
        BLOCKS_EAST,
    ),
    (
        "a danger beyond what the cell covers",
        || {
            western(|chart| {
                chart.area(Class::OBSTRN, &EASTERN, &[]);
            })
        },
        BLOCKS_EAST,
    ),
    (
        "a shoal beyond what the cell covers",
        || {
            western(|chart| {
                chart.area(Class::DEPARE, &EASTERN, &[(Attr::DRVAL1, "1")]);
            })
        },
        BLOCKS_EAST,
    ),
    (
        "land beyond what the cell covers",
        || {
            western(|chart| {
                chart.area(Class::LNDARE, &EASTERN, &[]);
            })
        },
        BLOCKS_EAST,
    ),
    (
        "deep water beyond what the cell covers, in no other chart",
        || {
            let mut chart = western(|chart| {
                chart.area(Class::DEPARE, &EASTERN, &[(Attr::DRVAL1, "20")]);
            });
            chart.area(Class::UNSARE, &EASTERN, &[]);
            chart
        },
        BLOCKS_EAST,
    ),
    (
        "an unreadable shoal of a chart that covers by its skin",
        || {
            let mut chart = western(|_| ());
            let mut ring: Vec<_> = chart.ring(&EASTERN).into_iter().map(VectorRef::forward).collect();
            ring[1] = ring[1].turned();
            chart.add(FeatureDraft::area(Class::DEPARE, &ring).with(Attr::DRVAL1, "1"));
            chart
        },
        BLOCKS_EAST,
    ),
];
