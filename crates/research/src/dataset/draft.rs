//! The valid contents of a dataset's draft, its requirements for publication, and the citation of a version.

use crate::column::shown;
use crate::filters;
use crate::study::Study;
use api::{DatasetAuthor, DatasetDraft, DatasetVersion, Wording, say};
use units::{Civil, UtcTime};

/// Licences by SPDX: identifier, name, and the address of its text. The first is taken where none is chosen.
pub const LICENCES: [(&str, &str, &str); 3] = [
    (
        "CC-BY-4.0",
        "Creative Commons Attribution 4.0 International",
        "https://creativecommons.org/licenses/by/4.0/",
    ),
    ("CC0-1.0", "Creative Commons Zero v1.0 Universal", "https://creativecommons.org/publicdomain/zero/1.0/"),
    (
        "CC-BY-NC-4.0",
        "Creative Commons Attribution Non Commercial 4.0 International",
        "https://creativecommons.org/licenses/by-nc/4.0/",
    ),
];

/// Letters of a line and of a description.
const LINE: usize = 300;
const TEXT: usize = 10_000;
/// Authors, tags, vessels and projects that a draft may name.
const AUTHORS: usize = 100;
const NAMES: usize = 200;
/// Times that JavaScript holds exactly (µs since 1970 UTC).
const TIMES_US: std::ops::RangeInclusive<i64> = 0..=9_007_199_254_740_991;

