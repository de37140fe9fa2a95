//! Areas that a vessel may not enter, or should not: what the chart says, what a vessel makes of it, and where a way
//! first comes into one.
//!
//! S-57 appendix A, attributes RESTRN and CATREA. Such an area says nothing about the depth, so it is given beside the
//! water in every answer, never in its place.

use super::along::{Piece, RunMeaning};
use super::demand::Demand;
use super::index::DepthIndex;
use super::object::State;
use super::piece::Kind;
use super::plane::{Across, Strip};
use crate::s57::{AttributeCode as Attr, Feature, ObjectClass as Class};
use std::cell::Cell;
use units::LatLon;

/// How strictly an area is closed; the first is the stricter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Restriction {
    /// Entry is prohibited (RESTRN 7).
    EntryProhibited,
    /// Entry is restricted (RESTRN 8), the area is to be avoided (RESTRN 14), or it is of a kind that ships keep out
    /// of and the chart gives no restriction.
    EntryRestricted,
}

impl Restriction {
    /// Both, the stricter first.
    pub const ALL: [Self; 2] = [Self::EntryProhibited, Self::EntryRestricted];

    /// A stable word for programs.
    pub fn code(self) -> &'static str {
        match self {
            Self::EntryProhibited => "entry-prohibited",
            Self::EntryRestricted => "entry-restricted",
        }
    }

    /// What such an area is, to stand after "in" or "enters".
    pub fn words(self) -> &'static str {
        match self {
            Self::EntryProhibited => "an area where entry is prohibited",
            Self::EntryRestricted => "an area where entry is restricted or that is to be avoided",
        }
    }
}

/// How a vessel treats such areas; the later is the stricter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EntryRule {
    /// They do not count.
    Ignore,
    /// It may enter, and is warned.
    Warn,
    /// It may not enter.
    Refuse,
}

/// A rule for each restriction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EntryRules {
    /// Where entry is prohibited.
    pub prohibited: EntryRule,
    /// Where entry is restricted, or that are to be avoided.
    pub restricted: EntryRule,
}

impl Default for EntryRules {
    fn default() -> Self {
        Self { prohibited: EntryRule::Refuse, restricted: EntryRule::Warn }
    }
}

impl EntryRules {
    /// No such area counts.
    pub const IGNORE: Self = Self { prohibited: EntryRule::Ignore, restricted: EntryRule::Ignore };

    /// The rule for a restriction.
    pub fn of(self, restriction: Restriction) -> EntryRule {
        match restriction {
            Restriction::EntryProhibited => self.prohibited,
            Restriction::EntryRestricted => self.restricted,
        }
    }

    /// Of each the stricter rule.
    #[must_use]
    pub fn at_least(self, floor: Self) -> Self {
        Self {
            prohibited: self.prohibited.max(floor.prohibited),
            restricted: self.restricted.max(floor.restricted),
        }
    }

    /// Whether some area is refused.
    pub fn refuse_any(self) -> bool {
        Restriction::ALL.iter().any(|one| self.of(*one) == EntryRule::Refuse)
    }
}

/// An area that a place lies in, or that a corridor touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restricted {
    /// How strictly it is closed.
    pub restriction: Restriction,
    /// How the vessel treats it.
    pub rule: EntryRule,
    /// The area, for [`DepthIndex::object`].
    pub object: u32,
    /// Where the corridor first touches it.
    pub at: LatLon,
    /// How far along the leg that is (m).
    pub along_m: f64,
}

impl Restricted {
    /// Whether the vessel may not enter.
    pub fn is_refused(&self) -> bool {
        self.rule == EntryRule::Refuse
    }

    /// Whether it counts more than another: by its rule, then by its restriction, then because it comes first.
    fn outweighs(&self, other: &Self) -> bool {
        let key = |one: &Self| (std::cmp::Reverse(one.rule), one.restriction);
        (key(self), self.along_m) < (key(other), other.along_m)
    }

    /// The one of two that counts more; the first where they count the same.
    pub fn worse(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(one), Some(other)) => Some(if other.outweighs(&one) { other } else { one }),
            (one, other) => one.or(other),
        }
    }
}

/// A feature's restriction of entry, if it has one.
///
/// RESTRN counts on every class. An area whose restriction the chart does not give is restricted by its category:
/// offshore safety zone, military area and minefield are not to be entered by chance.
pub(super) fn restriction(feature: &Feature) -> Option<Restriction> {
    /// RESTRN.
    const ENTRY_PROHIBITED: u32 = 7;
    const ENTRY_RESTRICTED: u32 = 8;
    const TO_BE_AVOIDED: u32 = 14;
    /// CATREA: offshore safety zone, military area, minefield.
    const KEPT_OUT_OF: [u32; 3] = [1, 9, 14];
    let says = |code: u32| feature.list(Attr::RESTRN).any(|one| one == code);
    if says(ENTRY_PROHIBITED) {
        return Some(Restriction::EntryProhibited);
    }
    let unsaid = feature.class == Class::RESARE && feature.list(Attr::RESTRN).next().is_none();
    let by_category = || unsaid && feature.list(Attr::CATREA).any(|one| KEPT_OUT_OF.contains(&one));
    (says(ENTRY_RESTRICTED) || says(TO_BE_AVOIDED) || by_category()).then_some(Restriction::EntryRestricted)
}

impl State {
    /// The area at the point that counts most.
    pub(super) fn restricted(&self, at: LatLon, demand: &Demand) -> Option<Restricted> {
        let area = |restriction: &Restriction| {
            let (rule, object) = (demand.entry.of(*restriction), self.areas[*restriction as usize]?);
            let restriction = *restriction;
            (rule > EntryRule::Ignore).then_some(Restricted { restriction, rule, object, at, along_m: 0.0 })
        };
        Restriction::ALL.iter().map(area).fold(None, Restricted::worse)
    }
}

impl DepthIndex {
    /// Of the areas that a piece of a leg touches the one that counts most, of those with at least this rule.
    pub(super) fn restricted_in(
        &self,
        piece: &Piece,
        demand: &Demand,
        least: EntryRule,
    ) -> Option<Restricted> {
        let least = least.max(EntryRule::Warn);
        let counts = |restriction: Restriction| demand.entry.of(restriction) >= least;
        if !Restriction::ALL.iter().any(|one| counts(*one)) {
            return None;
        }
        let start = piece.state.restricted(piece.from.place(), demand).filter(|area| area.rule >= least);
        let worst = Cell::new(start);
        let consider = |strip: &Strip, told: RunMeaning, a: Across, b: Across| {
            let (Some(restriction), Some(object)) = (told.restriction, told.object) else { return };
            if !counts(restriction) {
                return;
            }
            let Some((along_m, on)) = strip.first_touch(a, b) else { return };
            let (rule, at) = (demand.entry.of(restriction), strip.spot(on).place());
            let found = Restricted { restriction, rule, object, at, along_m };
            worst.set(Restricted::worse(worst.get(), Some(found)));
        };
        self.each_segment(Kind::Restricted, &piece.strip, |_| true, consider);
        worst.get().map(|area| Restricted { along_m: piece.before_m + area.along_m, ..area })
    }
}
