//! Codes of object classes and attributes and their acronyms.
//!
//! Source: IHO S-57 edition 3.1, appendix A (object catalogue), chapters 1 and 2. Codes beyond the tables
//! (inland and later objects) keep their number and are named by it; nothing is refused for being unknown.

use std::fmt;

/// An object class (subfield OBJL).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectClass(pub u16);

impl ObjectClass {
    /// `BCNCAR`.
    pub const BCNCAR: Self = Self(5);
    /// `BCNISD`.
    pub const BCNISD: Self = Self(6);
    /// `BCNLAT`.
    pub const BCNLAT: Self = Self(7);
    /// `BCNSAW`.
    pub const BCNSAW: Self = Self(8);
    /// `BCNSPP`.
    pub const BCNSPP: Self = Self(9);
    /// `BRIDGE`.
    pub const BRIDGE: Self = Self(11);
    /// `BOYCAR`.
    pub const BOYCAR: Self = Self(14);
    /// `BOYINB`.
    pub const BOYINB: Self = Self(15);
    /// `BOYISD`.
    pub const BOYISD: Self = Self(16);
    /// `BOYLAT`.
    pub const BOYLAT: Self = Self(17);
    /// `BOYSAW`.
    pub const BOYSAW: Self = Self(18);
    /// `BOYSPP`.
    pub const BOYSPP: Self = Self(19);
    /// `BUISGL`.
    pub const BUISGL: Self = Self(12);
    /// `CBLOHD`.
    pub const CBLOHD: Self = Self(21);
    /// `CAUSWY`.
    pub const CAUSWY: Self = Self(26);
    /// `COALNE`.
    pub const COALNE: Self = Self(30);
    /// `CONVYR`.
    pub const CONVYR: Self = Self(34);
    /// `CRANES`.
    pub const CRANES: Self = Self(35);
    /// `DAMCON`.
    pub const DAMCON: Self = Self(38);
    /// `DAYMAR`.
    pub const DAYMAR: Self = Self(39);
    /// `DEPARE`.
    pub const DEPARE: Self = Self(42);
    /// `DEPCNT`.
    pub const DEPCNT: Self = Self(43);
    /// `DISMAR`.
    pub const DISMAR: Self = Self(44);
    /// `DRGARE`.
    pub const DRGARE: Self = Self(46);
    /// `DRYDOC`.
    pub const DRYDOC: Self = Self(47);
    /// `DYKCON`.
    pub const DYKCON: Self = Self(49);
    /// `FSHFAC`.
    pub const FSHFAC: Self = Self(55);
    /// `FLODOC`.
    pub const FLODOC: Self = Self(57);
    /// `FORSTC`.
    pub const FORSTC: Self = Self(59);
    /// `GATCON`.
    pub const GATCON: Self = Self(61);
    /// `GRIDRN`.
    pub const GRIDRN: Self = Self(62);
    /// `RAPIDS`.
    pub const RAPIDS: Self = Self(107);
    /// `WATFAL`.
    pub const WATFAL: Self = Self(157);
    /// `NEWOBJ`.
    pub const NEWOBJ: Self = Self(163);
    /// `HULKES`.
    pub const HULKES: Self = Self(65);
    /// `ICEARE`.
    pub const ICEARE: Self = Self(66);
    /// `LNDARE`.
    pub const LNDARE: Self = Self(71);
    /// `LNDMRK`.
    pub const LNDMRK: Self = Self(74);
    /// `LIGHTS`.
    pub const LIGHTS: Self = Self(75);
    /// `LITFLT`.
    pub const LITFLT: Self = Self(76);
    /// `LITVES`.
    pub const LITVES: Self = Self(77);
    /// `LOGPON`.
    pub const LOGPON: Self = Self(80);
    /// `MARCUL`.
    pub const MARCUL: Self = Self(82);
    /// `MORFAC`.
    pub const MORFAC: Self = Self(84);
    /// `OBSTRN`.
    pub const OBSTRN: Self = Self(86);
    /// `OFSPLF`.
    pub const OFSPLF: Self = Self(87);
    /// `OILBAR`.
    pub const OILBAR: Self = Self(89);
    /// `PILPNT`.
    pub const PILPNT: Self = Self(90);
    /// `PIPOHD`.
    pub const PIPOHD: Self = Self(93);
    /// `PONTON`.
    pub const PONTON: Self = Self(95);
    /// `PYLONS`.
    pub const PYLONS: Self = Self(98);
    /// `RESARE`.
    pub const RESARE: Self = Self(112);
    /// `SILTNK`.
    pub const SILTNK: Self = Self(125);
    /// `SLCONS`.
    pub const SLCONS: Self = Self(122);
    /// `SOUNDG`.
    pub const SOUNDG: Self = Self(129);
    /// `UWTROC`.
    pub const UWTROC: Self = Self(153);
    /// `UNSARE`.
    pub const UNSARE: Self = Self(154);
    /// `DWRTPT`.
    pub const DWRTPT: Self = Self(41);
    /// `TSSCRS`.
    pub const TSSCRS: Self = Self(147);
    /// `TSSLPT`.
    pub const TSSLPT: Self = Self(148);
    /// `TSSRON`.
    pub const TSSRON: Self = Self(149);
    /// `TSEZNE`.
    pub const TSEZNE: Self = Self(150);
    /// `WRECKS`.
    pub const WRECKS: Self = Self(159);
    /// `M_COVR`.
    pub const M_COVR: Self = Self(302);
    /// `M_QUAL`.
    pub const M_QUAL: Self = Self(308);

