//! The words of pages in the reader's language: the catalogue is [`shore::words`], and this says whose language it is.

pub(crate) use shore::words::{Text, alarm, said, t, worded};

use axum::http::{HeaderMap, header};
use shore::identity::Language;

/// Marks an English word that is chosen while the program runs and said by [`said`], so that the catalogue is held to have it.
pub(crate) const fn word(english: &'static str) -> &'static str {
    english
}

/// The language that a browser asks for first among those that pages speak (RFC 9110, 12.5.4).
pub(crate) fn asked(headers: &HeaderMap) -> Language {
    let wanted =
        headers.get(header::ACCEPT_LANGUAGE).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let spoken = wanted.split(',').filter_map(|one| {
        let mut parts = one.split(';');
        let tag = parts.next()?.trim().to_ascii_lowercase();
        let weight =
            parts.find_map(|part| part.trim().strip_prefix("q=")).map_or(Some(1.0), |q| q.parse().ok())?;
        let language = match tag.split('-').next()? {
            "en" => Language::English,
            // Who asks for Nynorsk reads Bokmål rather than English; `no` is what old browsers send for either.
            "nb" | "no" | "nn" => Language::Bokmal,
            _ => return None,
        };
        (weight > 0.0).then_some((language, weight))
    });
    let best = spoken.fold(None, |best: Option<(Language, f64)>, one| match best {
        Some(before) if before.1 >= one.1 => Some(before),
        _ => Some(one),
    });
    best.map(|(language, _)| language).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_browser_s_first_wish_that_can_be_met_counts() {
        let language = |wanted: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT_LANGUAGE, wanted.parse().unwrap());
            asked(&headers)
        };
        for wanted in
            ["nb", "nb-NO,nb;q=0.9,en;q=0.8", "no", "nn-NO, en;q=0.5", "de, nb;q=0.4", "en;q=0.2,NB;q=0.3"]
        {
            assert_eq!(language(wanted), Language::Bokmal, "{wanted}");
        }
        for wanted in ["", "en-GB,nb;q=0.9", "de", "nb;q=0", "nb;q=x", ";;,=", "en,nb"] {
            assert_eq!(language(wanted), Language::English, "{wanted}");
        }
        assert_eq!(asked(&HeaderMap::new()), Language::English);
    }
}
