//! A made-up sea chart: a square of deep water with shoals, islets, dangers and holes put into it, in metres
//! around its middle. Not for navigation.

use charts::coverage::Source;
use charts::depth_index::{DepthIndex, IndexBuilder};
use charts::s57::{Area, Attribute, AttributeCode, Feature, GeoPoint, Geometry, ObjectClass, ObjectId, Path};
use units::{LatLon, LocalFrame, LocalPoint};

/// An object or area of a [`Sea`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ground {
    /// Land.
    Land,
    /// Water that is at least so deep (m).
    Depth(f64),
    /// Nothing is charted. Holes must not touch anything else.
    Hole,
    /// A danger of unknown depth.
    Danger,
    /// Water as deep as around, in an area with this restriction (RESTRN).
    Entry(u32),
}

impl Ground {
    /// Whether it is charted as at least so deep.
    pub fn is_deep(self, least_m: f64) -> bool {
        match self {
            Self::Depth(depth_m) => depth_m >= least_m,
            Self::Entry(_) => true,
            Self::Land | Self::Hole | Self::Danger => false,
        }
    }
}

/// A convex polygon in the sea.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Its kind.
    pub ground: Ground,
    /// Corners, in order, north and east of the middle (m).
    pub corners: Vec<LocalPoint>,
}

/// A chart of a square of water.
#[derive(Debug, Clone, PartialEq)]
pub struct Sea {
    frame: LocalFrame,
    half_m: f64,
    depth_m: f64,
    patches: Vec<Patch>,
}

impl Sea {
    /// Water `depth_m` deep as far as `half_m` north, south, east and west of `middle`; around it no data.
    pub fn new(middle: LatLon, half_m: f64, depth_m: f64) -> Self {
        Self { frame: LocalFrame::new(middle), half_m, depth_m, patches: Vec::new() }
    }

    /// The frame that patches are given in.
    pub fn frame(&self) -> LocalFrame {
        self.frame
    }

    /// The objects in the water.
    pub fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// With a regular polygon of so many corners around a point.
    #[must_use]
    pub fn with(mut self, ground: Ground, at: LocalPoint, radius_m: f64, corners: u32) -> Self {
        let turn = std::f64::consts::TAU / f64::from(corners);
        let corners = (0..corners).map(|n| at.displaced(turn * f64::from(n), radius_m)).collect();
        self.patches.push(Patch { ground, corners });
        self
    }

    /// Whether it is charted as at least `least_m` deep everywhere within `radius_m` of a point.
    ///
    /// Found by looking at every polygon, without any index.
    pub fn is_deep_within(&self, at: LocalPoint, radius_m: f64, least_m: f64) -> bool {
        let edge_m = self.half_m - at.north_m.abs().max(at.east_m.abs());
        edge_m > radius_m
            && self.depth_m >= least_m
            && self
                .patches
                .iter()
                .filter(|patch| !patch.ground.is_deep(least_m))
                .all(|patch| patch.distance_m(at) > radius_m)
    }

    /// The index over it.
    ///
    /// # Panics
    /// When the sea leaves the globe.
    pub fn index(&self) -> DepthIndex {
        let square = [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)];
        let outer: Vec<LocalPoint> = square
            .iter()
            .map(|(n, e)| LocalPoint { north_m: n * self.half_m, east_m: e * self.half_m })
            .collect();
        // Where areas overlap the worst counts, so only what is charted nowhere is cut out.
        let holes = self.patches.iter().filter(|patch| patch.ground == Ground::Hole);
        let rings: Vec<Vec<LocalPoint>> = holes.map(|patch| patch.corners.clone()).collect();
        let mut features =
            vec![feature(1, ObjectClass::DEPARE, area(self.frame, &outer, &rings), Some(self.depth_m))];
        for (record, patch) in (2..).zip(&self.patches) {
            let shape = || area(self.frame, &patch.corners, &[]);
            match patch.ground {
                Ground::Land => features.push(feature(record, ObjectClass::LNDARE, shape(), None)),
                Ground::Depth(depth_m) => {
                    features.push(feature(record, ObjectClass::DEPARE, shape(), Some(depth_m)));
                }
                Ground::Danger => features.push(feature(record, ObjectClass::UNSARE, shape(), None)),
                Ground::Entry(restriction) => features.push(restricted(record, shape(), restriction)),
                Ground::Hole => {}
            }
        }
        // Covered everywhere: a hole is charted water without a depth area.
        let coverage = Feature {
            attributes: vec![attribute(AttributeCode::CATCOV, "1")],
            ..feature(0, ObjectClass::M_COVR, area(self.frame, &outer, &[]), None)
        };
        features.push(coverage);
        let source = Source {
            name: "XX5SEA01".to_owned(),
            edition: "1".to_owned(),
            update: "0".to_owned(),
            issue_date: "20260101".to_owned(),
            band: 5,
            scale: 10_000,
            ..Source::default()
        };
        let mut builder = IndexBuilder::new();
        builder.add_features(source, &features).expect("the sea is on the globe");
        builder.build().expect("the sea is small")
    }
}

