//! What a file that describes itself says of its making and of what it holds, besides the rows.

use crate::study::Heard;
use api::{DatasetAuthor, RegisterPerson};
use std::collections::BTreeSet;
use tables::IsoTime;
use units::LatLon;

/// Species, licences and people that are listed at most; registers have fewer by far.
const LISTED: usize = 500;

/// What is said of a file: of a dataset by its version, else by the register alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct About {
    /// Names it among all files; empty where it has no name.
    pub id: String,
    /// Its title.
    pub title: String,
    /// What it is.
    pub summary: String,
    /// The institution that publishes it.
    pub publisher: String,
    /// Who made it, in the order in which they are cited. Those of the register's projects where empty.
    pub creators: Vec<DatasetAuthor>,
    /// Its licence, by SPDX or in own words. Those of the register's projects where empty.
    pub licence: String,
    /// How to cite it.
    pub citation: String,
    /// When it was published, µs since 1970 UTC.
    pub published_us: Option<i64>,
}

impl About {
    /// The title, which no file lacks.
    pub(super) fn title(&self) -> &str {
        if self.title.is_empty() { "Acoustic detections of tags by robotic vessels" } else { &self.title }
    }

    /// The summary, likewise.
    pub(super) fn summary(&self) -> &str {
        if self.summary.is_empty() {
            "Detections of acoustic tags by receivers on uncrewed surface vessels, with the place of the vessel at that moment."
        } else {
            &self.summary
        }
    }
}

/// What the rows of a file reach over, and who has to do with them.
#[derive(Debug, Default)]
pub(super) struct Covered {
    pub(super) first_us: Option<i64>,
    pub(super) last_us: Option<i64>,
    /// When the last of them came ashore, or to the vessel where that is not known.
    pub(super) came_us: Option<i64>,
    /// South, west, north, east, degrees.
    pub(super) box_deg: Option<[f64; 4]>,
    /// Scientific names.
    pub(super) species: BTreeSet<String>,
    pub(super) projects: BTreeSet<String>,
    pub(super) licences: BTreeSet<String>,
    leaders: Vec<DatasetAuthor>,
    /// Size of the cells to whose middles places are coarsened, m.
    pub(super) cell_m: Option<u32>,
}

impl Covered {
    /// Widens it by a detection.
    pub(super) fn take(&mut self, heard: &Heard<'_>) {
        let (time, origin) = (Some(heard.time_us), heard.detection.origin);
        self.first_us = self.first_us.map_or(time, |first| time.map(|time| time.min(first)));
        self.last_us = self.last_us.max(time);
        self.came_us = self.came_us.max(Some(origin.received.unwrap_or(origin.reported).micros()));
        self.cell_m = heard.cell_m;
        if let Some(pose) = heard.detection.pose {
            self.reach(pose.place);
        }
        if let Some(animal) = heard.animal {
            list(&mut self.species, &animal.scientific_name);
        }
        if let Some(project) = heard.project {
            list(&mut self.projects, &project.name);
            list(&mut self.licences, &project.licence);
        }
        if let Some(person) = heard.principal_investigator {
            self.lead(person);
        }
    }

    fn reach(&mut self, place: LatLon) {
        let (lat, lon) = (place.lat_deg(), place.lon_deg());
        let [south, west, north, east] = self.box_deg.unwrap_or([lat, lon, lat, lon]);
        self.box_deg = Some([south.min(lat), west.min(lon), north.max(lat), east.max(lon)]);
    }

    fn lead(&mut self, person: &RegisterPerson) {
        if self.leaders.len() < LISTED && self.leaders.iter().all(|one| one.name != person.name) {
            let RegisterPerson { name, orcid, affiliation, .. } = person.clone();
            self.leaders.push(DatasetAuthor { name, orcid, affiliation });
        }
    }

    /// Who made it: those whom `about` names, else who leads the projects.
    pub(super) fn creators<'c>(&'c self, about: &'c About) -> &'c [DatasetAuthor] {
        if about.creators.is_empty() { &self.leaders } else { &about.creators }
    }

    /// The licence, in words where there is more than one.
    pub(super) fn licence(&self, about: &About) -> String {
        if !about.licence.is_empty() {
            return about.licence.clone();
        }
        let all: Vec<&str> = self.licences.iter().map(String::as_str).collect();
        match all[..] {
            [] => String::new(),
            [one] => one.to_owned(),
            _ => format!("by project: {}", all.join(", ")),
        }
    }

    /// What was done to places, in words; empty where they are as they were measured.
    pub(super) fn coarsening(&self) -> String {
        self.cell_m
            .map_or_else(String::new, |cell_m| format!("places are middles of cells of about {cell_m} m"))
    }
}

fn list(all: &mut BTreeSet<String>, one: &str) {
    if !one.is_empty() && all.len() < LISTED && !all.contains(one) {
        all.insert(one.to_owned());
    }
}

/// `2026-11-21T08:00:00.007Z`.
pub(super) fn iso(time_us: i64) -> String {
    let mut out = Vec::new();
    IsoTime::new().write_ms(&mut out, time_us);
    String::from_utf8_lossy(&out).into_owned()
}

/// For XML, as text and between quotes. XML has no way to write most control characters: a space stands for them.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            letter if letter.is_control() || matches!(letter, '\u{FFFE}' | '\u{FFFF}') => out.push(' '),
            letter => out.push(letter),
        }
    }
    out
}
