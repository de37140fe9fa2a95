//! Whose language an answer is in: the person's choice, else what the browser asks for.

use axum::http::{HeaderMap, header};
use shore::identity::{Language, Principal};

tokio::task_local! {
    /// Of the request that is being answered.
    static CURRENT: Language;
}

/// Answers a request in this language: what is made within has it from [`current`].
pub(crate) async fn within<F: Future>(language: Language, answer: F) -> F::Output {
    CURRENT.scope(language, answer).await
}

/// The language of the request that is being answered, for what is made without its headers.
pub(crate) fn current() -> Language {
    CURRENT.try_with(|language| *language).unwrap_or_default()
}

/// What the person chose; else what their browser asks for.
pub(crate) fn of(headers: &HeaderMap, who: Option<&Principal>) -> Language {
    who.and_then(|who| who.language).unwrap_or_else(|| asked(headers))
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
