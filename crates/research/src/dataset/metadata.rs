//! A version of a dataset as registries, search engines and programs read it: DataCite 4.5 in JSON (schema kernel-4), JSON-LD of
//! schema.org, and the `datapackage.json` of Frictionless Data.

use super::draft::{embargo_us, licence_name, licence_page};
use crate::formats::{ColumnKind, DetectionColumn, LUTRA_COLUMNS};
use api::{DatasetAuthor, DatasetContent, DatasetQuery, DatasetShare, DatasetVersion};
use serde_json::{Map, Value, json};
use units::UtcTime;

/// The described version, and its address.
#[derive(Debug, Clone, Copy)]
pub struct Described<'a> {
    /// The version.
    pub version: &'a DatasetVersion,
    /// The content: its own, or that of a link.
    pub content: &'a DatasetContent,
    /// The link by which it is given, where it is by one: what that leaves out is not described either.
    pub share: Option<&'a DatasetShare>,
    /// Addresses of its page and of its canonical CSV; absent where it is given by a link: descriptions go to registries and search
    /// engines, and the address of a link is its secret.
    pub addresses: Option<(&'a str, &'a str)>,
}

impl Described<'_> {
    /// The query, as far as a recipient may know it: a link that leaves something out does not say what, and one that
    /// coarsens places names no area.
    fn query(&self) -> DatasetQuery {
        let mut query = self.version.query.clone();
        let Some(share) = self.share else { return query };
        query.from_us = query.from_us.max(share.from_us);
        query.to_us = [query.to_us, share.to_us].into_iter().flatten().min();
        if !share.tags.is_empty() {
            query.tags.clone_from(&share.tags);
        }
        if !share.area.is_empty() {
            query.area.clone_from(&share.area);
        }
        if share.precision_m.is_some() {
            query.area.clear();
        }
        query
    }

    /// The coarsening of places, in words.
    fn generalization(&self) -> Option<String> {
        let size_m = self.share?.precision_m?;
        Some(format!(
            "Places are coarsened: each is the middle of a fixed cell of about {size_m} m. Receiver lines, accuracies, noise, \
             and values of sensors that may tell depth are left out."
        ))
    }

    fn year(&self) -> i64 {
        UtcTime::from_micros(self.version.published.time_us).civil().year
    }

    fn is_about(&self) -> String {
        let coarsened = self.generalization().unwrap_or_default();
        let parts = [&*self.version.description, &*coarsened].into_iter().filter(|text| !text.is_empty());
        parts.collect::<Vec<_>>().join("\n\n")
    }

    /// From when to when, as ISO 8601 has it.
    fn time_covered(&self) -> Option<String> {
        let covered = self.content.covered;
        Some(format!("{}/{}", iso(covered.first_us?), iso(covered.last_us?)))
    }

    /// South, west, north and east, degrees.
    fn box_deg(&self) -> Option<[f64; 4]> {
        let covered = self.content.covered;
        Some([covered.south_deg?, covered.west_deg?, covered.north_deg?, covered.east_deg?])
    }
}

/// Whole seconds, UTC.
fn iso(us: i64) -> String {
    format!("{}Z", &UtcTime::from_micros(us).to_string()[..19])
}

fn day(us: i64) -> String {
    UtcTime::from_micros(us).to_string()[..10].to_owned()
}