impl Patch {
    /// Distance to a point (m); 0 inside.
    pub fn distance_m(&self, at: LocalPoint) -> f64 {
        let count = self.corners.len();
        let sides = (0..count).map(|n| (self.corners[n], self.corners[(n + 1) % count]));
        let mut inside = true;
        let mut nearest_m = f64::INFINITY;
        for (a, b) in sides {
            let (dn, de) = (b.north_m - a.north_m, b.east_m - a.east_m);
            let (pn, pe) = (at.north_m - a.north_m, at.east_m - a.east_m);
            // Corners run clockwise: inside is to the right of every side.
            inside &= dn * pe - de * pn >= 0.0;
            let t = ((pn * dn + pe * de) / (dn * dn + de * de)).clamp(0.0, 1.0);
            nearest_m = nearest_m.min((pn - t * dn).hypot(pe - t * de));
        }
        if inside { 0.0 } else { nearest_m }
    }
}

/// Water of one depth in a box (west, south, east, north; degrees), as the features of a chart that covers it.
pub fn open_water([west, south, east, north]: [f64; 4], depth_m: f64) -> (Source, [Feature; 2]) {
    let corners = [(west, south), (west, north), (east, north), (east, south), (west, south)];
    let points = corners.map(|(lon_deg, lat_deg)| GeoPoint { lon_deg, lat_deg }).to_vec();
    let geometry = || {
        Geometry::Area(Area {
            exteriors: vec![Path { points: points.clone(), edges: Vec::new() }],
            holes: Vec::new(),
        })
    };
    let coverage = Feature {
        attributes: vec![attribute(AttributeCode::CATCOV, "1")],
        ..feature(0, ObjectClass::M_COVR, geometry(), None)
    };
    let name = format!("XX{west:.1}{south:.1}");
    let source = Source { name, band: 5, scale: 10_000, ..Source::default() };
    (source, [coverage, feature(1, ObjectClass::DEPARE, geometry(), Some(depth_m))])
}

/// An area that the chart restricts (RESTRN).
pub fn restricted(record: u32, geometry: Geometry, restriction: u32) -> Feature {
    Feature {
        attributes: vec![attribute(AttributeCode::RESTRN, &restriction.to_string())],
        ..feature(record, ObjectClass::RESARE, geometry, None)
    }
}

fn area(frame: LocalFrame, outer: &[LocalPoint], inner: &[Vec<LocalPoint>]) -> Geometry {
    let ring = |corners: &[LocalPoint]| {
        let closed = corners.iter().chain(corners.first());
        let points = closed.map(|corner| {
            let place = frame.to_place(*corner);
            GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() }
        });
        Path { points: points.collect(), edges: Vec::new() }
    };
    Geometry::Area(Area {
        exteriors: vec![ring(outer)],
        holes: inner.iter().map(|hole| ring(hole)).collect(),
    })
}

fn attribute(code: AttributeCode, value: &str) -> Attribute {
    Attribute { code, value: value.to_owned() }
}

fn feature(record: u32, class: ObjectClass, geometry: Geometry, depth_m: Option<f64>) -> Feature {
    Feature {
        record,
        object: ObjectId::default(),
        class,
        group: 1,
        version: 1,
        attributes: depth_m
            .map(|depth_m| attribute(AttributeCode::DRVAL1, &depth_m.to_string()))
            .into_iter()
            .collect(),
        national: Vec::new(),
        links: Vec::new(),
        geometry,
    }
}
