//! Which class is drawn in which layer.

use charts::depth_index::is_obstacle;
use charts::s57::ObjectClass as Class;

/// The layers of a tile, in the order in which they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layer {
    Cover,
    Water,
    Land,
    Area,
    Contour,
    Coast,
    Overhead,
    Sounding,
    Danger,
    Aid,
    Name,
}

/// The kind of a geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Point,
    Line,
    Area,
}

impl Layer {
    pub(crate) const ALL: [Self; 11] = [
        Self::Cover,
        Self::Water,
        Self::Land,
        Self::Area,
        Self::Contour,
        Self::Coast,
        Self::Overhead,
        Self::Sounding,
        Self::Danger,
        Self::Aid,
        Self::Name,
    ];

    /// Its name in the tile.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Cover => "cover",
            Self::Water => "water",
            Self::Land => "land",
            Self::Area => "area",
            Self::Contour => "contour",
            Self::Coast => "coast",
            Self::Overhead => "overhead",
            Self::Sounding => "sounding",
            Self::Danger => "danger",
            Self::Aid => "aid",
            Self::Name => "name",
        }
    }

    /// The zoom from which it is drawn.
    pub(crate) fn first_zoom(self) -> u8 {
        match self {
            Self::Cover | Self::Water | Self::Land | Self::Coast => 0,
            Self::Contour => 8,
            Self::Danger | Self::Overhead | Self::Sounding | Self::Area | Self::Aid | Self::Name => 9,
        }
    }

    /// Where a class is drawn; names come on top of that.
    pub(crate) fn of(class: Class, kind: Kind) -> Option<Self> {
        Some(match (class.acronym()?, kind) {
            ("M_COVR", Kind::Area) => Self::Cover,
            ("DEPARE" | "DRGARE" | "UNSARE", Kind::Area) => Self::Water,
            (
                "LNDARE" | "PONTON" | "HULKES" | "FLODOC" | "DRYDOC" | "DAMCON" | "CAUSWY" | "DYKCON"
                | "SLCONS" | "COALNE",
                Kind::Area,
            ) => Self::Land,
            ("DEPCNT", Kind::Line) => Self::Contour,
            ("BRIDGE" | "CBLOHD" | "PIPOHD" | "CONVYR", _) => Self::Overhead,
            (
                "COALNE" | "SLCONS" | "LNDARE" | "PONTON" | "HULKES" | "FLODOC" | "DRYDOC" | "DAMCON"
                | "CAUSWY" | "DYKCON" | "GATCON",
                Kind::Line,
            ) => Self::Coast,
            ("OBSTRN" | "UWTROC" | "WRECKS", _)
            | (
                "LNDARE" | "SLCONS" | "PONTON" | "HULKES" | "FLODOC" | "DRYDOC" | "DAMCON" | "CAUSWY"
                | "DYKCON" | "COALNE",
                Kind::Point,
            ) => Self::Danger,
            (
                "BCNCAR" | "BCNISD" | "BCNLAT" | "BCNSAW" | "BCNSPP" | "BOYCAR" | "BOYINB" | "BOYISD"
                | "BOYLAT" | "BOYSAW" | "BOYSPP" | "LIGHTS" | "LITFLT" | "LITVES" | "DAYMAR",
                Kind::Point,
            ) => Self::Aid,
            (
                "RESARE" | "CTNARE" | "FAIRWY" | "HRBARE" | "ACHARE" | "MIPARE" | "PRCARE" | "CBLARE"
                | "PIPARE" | "DMPGRD" | "FSHGRD" | "TSSLPT" | "TSSRON" | "TSEZNE" | "ISTZNE" | "DWRTPT"
                | "SPLARE" | "TESARE",
                Kind::Area,
            ) => Self::Area,
            _ if is_obstacle(class) => Self::Danger,
            _ => return None,
        })
    }

    /// Whether the name of such an object is written on the map.
    pub(crate) fn names(class: Class) -> bool {
        let named =
            ["LNDARE", "LNDRGN", "SEAARE", "BUAARE", "HRBARE", "LAKARE", "RIVERS", "SBDARE", "FAIRWY"];
        class.acronym().is_some_and(|acronym| named.contains(&acronym))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::depth_index::is_in_the_way;
    use charts::s57::{Area, Feature, GeoPoint, Geometry, ObjectId, Path};

    #[test]
    fn whatever_the_guard_stops_for_is_drawn() {
        let at = GeoPoint { lon_deg: 10.0, lat_deg: 63.0 };
        let kinds = [
            (Kind::Point, Geometry::Point(at)),
            (Kind::Line, Geometry::Lines(vec![Path::default()])),
            (Kind::Area, Geometry::Area(Area::default())),
        ];
        let mut stops = 0;
        for class in (0..=u16::MAX).map(Class).filter(|class| class.acronym().is_some()) {
            for (kind, geometry) in kinds.clone() {
                let feature = Feature {
                    record: 1,
                    object: ObjectId::default(),
                    class,
                    group: 2,
                    version: 1,
                    attributes: vec![],
                    national: vec![],
                    links: vec![],
                    geometry,
                };
                // Waters are areas, soundings have a layer of their own.
                let odd = ["DEPARE", "DRGARE", "UNSARE", "SOUNDG"].map(Some).contains(&class.acronym());
                if is_in_the_way(&feature) && !(odd && kind != Kind::Area) && class != Class::SOUNDG {
                    stops += 1;
                    assert!(Layer::of(class, kind).is_some(), "{class} as {kind:?}");
                }
            }
        }
        assert!(stops > 100, "{stops}");
    }
}