    /// The acronym, such as `DEPARE`; `None` for a code beyond S-57 3.1.
    pub fn acronym(self) -> Option<&'static str> {
        lookup(OBJECTS, self.0)
    }

    /// Whether its objects are groups of others (C_AGGR and the like) and have no place of their own.
    pub fn is_collection(self) -> bool {
        (400..500).contains(&self.0)
    }

    /// The class of an acronym.
    pub fn from_acronym(acronym: &str) -> Option<Self> {
        OBJECTS.iter().find(|(_, name)| *name == acronym).map(|(code, _)| Self(*code))
    }
}

impl fmt::Display for ObjectClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.acronym() {
            Some(acronym) => f.write_str(acronym),
            None => write!(f, "class {}", self.0),
        }
    }
}

/// An attribute (subfield ATTL).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AttributeCode(pub u16);

impl AttributeCode {
    /// `CATCOV`.
    pub const CATCOV: Self = Self(18);
    /// `CATOBS`.
    pub const CATOBS: Self = Self(42);
    /// `CATREA`.
    pub const CATREA: Self = Self(56);
    /// `CATWRK`.
    pub const CATWRK: Self = Self(71);
    /// `CATZOC`.
    pub const CATZOC: Self = Self(72);
    /// `DRVAL1`.
    pub const DRVAL1: Self = Self(87);
    /// `DRVAL2`.
    pub const DRVAL2: Self = Self(88);
    /// `EXPSOU`.
    pub const EXPSOU: Self = Self(93);
    /// `OBJNAM`.
    pub const OBJNAM: Self = Self(116);
    /// `ORIENT`.
    pub const ORIENT: Self = Self(117);
    /// `QUASOU`.
    pub const QUASOU: Self = Self(125);
    /// `RESTRN`.
    pub const RESTRN: Self = Self(131);
    /// `VALDCO`.
    pub const VALDCO: Self = Self(174);
    /// `VALSOU`.
    pub const VALSOU: Self = Self(179);
    /// `VERCCL`.
    pub const VERCCL: Self = Self(182);
    /// `VERCLR`.
    pub const VERCLR: Self = Self(181);
    /// `VERCOP`.
    pub const VERCOP: Self = Self(183);
    /// `VERCSA`.
    pub const VERCSA: Self = Self(184);
    /// `WATLEV`.
    pub const WATLEV: Self = Self(187);
    /// `NOBJNM`.
    pub const NOBJNM: Self = Self(301);
    /// `POSACC`.
    pub const POSACC: Self = Self(401);
    /// `QUAPOS`.
    pub const QUAPOS: Self = Self(402);

    /// The acronym, such as `DRVAL1`; `None` for a code beyond S-57 3.1.
    pub fn acronym(self) -> Option<&'static str> {
        lookup(ATTRIBUTES, self.0)
    }

    /// The attribute of an acronym.
    pub fn from_acronym(acronym: &str) -> Option<Self> {
        ATTRIBUTES.iter().find(|(_, name)| *name == acronym).map(|(code, _)| Self(*code))
    }
}