/// JSON of DataCite's schema 4.5, as a registry takes it to make a DOI, or gives it for one.
pub fn datacite(of: &Described<'_>) -> Value {
    let Described { version, content, addresses, .. } = *of;
    let mut dates = vec![json!({"date": day(version.published.time_us), "dateType": "Issued"})];
    if embargo_us(&version.embargo_until).is_some() {
        dates.push(json!({"date": version.embargo_until, "dateType": "Available"}));
    }
    if let Some(covered) = of.time_covered() {
        dates.push(json!({"date": covered, "dateType": "Collected"}));
    }
    let rights = match licence_page(&version.licence) {
        Some(page) => json!({
            "rights": licence_name(&version.licence), "rightsUri": page, "rightsIdentifier": version.licence,
            "rightsIdentifierScheme": "SPDX", "schemeUri": "https://spdx.org/licenses/",
        }),
        None => json!({"rights": version.licence}),
    };
    let mut all = json!({
        "schemaVersion": "http://datacite.org/schema/kernel-4",
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Acoustic telemetry detections"},
        "creators": version.authors.iter().map(creator).collect::<Vec<_>>(),
        "titles": [{"title": version.title}],
        "publisher": {"name": version.publisher},
        "publicationYear": of.year().to_string(),
        "subjects": [{"subject": "acoustic telemetry"}],
        "dates": dates,
        "sizes": [format!("{} detections", content.rows), format!("{} bytes", content.bytes)],
        "formats": ["text/csv"],
        "version": version.number.to_string(),
        "rightsList": [rights],
    });
    if let Some((page, _)) = addresses {
        all["alternateIdentifiers"] =
            json!([{"alternateIdentifier": page, "alternateIdentifierType": "URL"}]);
    }
    let about = of.is_about();
    if !about.is_empty() {
        all["descriptions"] = json!([{"description": about, "descriptionType": "Abstract"}]);
    }
    if let Some([south, west, north, east]) = of.box_deg() {
        all["geoLocations"] = json!([{"geoLocationBox": {
            "westBoundLongitude": west, "eastBoundLongitude": east, "southBoundLatitude": south, "northBoundLatitude": north,
        }}]);
    }
    if let Some((prefix, suffix)) = version.doi.split_once('/') {
        all["doi"] = json!(version.doi);
        all["prefix"] = json!(prefix);
        all["suffix"] = json!(suffix);
    }
    all
}

fn creator(author: &DatasetAuthor) -> Value {
    let mut creator = json!({"name": author.name, "nameType": "Personal"});
    if let Some((family, given)) = author.name.split_once(',') {
        creator["familyName"] = json!(family.trim());
        creator["givenName"] = json!(given.trim());
    }
    if !author.orcid.is_empty() {
        creator["nameIdentifiers"] = json!([{
            "nameIdentifier": format!("https://orcid.org/{}", author.orcid), "nameIdentifierScheme": "ORCID",
            "schemeUri": "https://orcid.org",
        }]);
    }
    if !author.affiliation.is_empty() {
        creator["affiliation"] = json!([{"name": author.affiliation}]);
    }
    creator
}

/// JSON-LD of schema.org, by which search engines find datasets.
pub fn json_ld(of: &Described<'_>) -> Value {
    let Described { version, content, addresses, .. } = *of;
    let creators = version.authors.iter().map(|author| {
        let mut person = json!({"@type": "Person", "name": author.name});
        if !author.orcid.is_empty() {
            person["@id"] = json!(format!("https://orcid.org/{}", author.orcid));
        }
        if !author.affiliation.is_empty() {
            person["affiliation"] = json!({"@type": "Organization", "name": author.affiliation});
        }
        person
    });
    let mut all = json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": version.title,
        "version": version.number.to_string(),
        "creator": creators.collect::<Vec<_>>(),
        "publisher": {"@type": "Organization", "name": version.publisher},
        "datePublished": day(version.published.time_us),
        "license": licence_page(&version.licence).unwrap_or(&version.licence),
        "citation": version.citation,
        "keywords": ["acoustic telemetry"],
        "isAccessibleForFree": true,
        "distribution": [{
            "@type": "DataDownload", "encodingFormat": "text/csv", "contentSize": format!("{} B", content.bytes),
            "sha256": content.sha256,
        }],
    });
    if let Some((page, file)) = addresses {
        all["url"] = json!(page);
        all["distribution"][0]["contentUrl"] = json!(file);
    }
    let about = of.is_about();
    // Search engines want 50 letters and more.
    all["description"] = if about.is_empty() {
        json!(format!("{} Detections of acoustic tags: {} rows.", version.citation, content.rows))
    } else {
        json!(about)
    };
    if !version.doi.is_empty() {
        let doi = json!(format!("https://doi.org/{}", version.doi));
        if addresses.is_none() {
            all["url"] = doi.clone();
        }
        all["identifier"] = doi;
    }
    if let Some(covered) = of.time_covered() {
        all["temporalCoverage"] = json!(covered);
    }
    if let Some([south, west, north, east]) = of.box_deg() {
        all["spatialCoverage"] = json!({
            "@type": "Place",
            "geo": {"@type": "GeoShape", "box": format!("{south} {west} {north} {east}")},
        });
    }
    all
}

