//! Structures, buoys, wrecks and named places of the fictitious sea. Places are metres east and north of
//! the demonstration's first Otter.

/// Attributes by acronym.
pub(super) type Attributes = &'static [(&'static str, &'static str)];

/// An object at a point, with its light if it has one.
pub(super) struct Mark {
    pub(super) class: &'static str,
    pub(super) at: [f64; 2],
    pub(super) attributes: Attributes,
    pub(super) lights: &'static [Attributes],
    /// Whether the approach cell shows it too.
    pub(super) coarse: bool,
    /// Whether it stands on the highest ground close by.
    pub(super) perched: bool,
}

/// A line or area of its own.
pub(super) struct Drawn {
    pub(super) class: &'static str,
    pub(super) points: &'static [[f64; 2]],
    pub(super) area: bool,
    pub(super) attributes: Attributes,
    pub(super) coarse: bool,
}

const fn mark(class: &'static str, at: [f64; 2], attributes: Attributes) -> Mark {
    Mark { class, at, attributes, lights: &[], coarse: false, perched: false }
}

const fn seen(class: &'static str, at: [f64; 2], attributes: Attributes) -> Mark {
    Mark { coarse: true, ..mark(class, at, attributes) }
}

const fn perched(class: &'static str, at: [f64; 2], attributes: Attributes) -> Mark {
    Mark { perched: true, ..mark(class, at, attributes) }
}

const PORT: Attributes = &[("BOYSHP", "4"), ("CATLAM", "1"), ("COLOUR", "3")];
const STARBOARD: Attributes = &[("BOYSHP", "4"), ("CATLAM", "2"), ("COLOUR", "4")];
const PERCH: Attributes = &[("BCNSHP", "1"), ("COLOUR", "2"), ("CONDTN", "1")];
const PILE: Attributes = &[("CATPLE", "3")];
const RED: Attributes =
    &[("COLOUR", "3"), ("LITCHR", "2"), ("SIGGRP", "(1)"), ("SIGPER", "3"), ("VALNMR", "3"), ("HEIGHT", "6")];
const GREEN: Attributes =
    &[("COLOUR", "4"), ("LITCHR", "2"), ("SIGGRP", "(1)"), ("SIGPER", "3"), ("VALNMR", "3"), ("HEIGHT", "6")];

macro_rules! sector {
    ($colour:literal, $from:literal, $to:literal) => {
        &[
            ("COLOUR", $colour),
            ("LITCHR", "8"),
            ("SIGGRP", "(2)"),
            ("SIGPER", "6"),
            ("SECTR1", $from),
            ("SECTR2", $to),
            ("VALNMR", "7"),
            ("HEIGHT", "14"),
        ]
    };
}

