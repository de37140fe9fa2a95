//! The kinds of damage that validation by IHO S-58 (recommended ENC validation checks) looks for, one row each.
//!
//! A damaged cell is refused by name, or what is damaged blocks its place. It never makes a place safe. The wording of
//! the kinds and the cells are of our own making; S-58 itself is not copied.

mod chart;
mod records;
mod shapes;
mod updates;
mod values;

use chart::{At, Chart, MIDDLE, indices, is_safe_past};

/// The required result for a damaged cell.
pub(crate) enum Must {
    /// It is refused in these words.
    Refuse(&'static str),
    /// It is read, and none of these places is safe.
    Block(&'static [At]),
}

/// A kind of damage, what makes it, and the required result.
pub(crate) type Row = (&'static str, fn() -> Chart, Must);

/// The middle of the chart is not safe.
pub(crate) const BLOCKS: Must = Must::Block(&[MIDDLE]);

fn verdict(chart: &Chart, must: &Must) -> Result<(), String> {
    match (chart.read(), must) {
        (Err(why), Must::Refuse(words)) if why.contains(words) && why.starts_with("NO5X0058.") => Ok(()),
        (Err(why), _) => Err(format!("refused: {why}")),
        (Ok(cell), must) => {
            let places = if let Must::Block(places) = must { *places } else { &[MIDDLE][..] };
            for (which, index) in indices(&cell) {
                if let Some(place) = places.iter().find(|place| is_safe_past(&index, **place)) {
                    return Err(format!("{place:?} is safe {which}; notices {:?}", cell.notices));
                }
            }
            if let Must::Refuse(words) = must { Err(format!("not refused by {words:?}")) } else { Ok(()) }
        }
    }
}

fn hold(rows: &[Row]) {
    let failed: Vec<_> = rows
        .iter()
        .filter_map(|(name, damage, must)| verdict(&damage(), must).err().map(|why| format!("{name}: {why}")))
        .collect();
    assert!(failed.is_empty(), "{} of {}:\n{}", failed.len(), rows.len(), failed.join("\n"));
}

#[test]
fn an_undamaged_chart_is_safe_where_the_others_are_not() {
    let cell = Chart::deep().read().unwrap();
    for (which, index) in indices(&cell) {
        for place in [MIDDLE, shapes::WEST, shapes::EAST, shapes::CORNER] {
            assert!(is_safe_past(&index, place), "{place:?} {which}");
        }
    }
    let mut rock = Chart::deep();
    rock.rock(&[]);
    let cell = rock.read().unwrap();
    for (_, index) in indices(&cell) {
        assert!(!is_safe_past(&index, MIDDLE) && is_safe_past(&index, shapes::WEST));
    }
}

#[test]
fn damaged_values_are_not_safe() {
    hold(values::ROWS);
}

#[test]
fn damaged_shapes_are_not_safe() {
    hold(shapes::ROWS);
}

#[test]
fn damaged_records_are_not_safe() {
    hold(records::ROWS);
}

#[test]
fn damaging_updates_are_not_safe() {
    hold(updates::ROWS);
}