/// Frictionless Data's `datapackage.json` for the canonical CSV, which lies beside it.
pub fn datapackage(of: &Described<'_>) -> Value {
    let Described { version, content, addresses, .. } = *of;
    let contributors = version.authors.iter().map(|author| {
        let mut one = json!({"title": author.name, "role": "author"});
        if !author.orcid.is_empty() {
            one["path"] = json!(format!("https://orcid.org/{}", author.orcid));
        }
        if !author.affiliation.is_empty() {
            one["organization"] = json!(author.affiliation);
        }
        one
    });
    let licence = match licence_page(&version.licence) {
        Some(page) => json!({"name": version.licence, "path": page, "title": licence_name(&version.licence)}),
        None => json!({"name": "other", "title": version.licence}),
    };
    let mut all = json!({
        "profile": "tabular-data-package",
        "name": "lutra-detections",
        "title": version.title,
        "version": version.number.to_string(),
        "created": iso(version.published.time_us),
        "licenses": [licence],
        "contributors": contributors.collect::<Vec<_>>(),
        "keywords": ["acoustic telemetry"],
        "citation": version.citation,
        "query": of.query(),
        "timeZone": "UTC",
        "coordinateReferenceSystem": "EPSG:4326",
        "software": content.software,
        "resources": [{
            "profile": "tabular-data-resource",
            "name": "detections",
            "path": "detections.csv",
            "format": "csv",
            "mediatype": "text/csv",
            "encoding": "utf-8",
            "bytes": content.bytes,
            "hash": format!("sha256:{}", content.sha256),
            "rows": content.rows,
            "dialect": {"delimiter": ",", "lineTerminator": "\n", "quoteChar": "\"", "doubleQuote": true, "header": true},
            "schema": {"fields": fields(), "missingValues": [""]},
        }],
    });
    let about = of.is_about();
    if !about.is_empty() {
        all["description"] = json!(about);
    }
    if let Some((page, _)) = addresses {
        all["homepage"] = json!(page);
    }
    if !version.doi.is_empty() {
        all["id"] = json!(format!("https://doi.org/{}", version.doi));
    }
    if let Some(text) = of.generalization() {
        all["dataGeneralizations"] = json!(text);
    }
    all
}

