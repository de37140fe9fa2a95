//! `meta.xml`: which files an archive has, and which term each of their columns is (Darwin Core text guide).

use super::facts;

const DARWIN_CORE: &str = "http://rs.tdwg.org/dwc/terms/";
const DUBLIN_CORE: &str = "http://purl.org/dc/terms/";
const OBIS: &str = "http://rs.iobis.org/obis/terms/";

/// Columns of other vocabularies than Darwin Core's own.
const OTHERS: [(&str, &str); 6] = [
    ("type", "http://purl.org/dc/elements/1.1/"),
    ("license", DUBLIN_CORE),
    ("rightsHolder", DUBLIN_CORE),
    ("measurementTypeID", OBIS),
    ("measurementValueID", OBIS),
    ("measurementUnitID", OBIS),
];

/// A table of an archive.
struct Table<'t> {
    element: &'t str,
    class: String,
    file: &'t str,
    header: &'t str,
    /// The element that says in which column the occurrence is named.
    key: &'t str,
}

/// The text.
pub(super) fn meta() -> String {
    let occurrences = Table {
        element: "core",
        class: format!("{DARWIN_CORE}Occurrence"),
        file: super::OCCURRENCES,
        header: super::FORMAT.header,
        key: "id",
    };
    let facts = Table {
        element: "extension",
        class: format!("{OBIS}ExtendedMeasurementOrFact"),
        file: super::FACTS,
        header: facts::HEADER,
        key: "coreid",
    };
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<archive xmlns=\"http://rs.tdwg.org/dwc/text/\" metadata=\"{}\">\n",
        super::DESCRIPTION
    );
    out.push_str(&table(&occurrences));
    out.push_str(&table(&facts));
    out.push_str("</archive>\n");
    out
}

fn table(of: &Table<'_>) -> String {
    let Table { element, class, file, header, key } = of;
    let names: Vec<&str> = header.trim_end().split(',').collect();
    let at = names.iter().position(|name| *name == "occurrenceID").unwrap_or_default();
    let field = |(at, name): (usize, &&str)| format!("    <field index=\"{at}\" term=\"{}\"/>\n", term(name));
    let fields: String = names.iter().enumerate().map(field).collect();
    format!(
        "  <{element} encoding=\"UTF-8\" fieldsTerminatedBy=\",\" linesTerminatedBy=\"\\n\" fieldsEnclosedBy=\"&quot;\" \
         ignoreHeaderLines=\"1\" rowType=\"{class}\">\n    <files>\n      <location>{file}</location>\n    </files>\n    \
         <{key} index=\"{at}\"/>\n{fields}  </{element}>\n"
    )
}

fn term(name: &str) -> String {
    let other = OTHERS.iter().find(|(other, _)| *other == name);
    format!("{}{name}", other.map_or(DARWIN_CORE, |(_, vocabulary)| vocabulary))
}
