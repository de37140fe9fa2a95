//! Whether a piece that was read leads nowhere outside of its own tables: what is damaged beyond its checksum is refused.

use super::piece::Piece;
use super::places::{Places, WHOLE};
use super::ring::Ring;
use super::tree::NO_DATA;

/// Whether every number that points leads into its table.
pub(super) fn is_sound(piece: &Piece) -> bool {
    let within = |first: u32, count: u32, length: usize| {
        first.checked_add(count).is_some_and(|end| end as usize <= length)
    };
    let areas = &piece.areas;
    let vertices = areas.vertices.len();
    let own = piece.own_vertices as usize;
    let rings_sound = areas.rings.iter().all(|ring| {
        let boxes = Ring::box_count(ring.segments()) as u32;
        ring.count >= 2 && within(ring.first, ring.count, own) && within(ring.boxes, boxes, areas.boxes.len())
    });
    let areas_sound = areas.list.iter().all(|area| {
        within(area.first_ring, area.rings, areas.rings.len()) && area.object < piece.own_objects
    });
    let lines_sound =
        piece.lines.iter().all(|line| within(line.first, line.count, own) && line.object < piece.own_objects);
    let trees_sound = piece.trees.iter().all(|tree| {
        tree.runs.iter().all(|run| {
            let known = (run.object as usize) < piece.objects.len();
            run.count >= 1 && within(run.first, run.count, vertices) && (known || run.object == NO_DATA)
        })
    });
    // Only the trees of dangers and of quality may hold the border of what is charted or assessed.
    let named = piece.trees[2..].iter().all(|tree| tree.runs.iter().all(|run| run.object != NO_DATA));
    let sourced = piece.objects.iter().all(|object| (object.source as usize) < piece.charts.len());
    let owned = piece.own_objects as usize <= piece.objects.len() && own <= vertices;
    owned
        && rings_sound
        && areas_sound
        && lines_sound
        && trees_sound
        && named
        && sourced
        && places_sound(piece)
}

fn places_sound(piece: &Piece) -> bool {
    let Places { side, nodes, entries, .. } = &piece.places;
    if nodes.is_empty() {
        return entries.is_empty();
    }
    let sided = *side > 0 && *side <= 1 << 33 && (*side as u64).is_power_of_two();
    // Children come after their parents, so that no walk goes in circles.
    let noded = nodes.iter().enumerate().all(|(at, node)| {
        if node.is_inner() {
            node.first as usize > at && (node.first as usize).saturating_add(4) <= nodes.len()
        } else {
            (node.first as usize).saturating_add(node.count as usize) <= entries.len()
        }
    });
    sided && noded && entries.iter().all(|entry| ((entry & !WHOLE) as usize) < piece.areas.list.len())
}
