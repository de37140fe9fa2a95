//! Classes and attributes of S-57 in words, for people who look at an object.
//!
//! Source: IHO S-57 edition 3.1, appendix A (object catalogue), chapters 1 and 2. Only what surface vessels meet
//! near the coast has words; all else is shown as the chart has it.

use super::codes::{AttributeCode, ObjectClass};

/// A class in words; its acronym or number where there are none.
pub fn class_words(class: ObjectClass) -> String {
    let acronym = class.acronym().unwrap_or_default();
    let found = CLASSES.iter().find(|(name, _)| *name == acronym);
    found.map_or_else(|| class.to_string(), |(_, words)| (*words).to_owned())
}

/// An attribute in words; its acronym or number where there are none.
pub fn attribute_words(code: AttributeCode) -> String {
    let acronym = code.acronym().unwrap_or_default();
    let found = ATTRIBUTES.iter().find(|(name, ..)| *name == acronym);
    found.map_or_else(|| code.to_string(), |(_, words, _)| (*words).to_owned())
}

/// A value in words, with its unit: codes of enumerations and lists of them become their meaning; a value
/// without one is left unchanged, and an empty one is "unknown".
pub fn value_words(code: AttributeCode, value: &str) -> String {
    let value = value.trim();
    if value.is_empty() {
        return "unknown".to_owned();
    }
    let acronym = code.acronym().unwrap_or_default();
    match ATTRIBUTES.iter().find(|(name, ..)| *name == acronym) {
        Some((_, _, Means::Unit(unit))) => format!("{value} {unit}"),
        Some((_, _, Means::Codes(codes))) => {
            let meaning = |one: &str| {
                let number: Option<u32> = one.trim().parse().ok();
                let found = codes.iter().find(|(code, _)| Some(*code) == number);
                found.map_or_else(|| one.trim().to_owned(), |(_, words)| (*words).to_owned())
            };
            value.split(',').map(meaning).collect::<Vec<_>>().join(", ")
        }
        Some((_, _, Means::Text)) | None => value.to_owned(),
    }
}

/// What a value is.
enum Means {
    Text,
    Unit(&'static str),
    Codes(&'static [(u32, &'static str)]),
}