impl fmt::Display for AttributeCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.acronym() {
            Some(acronym) => f.write_str(acronym),
            None => write!(f, "attribute {}", self.0),
        }
    }
}

fn lookup(table: &[(u16, &'static str)], code: u16) -> Option<&'static str> {
    table.binary_search_by_key(&code, |(code, _)| *code).ok().map(|at| table[at].1)
}

/// Object classes by code.
#[rustfmt::skip]
const OBJECTS: &[(u16, &str)] = &[
    (1, "ADMARE"), (2, "AIRARE"), (3, "ACHBRT"), (4, "ACHARE"), (5, "BCNCAR"), (6, "BCNISD"),
    (7, "BCNLAT"), (8, "BCNSAW"), (9, "BCNSPP"), (10, "BERTHS"), (11, "BRIDGE"), (12, "BUISGL"),
    (13, "BUAARE"), (14, "BOYCAR"), (15, "BOYINB"), (16, "BOYISD"), (17, "BOYLAT"), (18, "BOYSAW"),
    (19, "BOYSPP"), (20, "CBLARE"), (21, "CBLOHD"), (22, "CBLSUB"), (23, "CANALS"), (24, "CANBNK"),
    (25, "CTSARE"), (26, "CAUSWY"), (27, "CTNARE"), (28, "CHKPNT"), (29, "CGUSTA"), (30, "COALNE"),
    (31, "CONZNE"), (32, "COSARE"), (33, "CTRPNT"), (34, "CONVYR"), (35, "CRANES"), (36, "CURENT"),
    (37, "CUSZNE"), (38, "DAMCON"), (39, "DAYMAR"), (40, "DWRTCL"), (41, "DWRTPT"), (42, "DEPARE"),
    (43, "DEPCNT"), (44, "DISMAR"), (45, "DOCARE"), (46, "DRGARE"), (47, "DRYDOC"), (48, "DMPGRD"),
    (49, "DYKCON"), (50, "EXEZNE"), (51, "FAIRWY"), (52, "FNCLNE"), (53, "FERYRT"), (54, "FSHZNE"),
    (55, "FSHFAC"), (56, "FSHGRD"), (57, "FLODOC"), (58, "FOGSIG"), (59, "FORSTC"), (60, "FRPARE"),
    (61, "GATCON"), (62, "GRIDRN"), (63, "HRBARE"), (64, "HRBFAC"), (65, "HULKES"), (66, "ICEARE"),
    (67, "ICNARE"), (68, "ISTZNE"), (69, "LAKARE"), (70, "LAKSHR"), (71, "LNDARE"), (72, "LNDELV"),
    (73, "LNDRGN"), (74, "LNDMRK"), (75, "LIGHTS"), (76, "LITFLT"), (77, "LITVES"), (78, "LOCMAG"),
    (79, "LOKBSN"), (80, "LOGPON"), (81, "MAGVAR"), (82, "MARCUL"), (83, "MIPARE"), (84, "MORFAC"),
    (85, "NAVLNE"), (86, "OBSTRN"), (87, "OFSPLF"), (88, "OSPARE"), (89, "OILBAR"), (90, "PILPNT"),
    (91, "PILBOP"), (92, "PIPARE"), (93, "PIPOHD"), (94, "PIPSOL"), (95, "PONTON"), (96, "PRCARE"),
    (97, "PRDARE"), (98, "PYLONS"), (99, "RADLNE"), (100, "RADRNG"), (101, "RADRFL"), (102, "RADSTA"),
    (103, "RTPBCN"), (104, "RDOCAL"), (105, "RDOSTA"), (106, "RAILWY"), (107, "RAPIDS"), (108, "RCRTCL"),
    (109, "RECTRC"), (110, "RCTLPT"), (111, "RSCSTA"), (112, "RESARE"), (113, "RETRFL"), (114, "RIVERS"),
    (115, "RIVBNK"), (116, "ROADWY"), (117, "RUNWAY"), (118, "SNDWAV"), (119, "SEAARE"), (120, "SPLARE"),
    (121, "SBDARE"), (122, "SLCONS"), (123, "SISTAT"), (124, "SISTAW"), (125, "SILTNK"), (126, "SLOTOP"),
    (127, "SLOGRD"), (128, "SMCFAC"), (129, "SOUNDG"), (130, "SPRING"), (131, "SQUARE"), (132, "STSLNE"),
    (133, "SUBTLN"), (134, "SWPARE"), (135, "TESARE"), (136, "TS_PRH"), (137, "TS_PNH"), (138, "TS_PAD"),
    (139, "TS_TIS"), (140, "T_HMON"), (141, "T_NHMN"), (142, "T_TIMS"), (143, "TIDEWY"), (144, "TOPMAR"),
    (145, "TSELNE"), (146, "TSSBND"), (147, "TSSCRS"), (148, "TSSLPT"), (149, "TSSRON"), (150, "TSEZNE"),
    (151, "TUNNEL"), (152, "TWRTPT"), (153, "UWTROC"), (154, "UNSARE"), (155, "VEGATN"), (156, "WATTUR"),
    (157, "WATFAL"), (158, "WEDKLP"), (159, "WRECKS"), (160, "TS_FEB"), (161, "ARCSLN"), (162, "ASLXIS"),
    (163, "NEWOBJ"), (300, "M_ACCY"), (301, "M_CSCL"), (302, "M_COVR"), (303, "M_HDAT"), (304, "M_HOPA"),
    (305, "M_NPUB"), (306, "M_NSYS"), (307, "M_PROD"), (308, "M_QUAL"), (309, "M_SDAT"), (310, "M_SREL"),
    (311, "M_UNIT"), (312, "M_VDAT"), (400, "C_AGGR"), (401, "C_ASSO"), (402, "C_STAC"), (500, "$AREAS"),
    (501, "$LINES"), (502, "$CSYMB"), (503, "$COMPS"), (504, "$TEXTS"),
];

/// Attributes by code.
#[rustfmt::skip]
const ATTRIBUTES: &[(u16, &str)] = &[
    (1, "AGENCY"), (2, "BCNSHP"), (3, "BUISHP"), (4, "BOYSHP"), (5, "BURDEP"), (6, "CALSGN"),
    (7, "CATAIR"), (8, "CATACH"), (9, "CATBRG"), (10, "CATBUA"), (11, "CATCBL"), (12, "CATCAN"),
    (13, "CATCAM"), (14, "CATCHP"), (15, "CATCOA"), (16, "CATCTR"), (17, "CATCON"), (18, "CATCOV"),
    (19, "CATCRN"), (20, "CATDAM"), (21, "CATDIS"), (22, "CATDOC"), (23, "CATDPG"), (24, "CATFNC"),
    (25, "CATFRY"), (26, "CATFIF"), (27, "CATFOG"), (28, "CATFOR"), (29, "CATGAT"), (30, "CATHAF"),
    (31, "CATHLK"), (32, "CATICE"), (33, "CATINB"), (34, "CATLND"), (35, "CATLMK"), (36, "CATLAM"),
    (37, "CATLIT"), (38, "CATMFA"), (39, "CATMPA"), (40, "CATMOR"), (41, "CATNAV"), (42, "CATOBS"),
    (43, "CATOFP"), (44, "CATOLB"), (45, "CATPLE"), (46, "CATPIL"), (47, "CATPIP"), (48, "CATPRA"),
    (49, "CATPYL"), (50, "CATQUA"), (51, "CATRAS"), (52, "CATRTB"), (53, "CATROS"), (54, "CATTRK"),
    (55, "CATRSC"), (56, "CATREA"), (57, "CATROD"), (58, "CATRUN"), (59, "CATSEA"), (60, "CATSLC"),
    (61, "CATSIT"), (62, "CATSIW"), (63, "CATSIL"), (64, "CATSLO"), (65, "CATSCF"), (66, "CATSPM"),
    (67, "CATTSS"), (68, "CATVEG"), (69, "CATWAT"), (70, "CATWED"), (71, "CATWRK"), (72, "CATZOC"),
    (73, "$SPACE"), (74, "$CHARS"), (75, "COLOUR"), (76, "COLPAT"), (77, "COMCHA"), (78, "$CSIZE"),
    (79, "CPDATE"), (80, "CSCALE"), (81, "CONDTN"), (82, "CONRAD"), (83, "CONVIS"), (84, "CURVEL"),
    (85, "DATEND"), (86, "DATSTA"), (87, "DRVAL1"), (88, "DRVAL2"), (89, "DUNITS"), (90, "ELEVAT"),
    (91, "ESTRNG"), (92, "EXCLIT"), (93, "EXPSOU"), (94, "FUNCTN"), (95, "HEIGHT"), (96, "HUNITS"),
    (97, "HORACC"), (98, "HORCLR"), (99, "HORLEN"), (100, "HORWID"), (101, "ICEFAC"), (102, "INFORM"),
    (103, "JRSDTN"), (104, "$JUSTH"), (105, "$JUSTV"), (106, "LIFCAP"), (107, "LITCHR"), (108, "LITVIS"),
    (109, "MARSYS"), (110, "MLTYLT"), (111, "NATION"), (112, "NATCON"), (113, "NATSUR"), (114, "NATQUA"),
    (115, "NMDATE"), (116, "OBJNAM"), (117, "ORIENT"), (118, "PEREND"), (119, "PERSTA"), (120, "PICREP"),
    (121, "PILDST"), (122, "PRCTRY"), (123, "PRODCT"), (124, "PUBREF"), (125, "QUASOU"), (126, "RADWAL"),
    (127, "RADIUS"), (128, "RECDAT"), (129, "RECIND"), (130, "RYRMGV"), (131, "RESTRN"), (132, "SCAMAX"),
    (133, "SCAMIN"), (134, "SCVAL1"), (135, "SCVAL2"), (136, "SECTR1"), (137, "SECTR2"), (138, "SHIPAM"),
    (139, "SIGFRQ"), (140, "SIGGEN"), (141, "SIGGRP"), (142, "SIGPER"), (143, "SIGSEQ"), (144, "SOUACC"),
    (145, "SDISMX"), (146, "SDISMN"), (147, "SORDAT"), (148, "SORIND"), (149, "STATUS"), (150, "SURATH"),
    (151, "SUREND"), (152, "SURSTA"), (153, "SURTYP"), (154, "$SCALE"), (155, "$SCODE"), (156, "TECSOU"),
    (157, "$TXSTR"), (158, "TXTDSC"), (159, "TS_TSP"), (160, "TS_TSV"), (161, "T_ACWL"), (162, "T_HWLW"),
    (163, "T_MTOD"), (164, "T_THDF"), (165, "T_TINT"), (166, "T_TSVL"), (167, "T_VAHC"), (168, "TIMEND"),
    (169, "TIMSTA"), (170, "$TINTS"), (171, "TOPSHP"), (172, "TRAFIC"), (173, "VALACM"), (174, "VALDCO"),
    (175, "VALLMA"), (176, "VALMAG"), (177, "VALMXR"), (178, "VALNMR"), (179, "VALSOU"), (180, "VERACC"),
    (181, "VERCLR"), (182, "VERCCL"), (183, "VERCOP"), (184, "VERCSA"), (185, "VERDAT"), (186, "VERLEN"),
    (187, "WATLEV"), (188, "CAT_TS"), (189, "PUNITS"), (190, "CLSDEF"), (191, "CLSNAM"), (192, "SYMINS"),
    (300, "NINFOM"), (301, "NOBJNM"), (302, "NPLDST"), (303, "$NTXST"), (304, "NTXTDS"), (400, "HORDAT"),
    (401, "POSACC"), (402, "QUAPOS"),
];

/// The classes of group 1.
pub const SKIN_CLASSES: [ObjectClass; 7] = [
    ObjectClass::DEPARE,
    ObjectClass::DRGARE,
    ObjectClass::LNDARE,
    ObjectClass::UNSARE,
    ObjectClass::PONTON,
    ObjectClass::HULKES,
    ObjectClass::FLODOC,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted_and_lead_back() {
        assert!(OBJECTS.is_sorted_by(|a, b| a.0 < b.0));
        assert!(ATTRIBUTES.is_sorted_by(|a, b| a.0 < b.0));
        for (code, acronym) in OBJECTS {
            assert_eq!(ObjectClass::from_acronym(acronym), Some(ObjectClass(*code)));
        }
        for (code, acronym) in ATTRIBUTES {
            assert_eq!(AttributeCode::from_acronym(acronym), Some(AttributeCode(*code)));
        }
        assert_eq!(ObjectClass::WRECKS.to_string(), "WRECKS");
        assert_eq!(ObjectClass(17_001).to_string(), "class 17001");
        assert_eq!(AttributeCode::WATLEV.0, 187);
    }
}