/// What is wrong with a field, and what to do.
type Wrong = (&'static str, Wording);

/// Tidies a draft, and returns what is wrong with its fields; nothing where it can be stored. What it still lacks for
/// publication is reported by [`lacking`].
pub fn check_draft(draft: &mut DatasetDraft, study: &Study) -> Vec<Wrong> {
    for text in
        [&mut draft.title, &mut draft.publisher, &mut draft.licence, &mut draft.embargo_until, &mut draft.doi]
    {
        *text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    }
    let description = draft.description.replace("\r\n", "\n");
    description.trim().clone_into(&mut draft.description);
    if draft.licence.is_empty() {
        LICENCES[0].0.clone_into(&mut draft.licence);
    }
    let mut wrong: Vec<Wrong> = Vec::new();
    for (field, text, most) in [
        ("title", &draft.title, LINE),
        ("publisher", &draft.publisher, LINE),
        ("licence", &draft.licence, LINE),
        ("description", &draft.description, TEXT),
    ] {
        let letters = text.chars().count();
        if letters > most {
            wrong.push((
                field,
                say("has {letters} characters; at most {most} are allowed: shorten it")
                    .with("letters", letters)
                    .with("most", most),
            ));
        }
        if text.chars().any(|letter| letter.is_control() && letter != '\n' && letter != '\t') {
            wrong.push((field, say("has control characters in it: write it without them")));
        }
    }
    match doi(&draft.doi) {
        Ok(doi) => draft.doi = doi,
        Err(text) => wrong.push(("doi", text)),
    }
    if !draft.embargo_until.is_empty() && embargo_us(&draft.embargo_until).is_none() {
        let text =
            say("`{text}` is not a day; write it like 2027-01-31").with("text", shown(&draft.embargo_until));
        wrong.push(("embargo_until", text));
    }
    wrong.extend(wrong_authors(draft, study));
    wrong.extend(wrong_query(draft, study));
    wrong
}

fn wrong_authors(draft: &mut DatasetDraft, study: &Study) -> Option<Wrong> {
    let mut names: Vec<String> = Vec::new();
    for name in draft.authors.iter().map(|name| name.trim()).filter(|name| !name.is_empty()) {
        let Some(person) = study.person_named(name) else {
            let near = suggest::nearest(name, study.people_names());
            let text = match near {
                Some(near) => {
                    say("the register has no person `{name}`; did you mean `{near}`? Add them at /register")
                        .with("near", near)
                }
                None => say("the register has no person `{name}`. Add them at /register"),
            };
            let text = text.with("name", shown(name));
            return Some(("authors", text));
        };
        if names.contains(&person.name) {
            return Some((
                "authors",
                say("`{name}` is named twice; once is enough").with("name", shown(name)),
            ));
        }
        names.push(person.name.clone());
    }
    draft.authors = names;
    (draft.authors.len() > AUTHORS).then(|| {
        (
            "authors",
            say("there are {count}; at most {most} are allowed")
                .with("count", draft.authors.len())
                .with("most", AUTHORS),
        )
    })
}

fn wrong_query(draft: &mut DatasetDraft, study: &Study) -> Vec<Wrong> {
    let query = &mut draft.query;
    let mut wrong: Vec<Wrong> = Vec::new();
    for (field, time) in [("from_us", query.from_us), ("to_us", query.to_us)] {
        if time.is_some_and(|time| !TIMES_US.contains(&time)) {
            wrong.push((field, say("is not a time from 1970 to 2255; give µs since 1970 UTC")));
        }
    }
    if query.from_us.zip(query.to_us).is_some_and(|(from, to)| to <= from) {
        wrong.push(("to_us", say("the end is not after the beginning")));
    }
    query.vessels.sort_unstable();
    query.vessels.dedup();
    query.without.sort_unstable();
    query.without.dedup();
    for (field, count) in
        [("vessels", query.vessels.len()), ("tags", query.tags.len()), ("projects", query.projects.len())]
    {
        if count > NAMES {
            wrong.push((
                field,
                say("there are {count}; at most {most} are allowed").with("count", count).with("most", NAMES),
            ));
        }
    }
    query.tags = query.tags.iter().map(|tag| tag.trim().to_owned()).filter(|tag| !tag.is_empty()).collect();
    if let Some((tag, why)) = query.tags.iter().find_map(|tag| Some((tag, filters::tag(tag).err()?))) {
        wrong.push(("tags", say("`{tag}`: {error}").with("tag", shown(tag)).with_said("error", why)));
    }
    let unknown = query.projects.iter().find(|name| study.project_named(name).is_none());
    if let Some(name) = unknown {
        wrong.push((
            "projects",
            say("the register has no project `{name}`; add it at /register").with("name", shown(name)),
        ));
    }
    let area = query.area.trim().to_owned();
    query.area = area;
    if !query.area.is_empty()
        && let Err(why) = filters::area(&query.area)
    {
        wrong.push(("area", why));
    }
    wrong
}

/// The missing parts of a draft before it can be published.
pub fn lacking(draft: &DatasetDraft) -> Vec<Wrong> {
    let mut wrong = Vec::new();
    for (field, is_lacking, text) in [
        ("title", draft.title.is_empty(), say("a dataset needs a title: write one")),
        (
            "publisher",
            draft.publisher.is_empty(),
            say("a citation names who publishes it: write the institution"),
        ),
        ("authors", draft.authors.is_empty(), say("a citation names its authors: choose one or more")),
    ] {
        if is_lacking {
            wrong.push((field, text));
        }
    }
    wrong
}

/// A DOI as registries write it, of what people paste; empty stays empty.
///
/// # Errors
/// The text is not a DOI.
pub fn doi(text: &str) -> Result<String, Wording> {
    let text = text.trim();
    let start = ["https://doi.org/", "http://doi.org/", "https://dx.doi.org/", "http://dx.doi.org/", "doi:"]
        .into_iter()
        .find(|start| text.get(..start.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(start)));
    let bare = start.map_or(text, |start| &text[start.len()..]).trim();
    if bare.is_empty() && text.is_empty() {
        return Ok(String::new());
    }
    let is_good =
        bare.strip_prefix("10.").and_then(|rest| rest.split_once('/')).is_some_and(|(prefix, rest)| {
            let parts = prefix.split('.');
            let is_prefix =
                parts.clone().all(|part| !part.is_empty() && part.bytes().all(|one| one.is_ascii_digit()))
                    && parts.clone().next().is_some_and(|first| (4..=9).contains(&first.len()));
            is_prefix
                && !rest.is_empty()
                && rest.len() <= 200
                && rest.chars().all(|one| one.is_ascii_graphic() && !"<>\"".contains(one))
        });
    if is_good {
        return Ok(bare.to_owned());
    }
    Err(say("`{text}` is not a DOI; write it like 10.5281/zenodo.1234, or leave it empty")
        .with("text", shown(text)))
}

/// When an embargo ends (µs since 1970 UTC): at the beginning of the day; `None` where the text is not a day.
pub fn embargo_us(day: &str) -> Option<i64> {
    let is_day = day.len() == 10
        && day
            .bytes()
            .enumerate()
            .all(|(at, one)| if at == 4 || at == 7 { one == b'-' } else { one.is_ascii_digit() });
    if !is_day {
        return None;
    }
    let (year, month, day) = (day[..4].parse().ok()?, day[5..7].parse().ok()?, day[8..].parse().ok()?);
    let time =
        UtcTime::from_civil(Civil { year, month, day, hour: 0, minute: 0, second: 0, microsecond: 0 })?;
    Some(time.micros()).filter(|us| TIMES_US.contains(us))
}

/// How a version is cited, as DataCite recommends it: authors (year): title. Version. Publisher. Dataset. DOI.
pub fn citation(version: &DatasetVersion) -> String {
    let authors: Vec<&str> = version.authors.iter().map(|DatasetAuthor { name, .. }| &**name).collect();
    let year = UtcTime::from_micros(version.published.time_us).civil().year;
    let doi =
        if version.doi.is_empty() { String::new() } else { format!(" https://doi.org/{}", version.doi) };
    let end = |text: &str| if text.ends_with(['.', '!', '?']) { "" } else { "." };
    format!(
        "{} ({year}): {}{} Version {}. {}{} Dataset.{doi}",
        authors.join("; "),
        version.title,
        end(&version.title),
        version.number,
        version.publisher,
        end(&version.publisher),
    )
}

/// The name of a licence.
pub fn licence_name(licence: &str) -> &str {
    LICENCES.iter().find(|(id, ..)| *id == licence).map_or(licence, |(_, name, _)| name)
}

/// The address of a licence's text; `None` for own words.
pub fn licence_page(licence: &str) -> Option<&'static str> {
    LICENCES.iter().find(|(id, ..)| *id == licence).map(|(_, _, page)| *page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::{DatasetContent, DatasetQuery, LogWord, RegisterPerson, RegisterRecord};

    fn study() -> Study {
        let person = |name: &str| RegisterPerson { name: name.into(), ..RegisterPerson::default() };
        Study::new(["Kari Nordmann", "Ola Hansen"].map(|name| RegisterRecord::Person(person(name))))
    }

    fn told(mut draft: DatasetDraft) -> Vec<String> {
        let wrong = check_draft(&mut draft, &study());
        wrong.into_iter().map(|(field, text)| format!("{field}: {text}")).collect()
    }

    #[test]
    fn a_draft_is_tidied_and_lacks_little() {
        let mut draft = DatasetDraft {
            title: "  Salmon  in the fjord ".into(),
            authors: vec!["kari nordmann".into(), " ".into()],
            doi: "https://doi.org/10.5281/zenodo.1234".into(),
            embargo_until: "2027-01-31".into(),
            ..DatasetDraft::default()
        };
        assert_eq!(check_draft(&mut draft, &study()), []);
        assert_eq!((&*draft.title, &*draft.licence), ("Salmon in the fjord", "CC-BY-4.0"));
        assert_eq!((&*draft.authors[0], draft.authors.len()), ("Kari Nordmann", 1));
        assert_eq!(draft.doi, "10.5281/zenodo.1234");
        assert_eq!(lacking(&draft).iter().map(|(field, _)| *field).collect::<Vec<_>>(), ["publisher"]);
    }

    #[test]
    fn what_is_wrong_is_told_at_its_field() {
        let one = |change: &dyn Fn(&mut DatasetDraft)| {
            let mut draft = DatasetDraft::default();
            change(&mut draft);
            told(draft).join("\n")
        };
        assert!(
            one(&|draft| draft.authors = vec!["Kari Normann".into()])
                .contains("did you mean `Kari Nordmann`")
        );
        assert!(
            one(&|draft| draft.authors = vec!["Ola Hansen".into(); 2])
                .starts_with("authors: `Ola Hansen` is named twice")
        );
        assert!(one(&|draft| draft.embargo_until = "31.1.2027".into()).starts_with("embargo_until: "));
        assert!(one(&|draft| draft.embargo_until = "2027-02-30".into()).starts_with("embargo_until: "));
        assert!(one(&|draft| draft.title = "x".repeat(301)).starts_with("title: has 301 characters"));
        assert!(one(&|draft| draft.description = "\u{7}".into()).starts_with("description: has control"));
        let of_query = |query: DatasetQuery| one(&|draft| draft.query = query.clone());
        let empty = DatasetQuery::default;
        assert!(of_query(DatasetQuery { tags: vec!["fish".into()], ..empty() }).starts_with("tags: `fish`"));
        assert!(
            of_query(DatasetQuery { projects: vec!["Trout".into()], ..empty() }).starts_with("projects: ")
        );
        assert!(
            of_query(DatasetQuery { area: "1,2".into(), ..empty() }).starts_with("area: it has 1 corners")
        );
        assert!(
            of_query(DatasetQuery { from_us: Some(9), to_us: Some(9), ..empty() }).starts_with("to_us: ")
        );
        assert!(of_query(DatasetQuery { from_us: Some(-1), ..empty() }).starts_with("from_us: "));
    }

    #[test]
    fn a_doi_is_known_by_its_syntax() {
        for (text, wanted) in [
            ("10.5281/zenodo.1234", "10.5281/zenodo.1234"),
            ("doi:10.1000.10/123(4)-a", "10.1000.10/123(4)-a"),
            ("DOI:10.1000/1", "10.1000/1"),
            ("http://dx.doi.org/10.1000/a/b", "10.1000/a/b"),
            (" ", ""),
        ] {
            assert_eq!(doi(text).as_deref(), Ok(wanted), "{text}");
        }
        for text in [
            "10.123/x",
            "10.5281/",
            "11.5281/x",
            "10.5281",
            "doi:",
            "10.5281/a b",
            "10.5281/æ",
            "10.52x1/a",
            "10.5281/<",
        ] {
            assert!(doi(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_citation_has_authors_year_title_version_publisher_and_doi() {
        let author = |name: &str| DatasetAuthor { name: name.into(), ..DatasetAuthor::default() };
        let version = DatasetVersion {
            number: 2,
            title: "Salmon in the fjord?".into(),
            description: String::new(),
            publisher: "NTNU".into(),
            authors: vec![author("Nordmann, Kari"), author("Hansen, Ola")],
            licence: "CC0-1.0".into(),
            embargo_until: String::new(),
            doi: "10.5281/zenodo.1234".into(),
            query: DatasetQuery::default(),
            vessels: Vec::new(),
            content: DatasetContent::default(),
            published: LogWord { by: "kari".into(), time_us: 1_795_248_000_000_000 },
            citation: String::new(),
        };
        assert_eq!(
            citation(&version),
            "Nordmann, Kari; Hansen, Ola (2026): Salmon in the fjord? Version 2. NTNU. Dataset. \
             https://doi.org/10.5281/zenodo.1234"
        );
    }
}
