//! Currents in NetCDF of the classic format, by the CF conventions.
//!
//! Currents are variables over time, latitude and longitude, in this order, with a depth between time and latitude or
//! without; of several depths the one nearest to the surface is read. Rotated grids, whose rows are not of one latitude,
//! are refused.

use super::header::{Header, Variable, wrong};
use super::{CurrentField, CurrentsError, MOST_CROSSINGS};
use units::UtcTime;

/// What components are called, by `standard_name` and by the name of the variable.
const EAST: ([&str; 2], [&str; 6]) = (
    ["eastward_sea_water_velocity", "surface_eastward_sea_water_velocity"],
    ["u", "uo", "water_u", "u_eastward", "east_mps", "utotal"],
);
const NORTH: ([&str; 2], [&str; 6]) = (
    ["northward_sea_water_velocity", "surface_northward_sea_water_velocity"],
    ["v", "vo", "water_v", "v_northward", "north_mps", "vtotal"],
);
const METRES_A_SECOND: [&str; 7] =
    ["m s-1", "m/s", "m.s-1", "meter second-1", "metre second-1", "m s^-1", "m s**-1"];
/// Longest axis that is read.
const LONGEST_AXIS: usize = 1 << 20;

struct File<'b> {
    bytes: &'b [u8],
    header: Header,
}

pub(super) fn read(bytes: &[u8]) -> Result<CurrentField, CurrentsError> {
    let file = File { bytes, header: Header::read(bytes)? };
    let (east, north) = (file.component("eastward", &EAST)?, file.component("northward", &NORTH)?);
    if east.dimensions != north.dimensions {
        return Err(wrong(format!(
            "{} and {} have other dimensions; give both on one grid",
            east.name, north.name
        )));
    }
    let (time, depth, lat, lon) = match east.dimensions[..] {
        [time, lat, lon] => (time, None, lat, lon),
        [time, depth, lat, lon] => (time, Some(depth), lat, lon),
        _ => {
            return Err(wrong(format!(
                "{} has {} dimensions; give it over time, latitude and longitude",
                east.name,
                east.dimensions.len()
            )));
        }
    };
    let times_s = file.times_s(time)?;
    let (lats, lons) =
        (file.axis(lat, "latitude", "degrees_north")?, file.axis(lon, "longitude", "degrees_east")?);
    let level = depth.map_or(Ok(0), |depth| file.surface(depth))?;
    let crossings = times_s.len().saturating_mul(lats.len()).saturating_mul(lons.len());
    if crossings == 0 {
        return Err(wrong("it has no values; give one time, two latitudes and two longitudes or more"));
    }
    if crossings > MOST_CROSSINGS {
        return Err(wrong(format!(
            "it has {crossings} values; {MOST_CROSSINGS} at most are read: cut it to the area and the time of the route"
        )));
    }
    let mut field = CurrentField { times_s, lats_deg: lats, lons_deg: lons, ..CurrentField::default() };
    field.east_mps = file.levels(east, level, &field)?;
    field.north_mps = file.levels(north, level, &field)?;
    // Latitudes often fall.
    if field.lats_deg.len() > 1 && field.lats_deg[0] > field.lats_deg[1] {
        field.lats_deg.reverse();
        let (rows, columns) = (field.lats_deg.len(), field.lons_deg.len());
        for values in [&mut field.east_mps, &mut field.north_mps] {
            for step in values.chunks_exact_mut(rows * columns) {
                for row in 0..rows / 2 {
                    let (upper, lower) = step.split_at_mut((rows - 1 - row) * columns);
                    upper[row * columns..][..columns].swap_with_slice(&mut lower[..columns]);
                }
            }
        }
    }
    Ok(field)
}

