//! Updates that come out of order, take away what others need, or change what is not there.

use super::chart::{Chart, MIDDLE, at};
use super::shapes::{EAST, WEST};
use super::{BLOCKS, Must, Row};
use charts::s57::write::{
    FeatureChange, FeatureDraft, FeatureRef, ListEdit, UpdateDraft, VectorChange, VectorRef,
};
use charts::s57::{AttributeCode as Attr, ObjectClass as Class};

/// A rock in the middle with 1 m over it, its node, and an update.
fn rock(change: fn(&mut UpdateDraft, VectorRef, FeatureRef)) -> Chart {
    let mut chart = Chart::deep();
    let node = chart.cell.records.isolated_node(at(MIDDLE));
    let rock = chart.add(FeatureDraft::point(Class::UWTROC, node).with(Attr::VALSOU, "1"));
    chart.update(|update| change(update, node, rock));
    chart
}

/// A danger from the west over the middle to the east, of two edges without vertices, and an update.
fn bar(change: fn(&mut UpdateDraft, [VectorRef; 2], FeatureRef)) -> Chart {
    let mut chart = Chart::deep();
    let [west, middle, east] = [WEST, MIDDLE, EAST].map(|place| chart.cell.records.connected_node(at(place)));
    let edges = [chart.cell.records.edge(west, middle, &[]), chart.cell.records.edge(middle, east, &[])];
    let bar = chart.add(FeatureDraft::line(Class::OBSTRN, &edges.map(VectorRef::forward)));
    chart.update(|update| change(update, edges, bar));
    chart
}

/// A danger around the middle, its ring, and an update.
fn area(change: fn(&mut UpdateDraft, &[VectorRef], FeatureRef)) -> Chart {
    let mut chart = Chart::deep();
    let ring = chart.ring(&[(63.006, 10.012), (63.014, 10.012), (63.014, 10.028), (63.006, 10.028)]);
    let bounds: Vec<_> = ring.iter().map(|edge| edge.forward()).collect();
    let area = chart.add(FeatureDraft::area(Class::OBSTRN, &bounds));
    chart.update(|update| change(update, &ring, area));
    chart
}

/// Two updates of a rock's depth, whose numbers are as given.
fn numbered(first: &str, second: &str) -> Chart {
    let mut chart = Chart::deep();
    let rock = chart.rock(&[(Attr::VALSOU, "30")]);
    let mut changed = rock;
    for number in [first, second] {
        chart.update(|update| {
            changed = update.records.change_feature(FeatureChange::of(changed).with(Attr::VALSOU, "1"));
            number.clone_into(&mut update.id.update);
        });
    }
    chart
}

fn identity(change: fn(&mut UpdateDraft)) -> Chart {
    let mut chart = Chart::deep();
    chart.update(change);
    chart
}

fn skin(change: fn(&mut UpdateDraft, FeatureRef, FeatureRef)) -> Chart {
    let mut chart = Chart::bare();
    let (cover, water) = (chart.cover(), chart.water("20"));
    chart.update(|update| change(update, cover, water));
    chart
}

fn side(change: fn(&mut UpdateDraft, &Chart)) -> Chart {
    let mut chart = Chart::deep();
    let mut update = UpdateDraft::new(&chart.cell, 1);
    change(&mut update, &chart);
    chart.updates.push(update);
    chart
}

const fn delete<T>(index: usize, count: usize) -> ListEdit<T> {
    ListEdit::Delete { index, count }
}