#[rustfmt::skip]
const CLASSES: &[(&str, &str)] = &[
    ("ACHARE", "anchorage area"), ("ACHBRT", "anchor berth"), ("ADMARE", "administration area"),
    ("AIRARE", "airport"), ("BCNCAR", "cardinal beacon"), ("BCNISD", "isolated danger beacon"),
    ("BCNLAT", "lateral beacon"), ("BCNSAW", "safe water beacon"), ("BCNSPP", "special purpose beacon"),
    ("BERTHS", "berth"), ("BOYCAR", "cardinal buoy"), ("BOYINB", "installation buoy"),
    ("BOYISD", "isolated danger buoy"), ("BOYLAT", "lateral buoy"), ("BOYSAW", "safe water buoy"),
    ("BOYSPP", "special purpose buoy"), ("BRIDGE", "bridge"), ("BUAARE", "built-up area"),
    ("BUISGL", "building"), ("CANALS", "canal"), ("CAUSWY", "causeway"), ("CBLARE", "cable area"),
    ("CBLOHD", "overhead cable"), ("CBLSUB", "submarine cable"), ("CGUSTA", "coastguard station"),
    ("COALNE", "coastline"), ("CONVYR", "conveyor"), ("CRANES", "crane"), ("CTNARE", "caution area"),
    ("DAMCON", "dam"), ("DAYMAR", "daymark"), ("DEPARE", "depth area"), ("DEPCNT", "depth contour"),
    ("DISMAR", "distance mark"), ("DMPGRD", "dumping ground"), ("DOCARE", "dock area"),
    ("DRGARE", "dredged area"), ("DRYDOC", "dry dock"), ("DYKCON", "dyke"), ("EXEZNE", "exclusive economic zone"),
    ("FAIRWY", "fairway"), ("FERYRT", "ferry route"), ("FLODOC", "floating dock"), ("FOGSIG", "fog signal"),
    ("FSHFAC", "fishing facility"), ("FSHGRD", "fishing ground"), ("GATCON", "gate"), ("GRIDRN", "gridiron"),
    ("HRBARE", "harbour area"), ("HRBFAC", "harbour facility"), ("HULKES", "hulk"), ("ICEARE", "ice area"),
    ("LAKARE", "lake"), ("LIGHTS", "light"), ("LITFLT", "light float"), ("LITVES", "light vessel"),
    ("LNDARE", "land"), ("LNDELV", "land elevation"), ("LNDMRK", "landmark"), ("LNDRGN", "land region"),
    ("LOGPON", "log pond"), ("MAGVAR", "magnetic variation"), ("MARCUL", "marine farm"),
    ("MIPARE", "military practice area"), ("MORFAC", "mooring facility"), ("NAVLNE", "navigation line"),
    ("OBSTRN", "obstruction"), ("OFSPLF", "offshore platform"), ("OILBAR", "oil barrier"),
    ("PILBOP", "pilot boarding place"), ("PILPNT", "pile"), ("PIPARE", "pipeline area"),
    ("PIPOHD", "overhead pipeline"), ("PIPSOL", "pipeline"), ("PONTON", "pontoon"), ("PRCARE", "precautionary area"),
    ("PYLONS", "pylon"), ("RADSTA", "radar station"), ("RAPIDS", "rapids"), ("RDOSTA", "radio station"),
    ("RECTRC", "recommended track"), ("RESARE", "restricted area"), ("RIVERS", "river"), ("ROADWY", "road"),
    ("RTPBCN", "radar transponder beacon"), ("SBDARE", "seabed area"), ("SEAARE", "sea area"),
    ("SILTNK", "silo or tank"), ("SISTAT", "signal station, traffic"), ("SISTAW", "signal station, warning"),
    ("SLCONS", "shoreline construction"), ("SLOTOP", "slope topline"), ("SMCFAC", "small craft facility"),
    ("SNDWAV", "sand waves"), ("SOUNDG", "sounding"), ("SPRING", "spring"), ("TOPMAR", "topmark"),
    ("TSSLPT", "traffic separation lane"), ("TUNNEL", "tunnel"), ("UNSARE", "unsurveyed area"),
    ("UWTROC", "underwater rock"), ("VEGATN", "vegetation"), ("WATFAL", "waterfall"), ("WATTUR", "turbulent water"),
    ("WEDKLP", "weed or kelp"), ("WRECKS", "wreck"), ("M_COVR", "coverage of the chart"),
    ("M_QUAL", "quality of the survey"), ("M_NSYS", "system of marks"),
];