impl File<'_> {
    fn component(
        &self,
        what: &str,
        (standard, usual): &([&str; 2], [&str; 6]),
    ) -> Result<&Variable, CurrentsError> {
        let variables = &self.header.variables;
        let by_standard = variables
            .iter()
            .find(|one| one.text("standard_name").is_some_and(|name| standard.contains(&name)));
        let by_name = || variables.iter().find(|one| usual.contains(&one.name.to_ascii_lowercase().as_str()));
        let found = by_standard.or_else(by_name).ok_or_else(|| {
            let names: Vec<&str> = variables.iter().map(|one| one.name.as_str()).take(20).collect();
            wrong(format!(
                "there is no {what} current: give a variable with the standard_name {}; the file has {}",
                standard[0],
                names.join(", ")
            ))
        })?;
        match found.text("units") {
            Some(units) if !METRES_A_SECOND.contains(&units.trim()) => {
                Err(wrong(format!("{} is in {}; give m s-1", found.name, units.trim())))
            }
            _ => Ok(found),
        }
    }

    /// The variable that says where along a dimension values stand.
    fn coordinate(&self, dimension: usize) -> Result<&Variable, CurrentsError> {
        let name = &self.header.dimensions[dimension].name;
        let found =
            self.header.variables.iter().find(|one| one.name == *name && one.dimensions == [dimension]);
        found.ok_or_else(|| {
            wrong(format!(
                "the dimension {name} has no variable of its name; regrid the file to latitude and longitude"
            ))
        })
    }

    fn axis(&self, dimension: usize, standard: &str, units: &str) -> Result<Vec<f64>, CurrentsError> {
        let variable = self.coordinate(dimension)?;
        let named = variable.text("standard_name").is_some_and(|name| name == standard)
            || variable.text("units").is_some_and(|found| found == units)
            || standard.starts_with(&variable.name.to_ascii_lowercase());
        if !named {
            return Err(wrong(format!(
                "{} is not the {standard}; give currents over time, latitude and longitude, in this order",
                variable.name
            )));
        }
        self.all(variable)
    }

    fn times_s(&self, dimension: usize) -> Result<Vec<f64>, CurrentsError> {
        let variable = self.coordinate(dimension)?;
        let units = variable.text("units").unwrap_or_default();
        let not_time = || {
            wrong(format!(
                "{} is in {units:?}; give a time such as hours since 2026-01-01 00:00:00",
                variable.name
            ))
        };
        let (unit, since) = units.split_once(" since ").ok_or_else(not_time)?;
        let unit_s = match unit.trim().to_ascii_lowercase().as_str() {
            "second" | "seconds" | "s" | "sec" => 1.0,
            "minute" | "minutes" | "min" => 60.0,
            "hour" | "hours" | "h" | "hr" => 3_600.0,
            "day" | "days" | "d" => 86_400.0,
            _ => return Err(not_time()),
        };
        let since = since.trim().trim_end_matches("UTC").trim_end();
        let since_s = since.parse::<UtcTime>().map_err(|_| not_time())?.seconds();
        let all = self.all(variable)?;
        Ok(all.into_iter().map(|value| since_s + unit_s * value).collect())
    }

    /// Number of the depth nearest to the surface.
    fn surface(&self, dimension: usize) -> Result<usize, CurrentsError> {
        if self.header.dimensions[dimension].length == 1 {
            return Ok(0);
        }
        let depths = self.all(self.coordinate(dimension)?)?;
        let by_depth = |one: &(usize, f64), other: &(usize, f64)| one.1.abs().total_cmp(&other.1.abs());
        let nearest = depths.into_iter().enumerate().min_by(by_depth);
        nearest.map(|(number, _)| number).ok_or_else(|| wrong("the depth has no values"))
    }

    /// All values of a variable of one dimension.
    fn all(&self, variable: &Variable) -> Result<Vec<f64>, CurrentsError> {
        let length = variable.dimensions.first().map_or(0, |first| self.header.dimensions[*first].length);
        if length > LONGEST_AXIS {
            return Err(wrong(format!(
                "{} has {length} values; {LONGEST_AXIS} at most are read",
                variable.name
            )));
        }
        let each = if self.header.is_of_records(variable) {
            self.header.record_bytes
        } else {
            variable.kind.bytes()
        };
        let at =
            |number: usize| number.checked_mul(each).and_then(|offset| variable.begin.checked_add(offset));
        (0..length).map(|number| self.number(variable, at(number))).collect()
    }

    fn number(&self, variable: &Variable, at: Option<usize>) -> Result<f64, CurrentsError> {
        let end = at.and_then(|at| at.checked_add(variable.kind.bytes()));
        let bytes = at.zip(end).and_then(|(at, end)| self.bytes.get(at..end));
        let bytes =
            bytes.ok_or_else(|| wrong(format!("the file ends within {}; fetch it again", variable.name)))?;
        Ok(variable.kind.number(bytes))
    }

    /// Values of one depth at all times; what is filled in is not a number.
    fn levels(
        &self,
        variable: &Variable,
        level: usize,
        field: &CurrentField,
    ) -> Result<Vec<f32>, CurrentsError> {
        let (scale, offset) =
            (variable.number("scale_factor").unwrap_or(1.0), variable.number("add_offset").unwrap_or(0.0));
        let missing = [variable.number("_FillValue"), variable.number("missing_value")];
        let of_records = self.header.is_of_records(variable);
        let at_once = self.header.values_at_once(variable);
        let in_step = if of_records { at_once } else { at_once / field.times_s.len().max(1) };
        let step_bytes =
            if of_records { self.header.record_bytes } else { in_step.saturating_mul(variable.kind.bytes()) };
        let in_level = field.lats_deg.len() * field.lons_deg.len();
        let mut values = Vec::new();
        for step in 0..field.times_s.len() {
            for number in 0..in_level {
                let in_step = level.checked_mul(in_level).and_then(|before| before.checked_add(number));
                let within = in_step.and_then(|number| number.checked_mul(variable.kind.bytes()));
                let begin =
                    step.checked_mul(step_bytes).and_then(|before| variable.begin.checked_add(before));
                let at = begin.zip(within).and_then(|(begin, within)| begin.checked_add(within));
                let stored = self.number(variable, at)?;
                let filled = missing.contains(&Some(stored)) || !stored.is_finite() || stored.abs() > 1e30;
                values.push(if filled { f32::NAN } else { (stored * scale + offset) as f32 });
            }
        }
        Ok(values)
    }
}
