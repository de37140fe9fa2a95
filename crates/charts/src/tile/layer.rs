//! Which class is drawn in which layer.

use crate::s57::ObjectClass as Class;

/// The layers of a tile, in the order in which they are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Layer {
    Cover,
    Water,
    Land,
    Area,
    Contour,
    Coast,
    Sounding,
    Danger,
    Aid,
    Name,
}

/// What a geometry is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Point,
    Line,
    Area,
}

impl Layer {
    pub(super) const ALL: [Self; 10] = [
        Self::Cover,
        Self::Water,
        Self::Land,
        Self::Area,
        Self::Contour,
        Self::Coast,
        Self::Sounding,
        Self::Danger,
        Self::Aid,
        Self::Name,
    ];

    /// Its name in the tile.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cover => "cover",
            Self::Water => "water",
            Self::Land => "land",
            Self::Area => "area",
            Self::Contour => "contour",
            Self::Coast => "coast",
            Self::Sounding => "sounding",
            Self::Danger => "danger",
            Self::Aid => "aid",
            Self::Name => "name",
        }
    }

    /// The zoom from which it is drawn.
    pub(super) fn first_zoom(self) -> u8 {
        match self {
            Self::Cover | Self::Water | Self::Land | Self::Coast => 0,
            Self::Contour => 8,
            Self::Danger | Self::Sounding | Self::Area | Self::Aid | Self::Name => 9,
        }
    }

    /// Where a class is drawn by itself; names come on top of that.
    pub(super) fn of(class: Class, kind: Kind) -> Option<Self> {
        Some(match (class.acronym()?, kind) {
            ("M_COVR", Kind::Area) => Self::Cover,
            ("DEPARE" | "DRGARE" | "UNSARE", Kind::Area) => Self::Water,
            (
                "LNDARE" | "PONTON" | "HULKES" | "FLODOC" | "DRYDOC" | "DAMCON" | "CAUSWY" | "DYKCON"
                | "SLCONS",
                Kind::Area,
            ) => Self::Land,
            ("DEPCNT", Kind::Line) => Self::Contour,
            (
                "COALNE" | "SLCONS" | "LNDARE" | "PONTON" | "DAMCON" | "CAUSWY" | "DYKCON" | "GATCON",
                Kind::Line,
            ) => Self::Coast,
            (
                "OBSTRN" | "UWTROC" | "WRECKS" | "PILPNT" | "MARCUL" | "FSHFAC" | "OFSPLF" | "PYLONS"
                | "LOGPON" | "MORFAC" | "OILBAR",
                _,
            )
            | ("LNDARE" | "SLCONS" | "PONTON" | "HULKES", Kind::Point) => Self::Danger,
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
            _ => return None,
        })
    }

    /// Whether the name of such an object is written on the map.
    pub(super) fn names(class: Class) -> bool {
        let named =
            ["LNDARE", "LNDRGN", "SEAARE", "BUAARE", "HRBARE", "LAKARE", "RIVERS", "SBDARE", "FAIRWY"];
        class.acronym().is_some_and(|acronym| named.contains(&acronym))
    }
}
