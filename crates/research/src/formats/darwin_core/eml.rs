//! `eml.xml`: who made an archive, under which licence, and what it reaches over (Ecological Metadata Language 2.2.0, in GBIF's profile).
//!
//! It says what is known and no more: where the register names nobody, that stands there as the name of the creator's position.

use super::super::about::{About, Covered, escaped, iso};
use super::Keep;
use api::DatasetAuthor;
use std::fmt::Write as _;

/// The text.
pub(super) fn eml(about: &About, covered: &Covered, keep: Keep) -> String {
    let id = if about.id.is_empty() { "lutra/detections" } else { &about.id };
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<eml:eml xmlns:eml=\"https://eml.ecoinformatics.org/eml-2.2.0\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:schemaLocation=\"https://eml.ecoinformatics.org/eml-2.2.0 \
         https://rs.gbif.org/schema/eml-gbif-profile/1.3/eml.xsd\" packageId=\"{}\" system=\"lutra\" \
         scope=\"system\" xml:lang=\"en\">\n<dataset>\n",
        escaped(id)
    );
    element(&mut out, "title", about.title());
    let creators = covered.creators(about);
    out.push_str(&people("creator", creators, &about.publisher));
    out.push_str(&people("metadataProvider", creators, &about.publisher));
    if let Some(us) = about.published_us {
        element(&mut out, "pubDate", &iso(us)[..10]);
    }
    element(&mut out, "language", "en");
    paragraphs(&mut out, "abstract", about.summary());
    let licence = covered.licence(about);
    if !licence.is_empty() {
        paragraphs(&mut out, "intellectualRights", &licence);
    }
    coverage(&mut out, covered);
    out.push_str(&people("contact", &creators[..creators.len().min(1)], &about.publisher));
    methods(&mut out, covered, keep);
    out.push_str("</dataset>\n");
    if !about.citation.is_empty() {
        let citation = escaped(&about.citation);
        let _ = writeln!(
            out,
            "<additionalMetadata><metadata><gbif><citation>{citation}</citation></gbif></metadata></additionalMetadata>"
        );
    }
    out.push_str("</eml:eml>\n");
    out
}

// Writing to a text cannot fail.
fn element(out: &mut String, name: &str, text: &str) {
    let _ = writeln!(out, "<{name}>{}</{name}>", escaped(text));
}

fn paragraphs(out: &mut String, name: &str, text: &str) {
    let _ = write!(out, "<{name}>");
    for paragraph in text.split("\n\n").filter(|one| !one.trim().is_empty()) {
        let _ = write!(out, "<para>{}</para>", escaped(paragraph));
    }
    let _ = writeln!(out, "</{name}>");
}

/// People, else the institution, else that nobody is named.
fn people(element: &str, people: &[DatasetAuthor], publisher: &str) -> String {
    if people.is_empty() {
        let (name, text) = match publisher {
            "" => ("positionName", "not named in the register"),
            publisher => ("organizationName", publisher),
        };
        return format!("<{element}><{name}>{}</{name}></{element}>\n", escaped(text));
    }
    people.iter().map(|person| one_person(element, person)).collect()
}

/// Given and family name: of `Nordmann, Kari`, else the last word is the family's.
fn named(name: &str) -> (&str, &str) {
    match name.split_once(',') {
        Some((last, given)) => (given.trim(), last.trim()),
        None => name.rsplit_once(' ').unwrap_or(("", name)),
    }
}

fn one_person(element: &str, person: &DatasetAuthor) -> String {
    let (given, last) = named(person.name.trim());
    let mut out = format!("<{element}><individualName>");
    if !given.is_empty() {
        let _ = write!(out, "<givenName>{}</givenName>", escaped(given));
    }
    let _ = write!(out, "<surName>{}</surName></individualName>", escaped(last));
    if !person.affiliation.is_empty() {
        let _ = write!(out, "<organizationName>{}</organizationName>", escaped(&person.affiliation));
    }
    if !person.orcid.is_empty() {
        let _ = write!(out, "<userId directory=\"https://orcid.org/\">{}</userId>", escaped(&person.orcid));
    }
    let _ = writeln!(out, "</{element}>");
    out
}

fn coverage(out: &mut String, covered: &Covered) {
    let mut parts = String::new();
    if let Some([south, west, north, east]) = covered.box_deg {
        let coarse = covered.coarsening();
        let text = if coarse.is_empty() {
            "Where the vessels heard tags".to_owned()
        } else {
            format!("Where the vessels heard tags; {coarse}")
        };
        let _ = writeln!(
            parts,
            "<geographicCoverage><geographicDescription>{text}</geographicDescription><boundingCoordinates>\
             <westBoundingCoordinate>{west:.8}</westBoundingCoordinate><eastBoundingCoordinate>{east:.8}</eastBoundingCoordinate>\
             <northBoundingCoordinate>{north:.8}</northBoundingCoordinate><southBoundingCoordinate>{south:.8}</southBoundingCoordinate>\
             </boundingCoordinates></geographicCoverage>"
        );
    }
    if let (Some(first), Some(last)) = (covered.first_us, covered.last_us) {
        let _ = writeln!(
            parts,
            "<temporalCoverage><rangeOfDates><beginDate><calendarDate>{}</calendarDate></beginDate><endDate><calendarDate>{}\
             </calendarDate></endDate></rangeOfDates></temporalCoverage>",
            &iso(first)[..10],
            &iso(last)[..10]
        );
    }
    if !covered.species.is_empty() {
        parts.push_str("<taxonomicCoverage>");
        for name in &covered.species {
            let _ = write!(
                parts,
                "<taxonomicClassification><taxonRankValue>{}</taxonRankValue>\
                 </taxonomicClassification>",
                escaped(name)
            );
        }
        parts.push_str("</taxonomicCoverage>\n");
    }
    if !parts.is_empty() {
        let _ = writeln!(out, "<coverage>\n{parts}</coverage>");
    }
}

fn methods(out: &mut String, covered: &Covered, keep: Keep) {
    let kept = match keep {
        Keep::FirstOfHour => {
            "Of each animal, vessel and hour (UTC) the first detection is kept; dataGeneralizations tells of how many it is the first."
        }
        Keep::Every => "Every detection is kept.",
    };
    let coarse = match covered.cell_m {
        Some(cell_m) => {
            format!("Places are coarsened: each is the middle of a fixed cell of about {cell_m} m.")
        }
        None => String::new(),
    };
    paragraphs_in(
        out,
        &[
            "Acoustic receivers on uncrewed surface vessels listened for tags in animals. The place of an occurrence is that of the \
             vessel at that moment, not of the animal: coordinateUncertaintyInMeters says how far away the animal may have been.",
            kept,
            &coarse,
        ],
    );
}

fn paragraphs_in(out: &mut String, texts: &[&str]) {
    out.push_str("<methods><methodStep><description>");
    for text in texts.iter().filter(|text| !text.is_empty()) {
        let _ = write!(out, "<para>{}</para>", escaped(text));
    }
    out.push_str("</description></methodStep></methods>\n");
}