fn fields() -> Vec<Value> {
    let field = |column: &DetectionColumn| {
        let mut field = Map::new();
        field.insert("name".to_owned(), json!(column.name));
        let kind = match column.kind {
            ColumnKind::Whole => "integer",
            ColumnKind::Real => "number",
            ColumnKind::Time => "datetime",
            ColumnKind::Text => "string",
        };
        field.insert("type".to_owned(), json!(kind));
        if column.kind == ColumnKind::Time {
            // The default format has no parts of a second.
            field.insert("format".to_owned(), json!("%Y-%m-%dT%H:%M:%S.%fZ"));
        }
        if let Some(unit) = column.unit() {
            field.insert("unit".to_owned(), json!(unit));
        }
        field.insert("description".to_owned(), json!(column.about));
        Value::Object(field)
    };
    LUTRA_COLUMNS.iter().map(field).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::{DatasetCovered, LogWord};

    fn version() -> DatasetVersion {
        let author = DatasetAuthor {
            name: "Nordmann, Kari".into(),
            orcid: "0000-0002-1825-0097".into(),
            affiliation: "NTNU".into(),
        };
        let covered = DatasetCovered {
            first_us: Some(1_795_248_000_007_000),
            last_us: Some(1_795_248_060_007_000),
            south_deg: Some(63.4),
            north_deg: Some(63.5),
            west_deg: Some(10.3),
            east_deg: Some(10.4),
        };
        DatasetVersion {
            number: 1,
            title: "Salmon".into(),
            description: "Tags heard by one boat.".into(),
            publisher: "NTNU".into(),
            authors: vec![author],
            licence: "CC-BY-4.0".into(),
            embargo_until: "2027-01-31".into(),
            doi: "10.5281/zenodo.1234".into(),
            query: DatasetQuery {
                tags: vec!["S256-101".into(), "S256-102".into()],
                area: "63,10;64,10;64,11".into(),
                ..DatasetQuery::default()
            },
            vessels: Vec::new(),
            content: DatasetContent {
                rows: 2,
                bytes: 300,
                sha256: "ab".into(),
                covered,
                ..DatasetContent::default()
            },
            published: LogWord { by: "kari".into(), time_us: 1_795_248_000_000_000 },
            citation: "Nordmann, Kari (2026): Salmon.".into(),
        }
    }

    fn share(precision_m: Option<u32>) -> DatasetShare {
        DatasetShare {
            person: None,
            id: 1,
            version: 1,
            label: "Ola".into(),
            has_password: false,
            expires_us: 0,
            from_us: Some(7),
            to_us: None,
            tags: vec!["S256-101".into()],
            area: "63.1,10.1;63.9,10.1;63.9,10.9".into(),
            precision_m,
            content: DatasetContent::default(),
            had_changed: false,
            made: LogWord { by: "kari".into(), time_us: 0 },
            revoked: None,
            views: 0,
            downloads: 0,
            used_us: None,
        }
    }

    fn described<'a>(version: &'a DatasetVersion, share: Option<&'a DatasetShare>) -> Described<'a> {
        let own = ("https://lutra.example/datasets/1", "https://lutra.example/detections.csv");
        Described { version, content: &version.content, share, addresses: share.is_none().then_some(own) }
    }

    #[test]
    fn a_registry_gets_what_its_schema_asks_for() {
        let version = version();
        let all = datacite(&described(&version, None));
        // Required by schema 4.5: identifier, creators, titles, publisher, year, type.
        assert_eq!((&all["doi"], &all["prefix"]), (&json!("10.5281/zenodo.1234"), &json!("10.5281")));
        assert_eq!(
            all["creators"][0]["nameIdentifiers"][0]["nameIdentifier"],
            "https://orcid.org/0000-0002-1825-0097"
        );
        assert_eq!(
            (&all["creators"][0]["familyName"], &all["creators"][0]["givenName"]),
            (&json!("Nordmann"), &json!("Kari"))
        );
        assert_eq!(
            (&all["publicationYear"], &all["types"]["resourceTypeGeneral"]),
            (&json!("2026"), &json!("Dataset"))
        );
        assert_eq!(all["dates"][1], json!({"date": "2027-01-31", "dateType": "Available"}));
        assert_eq!(all["dates"][2]["date"], "2026-11-21T08:00:00Z/2026-11-21T08:01:00Z");
        assert_eq!(all["rightsList"][0]["rightsIdentifier"], "CC-BY-4.0");
        let own = DatasetVersion { licence: "Ask first".into(), doi: String::new(), ..version };
        let all = datacite(&described(&own, None));
        assert_eq!(all["rightsList"], json!([{"rights": "Ask first"}]));
        assert!(all.get("doi").is_none(), "a DOI that is not given is left out");
    }

    #[test]
    fn a_package_has_a_type_for_every_column_and_the_hash_of_the_file() {
        let version = version();
        let all = datapackage(&described(&version, None));
        let resource = &all["resources"][0];
        assert_eq!((&resource["hash"], &resource["rows"]), (&json!("sha256:ab"), &json!(2)));
        assert_eq!(resource["schema"]["fields"].as_array().unwrap().len(), LUTRA_COLUMNS.len());
        assert_eq!(all["query"]["tags"], json!(["S256-101", "S256-102"]));
        assert_eq!(json_ld(&described(&version, None))["distribution"][0]["sha256"], "ab");
    }

    #[test]
    fn what_a_link_leaves_out_is_not_described() {
        let version = version();
        let exact = share(None);
        let query = datapackage(&described(&version, Some(&exact)))["query"].clone();
        assert_eq!((&query["tags"], &query["from_us"]), (&json!(["S256-101"]), &json!(7)));
        assert_eq!(query["area"], exact.area);
        let coarse = share(Some(1_000));
        let all = datapackage(&described(&version, Some(&coarse)));
        assert_eq!(all["query"]["area"], "", "corners would tell places better than the cells do");
        assert!(all["dataGeneralizations"].as_str().unwrap().contains("about 1000 m"));
        for all in
            [datacite(&described(&version, Some(&coarse))), json_ld(&described(&version, Some(&coarse)))]
        {
            assert!(all.to_string().contains("coarsened") && !all.to_string().contains("S256-102"), "{all}");
        }
        let all = json_ld(&described(&version, Some(&exact)));
        assert_eq!(all["url"], "https://doi.org/10.5281/zenodo.1234", "no address but that of the DOI");
        for describe in [datacite, json_ld, datapackage] {
            assert!(!describe(&described(&version, Some(&exact))).to_string().contains("lutra.example"));
            assert!(describe(&described(&version, None)).to_string().contains("lutra.example"));
        }
    }
}
