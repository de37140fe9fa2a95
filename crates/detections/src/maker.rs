//! Makers of receivers.

use std::fmt;

/// Who made a receiver. Serial numbers are a maker's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Maker {
    /// Thelma Biotel.
    Thelma,
    /// Innovasea, earlier Vemco.
    Innovasea,
    /// Lotek Wireless.
    Lotek,
    /// Sonotronics.
    Sonotronics,
}

impl Maker {
    const ALL: [Self; 4] = [Self::Thelma, Self::Innovasea, Self::Lotek, Self::Sonotronics];

    /// In one word, as in ids.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Thelma => "thelma",
            Self::Innovasea => "innovasea",
            Self::Lotek => "lotek",
            Self::Sonotronics => "sonotronics",
        }
    }

    /// From that word; `None` for another.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|maker| maker.word() == word)
    }

    /// From what people write: the name of a maker, or a model such as `VR2W` or `TBR 700`; `None` for one that is not known here.
    pub fn of(text: &str) -> Option<Self> {
        let text = text.trim().to_lowercase();
        let begins = |starts: &[&str]| starts.iter().any(|start| text.starts_with(start));
        if begins(&["thelma", "tbr"]) {
            Some(Self::Thelma)
        } else if begins(&["innovasea", "vemco", "amirix", "vr", "hr2", "hr3", "nextrak"]) {
            Some(Self::Innovasea)
        } else if begins(&["lotek", "whs"]) {
            Some(Self::Lotek)
        } else if begins(&["sonotronics", "sur"]) {
            Some(Self::Sonotronics)
        } else {
            None
        }
    }

    /// How files name the model of a receiver of this maker where it is not known.
    pub const fn model(self) -> &'static str {
        match self {
            Self::Thelma => "TBR",
            Self::Innovasea => "VR",
            Self::Lotek => "WHS",
            Self::Sonotronics => "SUR",
        }
    }
}

impl fmt::Display for Maker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn makers_are_known_by_name_and_by_model() {
        for (text, maker) in [
            ("Thelma Biotel", Some(Maker::Thelma)),
            ("TBR800", Some(Maker::Thelma)),
            ("VEMCO", Some(Maker::Innovasea)),
            (" vr2w", Some(Maker::Innovasea)),
            ("HR2", Some(Maker::Innovasea)),
            ("SUR", Some(Maker::Sonotronics)),
            ("", None),
            ("109924", None),
        ] {
            assert_eq!(Maker::of(text), maker, "{text}");
        }
        for maker in Maker::ALL {
            assert_eq!((Maker::of_word(maker.word()), Maker::of(maker.model())), (Some(maker), Some(maker)));
        }
    }
}