/// All marks, dangers and names.
pub(super) const MARKS: &[Mark] = &[
    // The fairway into the harbour; entering, southward, red is on the left.
    Mark { lights: &[RED], ..mark("BOYLAT", [522.0, -690.0], PORT) },
    Mark { lights: &[GREEN], ..mark("BOYLAT", [420.0, -690.0], STARBOARD) },
    mark("BOYLAT", [515.0, -800.0], PORT),
    mark("BOYLAT", [426.0, -800.0], STARBOARD),
    Mark {
        lights: &[RED],
        ..mark(
            "BCNLAT",
            [527.0, -905.0],
            &[("BCNSHP", "3"), ("CATLAM", "1"), ("COLOUR", "3"), ("OBJNAM", "Moloen aust")],
        )
    },
    Mark {
        lights: &[GREEN],
        ..mark(
            "BCNLAT",
            [418.0, -915.0],
            &[("BCNSHP", "3"), ("CATLAM", "2"), ("COLOUR", "4"), ("OBJNAM", "Moloen vest")],
        )
    },
    mark("PILPNT", [330.0, -1_080.0], PILE),
    mark("PILPNT", [330.0, -1_130.0], PILE),
    // The lighthouse on Lyktholmen, whose white sector leads clear of the skerries.
    Mark {
        lights: &[sector!("3", "20", "150"), sector!("1", "150", "215"), sector!("4", "215", "300")],
        coarse: true,
        ..perched(
            "LNDMRK",
            [857.0, 925.0],
            &[("CATLMK", "17"), ("CONVIS", "1"), ("FUNCTN", "33"), ("COLOUR", "1"), ("OBJNAM", "Lyktholmen")],
        )
    },
    // Round the water where the Otters sail.
    seen(
        "BOYCAR",
        [-102.0, -122.0],
        &[("BOYSHP", "5"), ("CATCAM", "2"), ("COLOUR", "2,6,2"), ("COLPAT", "1")],
    ),
    mark("BOYCAR", [330.0, -128.0], &[("BOYSHP", "5"), ("CATCAM", "1"), ("COLOUR", "2,6"), ("COLPAT", "1")]),
    perched("BCNSPP", [-165.0, 270.0], PERCH),
    perched("BCNSPP", [420.0, 1_185.0], PERCH),
    mark("BOYISD", [-190.0, 655.0], &[("BOYSHP", "5"), ("COLOUR", "2,3,2"), ("COLPAT", "1")]),
    seen(
        "BOYSPP",
        [860.0, -110.0],
        &[("BOYSHP", "3"), ("CATSPM", "9"), ("COLOUR", "6"), ("OBJNAM", "Målebøye")],
    ),
    seen(
        "WRECKS",
        [120.0, -420.0],
        &[("CATWRK", "2"), ("VALSOU", "6.8"), ("QUASOU", "6"), ("WATLEV", "3"), ("OBJNAM", "Havella")],
    ),
    mark(
        "WRECKS",
        [1_010.0, -380.0],
        &[("CATWRK", "1"), ("VALSOU", "11.2"), ("QUASOU", "6"), ("WATLEV", "3")],
    ),
    mark("OBSTRN", [868.0, 330.0], &[("QUASOU", "2"), ("WATLEV", "3"), ("INFORM", "Depth unknown")]),
    mark("OBSTRN", [700.0, -560.0], &[("VALSOU", "4.1"), ("QUASOU", "6"), ("WATLEV", "3")]),
    mark("UWTROC", [868.0, 640.0], &[("QUASOU", "2"), ("WATLEV", "5")]),
    seen("OBSTRN", [-420.0, 1_330.0], &[("CATOBS", "6"), ("QUASOU", "2"), ("WATLEV", "3")]),
    // Names.
    seen("SEAARE", [380.0, 480.0], &[("OBJNAM", "Oterfjorden")]),
    seen("SEAARE", [-2_200.0, 500.0], &[("OBJNAM", "Ytre Oterfjorden")]),
    mark("SEAARE", [1_510.0, 700.0], &[("OBJNAM", "Mårsundet")]),
    mark("SEAARE", [470.0, -1_120.0], &[("OBJNAM", "Lutrahavn")]),
    seen("LNDRGN", [-820.0, 420.0], &[("OBJNAM", "Oterøya")]),
    seen("LNDRGN", [1_230.0, 430.0], &[("OBJNAM", "Mårøya")]),
    seen("LNDRGN", [1_760.0, 560.0], &[("OBJNAM", "Røyskattøya")]),
    seen("LNDRGN", [-1_230.0, -520.0], &[("OBJNAM", "Grevlingen")]),
    seen("LNDRGN", [300.0, 1_440.0], &[("OBJNAM", "Minkholmane")]),
    seen("LNDRGN", [2_700.0, 1_500.0], &[("OBJNAM", "Jervlandet")]),
    seen("LNDRGN", [-2_500.0, 1_600.0], &[("OBJNAM", "Storøteren")]),
];

/// Lines and areas that bound no depth.
pub(super) const DRAWN: &[Drawn] = &[
    Drawn {
        class: "BRIDGE",
        points: &[[1_400.0, 440.0], [1_640.0, 425.0]],
        area: false,
        attributes: &[("CATBRG", "1"), ("VERCLR", "9.0"), ("HORCLR", "40"), ("OBJNAM", "Mårbrua")],
        coarse: true,
    },
    Drawn {
        class: "CBLSUB",
        points: &[[-500.0, 90.0], [-75.0, -190.0], [300.0, -520.0], [235.0, -1_140.0]],
        area: false,
        attributes: &[("CATCBL", "1")],
        coarse: true,
    },
    Drawn {
        class: "MARCUL",
        points: &[[-330.0, 900.0], [-330.0, 1_060.0], [-230.0, 1_060.0], [-230.0, 900.0]],
        area: true,
        attributes: &[("CATMFA", "1"), ("OBJNAM", "Lutra laks")],
        coarse: true,
    },
    Drawn {
        class: "ACHARE",
        points: &[[620.0, -480.0], [620.0, -250.0], [890.0, -250.0], [890.0, -480.0]],
        area: true,
        attributes: &[("CATACH", "1")],
        coarse: false,
    },
];

/// The dredged area inside the harbour's basin: west, south, east, north. It lies within the points of the grid
/// that are flat, so that no contour touches it.
pub(super) const DREDGED: [f64; 4] = [318.0, -1_210.0, 622.0, -1_030.0];
/// Pontoons within it.
pub(super) const PONTOONS: [[f64; 4]; 3] = [
    [360.0, -1_205.0, 367.0, -1_110.0],
    [440.0, -1_205.0, 447.0, -1_100.0],
    [520.0, -1_205.0, 527.0, -1_110.0],
];
