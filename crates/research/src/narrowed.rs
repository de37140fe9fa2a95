//! Detections of a part of the sea, and of some projects.

use crate::study::{Heard, Study};
use api::{RegisterProject, Said, say};
use detections::Area;

/// Filters of detections beyond time, vessels and tags; all of them by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Narrowed {
    /// Names of projects as the register has them; all where empty.
    projects: Vec<String>,
    /// Where; everywhere where absent.
    area: Option<Area>,
}

impl Narrowed {
    /// From projects by name, and the corners of an area; nothing is narrowed by what is absent or empty. A text that is no name of a
    /// project is read as several with `;` between them, as addresses of pages have them.
    ///
    /// # Errors
    /// There is no such project in the register, or the area is invalid; the text names the parameter and says what to do.
    pub fn new(projects: &[String], area: Option<&str>, study: &Study) -> Result<Self, Said> {
        let names = projects.iter().flat_map(|text| match study.project_named(text.trim()) {
            Some(_) => vec![text.trim()],
            None => text.split(';').map(str::trim).filter(|name| !name.is_empty()).collect(),
        });
        Self::of(names, area.map(str::trim).filter(|text| !text.is_empty()), study)
    }

    /// From projects by name, and the corners of an area. Empty text is refused, as it would select everything.
    ///
    /// # Errors
    /// Likewise.
    pub fn of<'n>(
        projects: impl IntoIterator<Item = &'n str>,
        area: Option<&str>,
        study: &Study,
    ) -> Result<Self, Said> {
        let known = |name: &str| -> Result<String, Said> {
            if name.trim().is_empty() {
                return Err(say(
                    "project: a name is empty; give the project's name, or leave it out for all",
                )
                .into());
            }
            let found = study.project_named(name.trim()).map(|project| project.name.clone());
            found.ok_or_else(|| {
                let shown: String = name.chars().take(60).collect();
                let text = say("project: the register has no project `{name}`; look at /api/v1/register?kind=project, or `lutra-server register export project`");
                text.with("name", shown).into()
            })
        };
        if area.is_some_and(|text| text.trim().is_empty()) {
            return Err(say("area: it is empty; give 3 to 100 corners as \"lat,lon;lat,lon;...\", or leave it out for everywhere").into());
        }
        let area = area.map(crate::filters::area).transpose();
        let area = area.map_err(|why| Said::from(why).of_field("area"))?;
        Ok(Self { projects: projects.into_iter().map(known).collect::<Result<_, _>>()?, area })
    }

    /// Whether it leaves nothing out.
    pub fn is_all(&self) -> bool {
        self.projects.is_empty() && self.area.is_none()
    }

    /// Whether places are asked about.
    pub(crate) fn has_area(&self) -> bool {
        self.area.is_some()
    }

    /// Whether a detection is wanted.
    pub fn admits(&self, heard: &Heard<'_>) -> bool {
        let place = heard.detection.pose.map(|pose| (pose.place.lat_deg(), pose.place.lon_deg()));
        self.admits_project(heard.project) && self.admits_place(place)
    }

    pub(crate) fn admits_project(&self, project: Option<&RegisterProject>) -> bool {
        self.projects.is_empty() || project.is_some_and(|project| self.projects.contains(&project.name))
    }

    /// Degrees, north and east positive.
    pub(crate) fn admits_place(&self, place: Option<(f64, f64)>) -> bool {
        let Some(area) = &self.area else { return true };
        place.is_some_and(|(lat_deg, lon_deg)| area.contains_deg(lat_deg, lon_deg))
    }
}