pub(super) const ROWS: &[Row] = &[
    (
        "an update that is missing",
        || numbered("1", "3"),
        Must::Refuse("this is update 3, but the next must be update 2"),
    ),
    (
        "updates in the wrong order",
        || numbered("2", "1"),
        Must::Refuse("this is update 2, but the next must be update 1"),
    ),
    (
        "an update that is there twice",
        || numbered("1", "1"),
        Must::Refuse("this is update 1, but the next must be update 2"),
    ),
    (
        "an update without a number",
        || numbered("1", ""),
        Must::Refuse("the update number (UPDN) is out of range"),
    ),
    (
        "an update whose number is not a number",
        || numbered("1", "two"),
        Must::Refuse("the update number (UPDN) is out of range"),
    ),
    (
        "an update of another cell",
        || identity(|update| "NO5X0059.000".clone_into(&mut update.id.name)),
        Must::Refuse("the update is for cell NO5X0059.000"),
    ),
    (
        "an update of another edition",
        || identity(|update| "2".clone_into(&mut update.id.edition)),
        Must::Refuse("the update is for edition 2"),
    ),
    (
        "an update that is a base cell",
        || identity(|update| update.id.purpose = 1),
        Must::Refuse("a base cell, not an update"),
    ),
    (
        "an update that deletes the node of a rock",
        || rock(|update, node, _| update.records.delete_vector(node)),
        BLOCKS,
    ),
    (
        "an update that empties the node of a rock",
        || {
            rock(|update, node, _| {
                update.records.change_vector(VectorChange::of(node).vertices(delete(1, 1)));
            })
        },
        BLOCKS,
    ),
    (
        "an update that gives a rock's node a second position",
        || {
            rock(|update, node, _| {
                let items = vec![at(WEST)];
                update
                    .records
                    .change_vector(VectorChange::of(node).vertices(ListEdit::Insert { index: 1, items }));
            })
        },
        Must::Block(&[MIDDLE, WEST]),
    ),
    (
        "an update that takes the depth of a rock away",
        || {
            rock(|update, _, rock| {
                update.records.change_feature(FeatureChange::of(rock).without(Attr::VALSOU));
            })
        },
        BLOCKS,
    ),
    (
        "an update that deletes a node twice",
        || {
            rock(|update, node, _| {
                update.records.delete_vector(node);
                update.records.delete_vector(node);
            })
        },
        Must::Refuse("vector record 1 is to be changed or deleted, but not there"),
    ),
    (
        "an update that deletes an object twice",
        || {
            rock(|update, _, rock| {
                update.records.delete_feature(rock);
                update.records.delete_feature(rock);
            })
        },
        Must::Refuse("feature 3 is to be changed or deleted, but not there"),
    ),
    (
        "an update that changes what it deleted",
        || {
            rock(|update, _, rock| {
                update.records.delete_feature(rock);
                update.records.change_feature(FeatureChange::of(rock).with(Attr::VALSOU, "30"));
            })
        },
        Must::Refuse("feature 3 is to be changed or deleted, but not there"),
    ),
    (
        "an update that means another object",
        || {
            rock(|update, _, rock| {
                let other = charts::s57::ObjectId { number: rock.object.number + 1, ..rock.object };
                update.records.change_feature(
                    FeatureChange::of(FeatureRef { object: other, ..rock }).with(Attr::VALSOU, "30"),
                );
            })
        },
        Must::Refuse("feature 3 is another object than the update means"),
    ),
    (
        "an update that deletes an edge of a danger",
        || bar(|update, edges, _| update.records.delete_vector(edges[0])),
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that deletes all edges of a danger",
        || {
            bar(|update, edges, _| {
                for edge in edges {
                    update.records.delete_vector(edge);
                }
            })
        },
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that takes the nodes of an edge away",
        || {
            bar(|update, edges, _| {
                update.records.change_vector(VectorChange::of(edges[0]).nodes(delete(1, 2)));
            })
        },
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that takes one node of an edge away",
        || {
            bar(|update, edges, _| {
                update.records.change_vector(VectorChange::of(edges[0]).nodes(delete(1, 1)));
            })
        },
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that takes the nodes of both edges away",
        || {
            bar(|update, edges, _| {
                for edge in edges {
                    update.records.change_vector(VectorChange::of(edge).nodes(delete(1, 2)));
                }
            })
        },
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that takes all edges off a danger",
        || {
            bar(|update, _, bar| {
                update.records.change_feature(FeatureChange::of(bar).edges(delete(1, 2)));
            })
        },
        Must::Block(&[MIDDLE, WEST, EAST]),
    ),
    (
        "an update that leads a danger to an edge that is not there",
        || {
            bar(|update, _, bar| {
                let mut elsewhere = update.records.clone();
                let (from, to) = (elsewhere.connected_node(at(WEST)), elsewhere.connected_node(at(EAST)));
                let ghost = elsewhere.edge(from, to, &[]).forward();
                update.records.change_feature(
                    FeatureChange::of(bar).edges(ListEdit::Replace { index: 1, items: vec![ghost] }),
                );
            })
        },
        Must::Refuse("OBSTRN 3"),
    ),
    (
        "an update that deletes an edge of an area",
        || area(|update, ring, _| update.records.delete_vector(ring[1])),
        BLOCKS,
    ),
    (
        "an update that takes an edge off an area",
        || {
            area(|update, _, area| {
                update.records.change_feature(FeatureChange::of(area).edges(delete(1, 1)));
            })
        },
        Must::Block(&[MIDDLE, (63.01, 10.0125)]),
    ),
    (
        "an update that takes two edges off an area",
        || {
            area(|update, _, area| {
                update.records.change_feature(FeatureChange::of(area).edges(delete(2, 2)));
            })
        },
        Must::Block(&[MIDDLE, (63.013, 10.027)]),
    ),
    (
        "an update that takes more edges off than there are",
        || {
            area(|update, _, area| {
                update.records.change_feature(FeatureChange::of(area).edges(delete(1, 5)));
            })
        },
        Must::Refuse("changed beyond the end of a list"),
    ),
    (
        "an update that deletes the only depth area",
        || skin(|update, _, water| update.records.delete_feature(water)),
        Must::Refuse("no depth areas"),
    ),
    (
        "an update that deletes the coverage",
        || skin(|update, cover, _| update.records.delete_feature(cover)),
        Must::Refuse("M_COVR"),
    ),
    (
        "an update that takes DRVAL1 away",
        || {
            skin(|update, _, water| {
                update.records.change_feature(FeatureChange::of(water).without(Attr::DRVAL1));
            })
        },
        BLOCKS,
    ),
    (
        "an update that takes the edges off the only depth area",
        || {
            skin(|update, _, water| {
                update.records.change_feature(FeatureChange::of(water).edges(delete(1, 4)));
            })
        },
        Must::Refuse("no depth areas"),
    ),
    (
        "an update that deletes an edge of water and coverage",
        || side(|update, chart| update.records.delete_vector(chart.sides[1])),
        Must::Refuse("M_COVR 1"),
    ),
    (
        "an update that deletes a corner of water and coverage",
        || side(|update, chart| update.records.delete_vector(chart.corners[2])),
        Must::Refuse("M_COVR 1"),
    ),
];
