//! Deep water with shoals, islets and dangers at random.

use super::{HOME, HULL_M, Numbers, Waters};
use crate::common::frame;
use onboard::Chart;
use testkit::sea::{Ground, Sea as Chartmaker};
use units::{LocalFrame, LocalPoint};

/// Around the start it is deep as far as this (m).
const HAVEN_M: f64 = 50.0;

/// A separate sea.
pub(crate) struct MadeUp(Chartmaker);

impl Waters for MadeUp {
    fn of(numbers: &mut Numbers) -> Self {
        let mut chart = Chartmaker::new(frame().origin(), 500.0, 15.0);
        let mut made = 0;
        while made < 20 {
            let (at, radius_m) = (numbers.point(320.0), numbers.within(5.0, 60.0));
            if at.distance_m(HOME) < radius_m + HAVEN_M {
                continue;
            }
            let ground = match made % 4 {
                0 => Ground::Land,
                1 => Ground::Depth(numbers.within(0.0, 0.9)),
                2 => Ground::Depth(numbers.within(1.5, 4.5)),
                _ => Ground::Danger,
            };
            chart = chart.with(ground, at, radius_m, 3 + made % 6);
            made += 1;
        }
        Self(chart)
    }

    fn chart(&self) -> Chart {
        Chart::of("made up", self.0.index())
    }

    fn frame(&self) -> LocalFrame {
        frame()
    }

    fn danger(&self, numbers: &mut Numbers, _least_m: f64) -> LocalPoint {
        self.0.patches()[(numbers.within(0.0, 20.0) as usize).min(19)].corners[0]
    }

    fn goals(&self, numbers: &mut Numbers) -> Vec<LocalPoint> {
        (0..3).map(|_| numbers.point(250.0)).collect()
    }

    fn has_room(&self, from: LocalPoint, to: LocalPoint, room_m: f64, least_m: f64) -> bool {
        let steps = from.distance_m(to).ceil().max(1.0);
        (0..=steps as u32).all(|n| {
            let t = f64::from(n) / steps;
            let mix = |a: f64, b: f64| a + t * (b - a);
            let at =
                LocalPoint { north_m: mix(from.north_m, to.north_m), east_m: mix(from.east_m, to.east_m) };
            self.0.is_deep_within(at, room_m, least_m)
        })
    }

    fn is_afloat(&self, at: LocalPoint, least_m: f64) -> bool {
        self.0.is_deep_within(at, HULL_M, least_m)
    }
}