#[rustfmt::skip]
const ATTRIBUTES: &[(&str, &str, Means)] = &[
    ("BCNSHP", "shape", Means::Codes(&[(1, "stake, pole, perch or post"), (2, "withy"), (3, "tower"), (4, "lattice"),
        (5, "pile"), (6, "cairn"), (7, "buoyant beacon")])),
    ("BOYSHP", "shape", Means::Codes(&[(1, "conical"), (2, "can"), (3, "spherical"), (4, "pillar"), (5, "spar"),
        (6, "barrel"), (7, "super-buoy"), (8, "ice buoy")])),
    ("CATCAM", "category", Means::Codes(&[(1, "north cardinal"), (2, "east cardinal"), (3, "south cardinal"),
        (4, "west cardinal")])),
    ("CATCOV", "category", Means::Codes(&[(1, "covered"), (2, "not covered")])),
    ("CATLAM", "category", Means::Codes(&[(1, "port-hand"), (2, "starboard-hand"),
        (3, "preferred channel to starboard"), (4, "preferred channel to port")])),
    ("CATMFA", "category", Means::Codes(&[(1, "crustaceans"), (2, "oysters or mussels"), (3, "fish"), (4, "seaweed"),
        (5, "pearl culture")])),
    ("CATOBS", "category", Means::Codes(&[(1, "snag or stump"), (2, "wellhead"), (3, "diffuser"), (4, "crib"),
        (5, "fish haven"), (6, "foul area"), (7, "foul ground"), (8, "ice boom"), (9, "ground tackle"), (10, "boom")])),
    ("CATWRK", "category", Means::Codes(&[(1, "non-dangerous wreck"), (2, "dangerous wreck"),
        (3, "distributed remains"), (4, "mast showing"), (5, "hull or superstructure showing")])),
    ("CATZOC", "zone of confidence", Means::Codes(&[(1, "A1"), (2, "A2"), (3, "B"), (4, "C"), (5, "D"),
        (6, "U, not assessed")])),
    ("COLOUR", "colour", Means::Codes(&[(1, "white"), (2, "black"), (3, "red"), (4, "green"), (5, "blue"),
        (6, "yellow"), (7, "grey"), (8, "brown"), (9, "amber"), (10, "violet"), (11, "orange"), (12, "magenta"),
        (13, "pink")])),
    ("COLPAT", "pattern of colours", Means::Codes(&[(1, "horizontal stripes"), (2, "vertical stripes"),
        (3, "diagonal stripes"), (4, "squared"), (5, "stripes, direction unknown"), (6, "border stripe")])),
    ("CONDTN", "condition", Means::Codes(&[(1, "under construction"), (2, "ruined"), (3, "under reclamation"),
        (4, "wingless"), (5, "planned construction")])),
    ("CONVIS", "conspicuous", Means::Codes(&[(1, "visually conspicuous"), (2, "not visually conspicuous")])),
    ("DRVAL1", "least depth", Means::Unit("m")), ("DRVAL2", "greatest depth", Means::Unit("m")),
    ("ELEVAT", "elevation", Means::Unit("m")),
    ("EXPSOU", "exposition of the sounding", Means::Codes(&[(1, "within the range of the area's depths"),
        (2, "shoaler than the area's depths"), (3, "deeper than the area's depths")])),
    ("HEIGHT", "height", Means::Unit("m")), ("HORCLR", "horizontal clearance", Means::Unit("m")),
    ("INFORM", "information", Means::Text),
    ("LITCHR", "character of the light", Means::Codes(&[(1, "fixed"), (2, "flashing"), (3, "long flashing"),
        (4, "quick flashing"), (5, "very quick flashing"), (6, "ultra quick flashing"), (7, "isophase"),
        (8, "occulting"), (9, "interrupted quick flashing"), (10, "interrupted very quick flashing"),
        (11, "interrupted ultra quick flashing"), (12, "Morse"), (13, "fixed and flashing"),
        (14, "flashing and long flashing"), (15, "occulting and flashing"), (16, "fixed and long flashing"),
        (17, "occulting alternating"), (18, "long flashing alternating"), (19, "flashing alternating")])),
    ("NATSUR", "nature of the bottom", Means::Codes(&[(1, "mud"), (2, "clay"), (3, "silt"), (4, "sand"), (5, "stone"),
        (6, "gravel"), (7, "pebbles"), (8, "cobbles"), (9, "rock"), (11, "lava"), (14, "coral"), (17, "shells"),
        (18, "boulders")])),
    ("NINFOM", "information, national", Means::Text), ("NOBJNM", "name, national", Means::Text),
    ("OBJNAM", "name", Means::Text), ("ORIENT", "orientation", Means::Unit("°")),
    ("POSACC", "accuracy of the position", Means::Unit("m")),
    ("QUAPOS", "quality of the position", Means::Codes(&[(1, "surveyed"), (2, "unsurveyed"),
        (3, "inadequately surveyed"), (4, "approximate"), (5, "position doubtful"), (6, "unreliable"),
        (7, "reported, not confirmed"), (8, "reported, confirmed"), (9, "estimated"), (10, "precisely known"),
        (11, "calculated")])),
    ("QUASOU", "quality of the sounding", Means::Codes(&[(1, "depth known"), (2, "depth unknown"),
        (3, "doubtful sounding"), (4, "unreliable sounding"), (5, "no bottom found at the value shown"),
        (6, "least depth known"), (7, "least depth unknown, safe clearance at the value shown"),
        (8, "value reported, not surveyed"), (9, "value reported, not confirmed"), (10, "maintained depth"),
        (11, "not regularly maintained")])),
    ("RESTRN", "restriction", Means::Codes(&[(1, "anchoring prohibited"), (2, "anchoring restricted"),
        (3, "fishing prohibited"), (4, "fishing restricted"), (5, "trawling prohibited"), (6, "trawling restricted"),
        (7, "entry prohibited"), (8, "entry restricted"), (9, "dredging prohibited"), (10, "dredging restricted"),
        (11, "diving prohibited"), (12, "diving restricted"), (13, "no wake"), (14, "area to be avoided"),
        (15, "construction prohibited")])),
    ("SCAMIN", "shown from scale", Means::Text),
    ("SECTR1", "sector from", Means::Unit("°")), ("SECTR2", "sector to", Means::Unit("°")),
    ("SIGGRP", "signal group", Means::Text), ("SIGPER", "period", Means::Unit("s")),
    ("SORDAT", "date of the source", Means::Text), ("SORIND", "source", Means::Text),
    ("SOUACC", "accuracy of the sounding", Means::Unit("m")),
    ("STATUS", "status", Means::Codes(&[(1, "permanent"), (2, "occasional"), (3, "recommended"), (4, "not in use"),
        (5, "intermittent"), (6, "reserved"), (7, "temporary"), (8, "private"), (9, "mandatory"), (11, "extinguished"),
        (12, "illuminated"), (13, "historic"), (14, "public"), (15, "synchronized"), (16, "watched"),
        (17, "unwatched"), (18, "existence doubtful")])),
    ("SURSTA", "survey begun", Means::Text), ("SUREND", "survey ended", Means::Text),
    ("TECSOU", "technique of sounding", Means::Codes(&[(1, "echo sounder"), (2, "side scan sonar"),
        (3, "multi-beam"), (4, "diver"), (5, "lead line"), (6, "wire drag"), (7, "laser"),
        (8, "vertical acoustic system"), (9, "electromagnetic sensor"), (10, "photogrammetry"),
        (11, "satellite imagery"), (12, "levelling"), (13, "side scan sonar swept"), (14, "computer generated")])),
    ("VALDCO", "depth of the contour", Means::Unit("m")), ("VALNMR", "range of the light", Means::Unit("nautical miles")),
    ("VALSOU", "depth", Means::Unit("m")), ("VERCCL", "clearance, closed", Means::Unit("m")),
    ("VERCLR", "vertical clearance", Means::Unit("m")), ("VERCOP", "clearance, open", Means::Unit("m")),
    ("VERCSA", "safe vertical clearance", Means::Unit("m")), ("VERLEN", "vertical length", Means::Unit("m")),
    ("WATLEV", "water level", Means::Codes(&[(1, "partly submerged at high water"), (2, "always dry"),
        (3, "always under water"), (4, "covers and uncovers"), (5, "awash"), (6, "subject to flooding"),
        (7, "floating")])),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_in_the_tables_is_one() {
        for (acronym, _) in CLASSES {
            assert!(ObjectClass::from_acronym(acronym).is_some(), "{acronym}");
        }
        for (acronym, ..) in ATTRIBUTES {
            assert!(AttributeCode::from_acronym(acronym).is_some(), "{acronym}");
        }
    }

    #[test]
    fn values_are_told_by_their_meaning() {
        let code = |name: &str| AttributeCode::from_acronym(name).unwrap();
        assert_eq!(value_words(code("COLOUR"), "3,1,3"), "red, white, red");
        assert_eq!(value_words(code("COLOUR"), "99"), "99");
        assert_eq!(value_words(code("DRVAL1"), "-2.5"), "-2.5 m");
        assert_eq!(value_words(code("WATLEV"), " "), "unknown");
        assert_eq!(
            (class_words(ObjectClass::UWTROC), class_words(ObjectClass(17_001))),
            ("underwater rock".to_owned(), "class 17001".to_owned())
        );
        assert_eq!(attribute_words(AttributeCode(9)), "CATBRG");
    }
}
