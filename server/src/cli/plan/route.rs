//! `plan route`: one route, or one for each line of a file.

use super::classic::ClassicArguments;
use super::objective::ObjectiveArguments;
use super::zones;
use crate::cli::Common;
use crate::cli::chart::{index, place};
use crate::cli::say::{complain, counted, say};
use anyhow::{Context as _, anyhow, bail, ensure};
use api::{PlanDocument, PlanPlace, PlanSpeed, PlanStep, PlanTask, SpeedUnit};
use chartdb::ChartDb;
use charts::depth_index::{ChartTrust, Demand};
use clap::Args;
use guard::GuardLimits;
use planner::{
    Cancel, End, InTraffic, LegCost, Moved, Narrow, Needs, Objective, Passable, PlanError, Progress, Refusal,
    Request, Route, RouteLeg, Router,
};
use serde::Deserialize;
use serde_json::{Value, json};
use shore::charts::Traffic;
use shore::plans::{self, Format};
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use units::LatLon;

/// The search for a long way is reported each time so many tiles were searched.
const TILES_BETWEEN_REPORTS: usize = 20;
/// What is said where the time ends while smaller demands are looked for.
const NOT_LOOKED_TO_THE_END: &str =
    "; smaller depths and clearances were not looked for to the end: the time of --give-up-after is used up";
/// Longer lines of a file of pairs are refused (bytes).
const LONGEST_LINE: usize = 64 * 1024;

#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  lutra-server plan route --from 63.4402,10.3951 --to 63.4521,10.2870 --min-depth 5 --clearance 25
  lutra-server plan route --from 63.44,10.40 --via 63.47,10.35 --to 63.45,10.29 --output home.gpx
  lutra-server plan route --from 63.44,10.40 --to 63.45,10.29 --avoid farms.geojson --current 0.4@250
  lutra-server plan route --from 63.44,10.40 --to 63.45,10.29 --alternatives 2
  lutra-server plan route --from 63.44,10.40 --to 63.45,10.29 --objective fastest --current-field tide.csv
  lutra-server plan route --from 63.44,10.40 --to 63.45,10.29 --prefer-depth 20 --prefer-off 100
  lutra-server plan route --db chart.gpkg --pairs pairs.jsonl > routes.jsonl
  lutra-server plan route --from 63.44,10.40 --to 63.45,10.29 --clearance 0 --classic --resolution 50 --neighbours 16

Each line of a file of pairs is one JSON object, of which depth and clearance may be left out; each gives one line:
  {\"id\": 1, \"from\": [63.44, 10.40], \"to\": [63.45, 10.29], \"min_depth\": 5, \"clearance\": 25}
time_us is what the answer took; learn_us, where it is given, what was spent before it on water in which a search was long.

A current field is CSV with the columns time,lat,lon,east_mps,north_mps (ISO 8601, degrees, m/s), or NetCDF of the
classic format by the CF conventions. Beyond its edges and times the current is not known: then there is no time.

It exits with a failure if no route exists; with --pairs, if a line is malformed."
)]
pub(super) struct RouteArguments {
    /// The chart set, a GeoPackage [default: charts.set of the configuration].
    #[arg(long, value_name = "FILE")]
    db: Option<PathBuf>,
    /// Start in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, required_unless_present = "pairs")]
    from: Option<LatLon>,
    /// Goal in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, required_unless_present = "pairs")]
    to: Option<LatLon>,
    /// A place to pass; may be repeated.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    via: Vec<LatLon>,
    /// Routes for a file of start and goal pairs, one JSON object a line; - reads standard input.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from", "to", "via", "output"])]
    pairs: Option<PathBuf>,
    /// Least charted depth (m) [default: charts.autonomous_m of the configuration].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    min_depth: Option<f64>,
    /// Distance to keep from all that is not so deep (m) [default: what the guard demands].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    clearance: Option<f64>,
    /// A start or goal too near land, shallow water or a danger is moved to open water, by so much at most (m).
    #[arg(long, value_name = "M", default_value_t = 1000.0)]
    move_up_to: f64,
    /// Corners are joined where legs would be shorter (m).
    #[arg(long, value_name = "M", default_value_t = 15.0)]
    least_leg: f64,
    /// Turning radius of the vessel (m): turns keep the depth and distance too, or are warned of [default: not known].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    turn_radius: Option<f64>,
    /// How far the vessel may be off its track before its path monitor ends the plan (m): where danger is nearer, it is warned of.
    #[arg(long, value_name = "M", default_value_t = shore::routing::STRAY_M, allow_negative_numbers = true)]
    stray: f64,
    /// Show so many other routes as well, 0 to 3, that pass islands and shoals on the other side.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=3), conflicts_with_all = ["via", "pairs"])]
    alternatives: u8,
    /// GeoJSON file with polygons to avoid; may be repeated.
    #[arg(long, value_name = "FILE")]
    avoid: Vec<PathBuf>,
    /// GeoJSON file with one polygon to stay within.
    #[arg(long, value_name = "FILE")]
    within: Option<PathBuf>,
    #[command(flatten)]
    objective: ObjectiveArguments,
    #[command(flatten)]
    classic: ClassicArguments,
    /// Height of the water above chart datum (m).
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true)]
    water_level: f64,
    /// Allow for the errors that the chart gives for its depths and positions (CATZOC).
    #[arg(long)]
    errors: bool,
    /// Stop the search for a route, and for what would do in its place, after so many seconds.
    #[arg(long, value_name = "S", default_value_t = 300)]
    give_up_after: u64,
    /// Speed through the water for time and energy (m/s); for the least energy the greatest one.
    #[arg(long, value_name = "MPS", default_value_t = 1.5)]
    speed: f64,
    /// Write the route as a plan to a file: .geojson, .gpx, or .json for an IMC PlanSpecification.
    #[arg(short, long, alias = "out", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Answer in JSON, for scripts.
    #[arg(long)]
    json: bool,
}

/// One line of a file of pairs.
#[derive(Debug, Deserialize)]
struct Pair {
    #[serde(default)]
    id: Value,
    from: [f64; 2],
    to: [f64; 2],
    min_depth: Option<f64>,
    clearance: Option<f64>,
}

/// Settings shared by all routes of one call.
struct Terms<'a> {
    arguments: &'a RouteArguments,
    limits: GuardLimits,
    objective: Objective,
    router: Router,
    traffic: Option<Arc<Traffic>>,
}

pub(super) fn route(common: &Common, arguments: &RouteArguments) -> anyhow::Result<()> {
    ensure!(arguments.speed > 0.0 && arguments.speed.is_finite(), "--speed: give a speed above 0 m/s");
    let lengths = [
        ("--move-up-to", arguments.move_up_to),
        ("--least-leg", arguments.least_leg),
        ("--stray", arguments.stray),
    ];
    for (name, value) in lengths {
        ensure!(value >= 0.0 && value.is_finite(), "{name}: give a length of 0 m or more");
    }
    let radius = arguments.turn_radius.unwrap_or(0.0);
    ensure!((0.0..=2_000.0).contains(&radius), "--turn-radius: give a radius of 0 to 2000 m");
    arguments.classic.validate()?;
    let format = arguments.output.as_deref().map(format).transpose()?;
    let config = common.load(Vec::new())?;
    let (db, limits) = (arguments.db.clone().unwrap_or_else(|| config.chart_set()), config.charts.limits());
    // Distance from borders: as the guard demands from dangers, or as requested.
    let margin_m = arguments.clearance.unwrap_or(f64::INFINITY).min(limits.half_width_m()).max(0.0);
    let zones = zones::read(&arguments.avoid, arguments.within.as_deref(), margin_m)?;
    let router = Router::new(Arc::new(index(&db)?));
    let objective = arguments.objective.read(arguments.speed)?;
    let router = router.in_zones(zones.unwrap_or_default()).by_objective(objective.clone())?;
    let traffic = if objective.traffic_factor > 1.0 {
        let set = ChartDb::open(&db).with_context(|| db.display().to_string())?;
        Some(Arc::new(Traffic::new(&db, set.charts()?)))
    } else {
        None
    };
    let terms = Terms { arguments, limits, objective, router, traffic };
    match &arguments.pairs {
        Some(pairs) => terms.pairs(pairs),
        None => terms.one(format),
    }
}

fn format(out: &Path) -> anyhow::Result<Format> {
    match out.extension().and_then(|ending| ending.to_str()) {
        Some("geojson") => Ok(Format::GeoJson),
        Some("gpx") => Ok(Format::Gpx),
        Some("json") => Ok(Format::Imc),
        _ => bail!("{}: end its name in .geojson, .gpx or .json (IMC PlanSpecification)", out.display()),
    }
}

impl Terms<'_> {
    /// A requested depth or clearance is used unchanged; else the guard's, with its position uncertainty.
    fn needs(&self, min_depth: Option<f64>, clearance: Option<f64>) -> Needs {
        let limits = &self.limits;
        let depth_m = min_depth.or(self.arguments.min_depth);
        let clearance_m = clearance.or(self.arguments.clearance);
        let plain = depth_m.map_or_else(|| limits.demand(limits.autonomous_m), Demand::least_depth);
        let demand = Demand {
            water_level_m: self.arguments.water_level,
            air_draught_m: limits.air_draught_m,
            entry: limits.entry,
            position_m: if clearance_m.is_some() { 0.0 } else { limits.position_m },
            trust: if self.arguments.errors {
                ChartTrust::AllErrors(ChartTrust::STANDARD)
            } else {
                limits.trust
            },
            ..plain
        };
        Needs { demand, clearance_m: clearance_m.unwrap_or_else(|| limits.half_width_m()) }
    }

    /// The same, with the traffic of the chart around these places.
    fn near(&self, places: &[LatLon]) -> anyhow::Result<Self> {
        let traffic = self.traffic.as_ref().map_or_else(Vec::new, |traffic| traffic.near(places));
        let objective = Objective { traffic, ..self.objective.clone() };
        let router = self.router.by_objective(objective.clone())?;
        Ok(Self { objective, router, traffic: self.traffic.clone(), ..*self })
    }

    /// Distance to danger that leaves room for a vessel off its track (m).
    fn room_m(&self) -> f64 {
        self.limits.room_m(self.arguments.stray)
    }

    fn cancel<'a>(&self, spent: &'a dyn Fn() -> Duration) -> Cancel<'a> {
        Cancel::never().within(Duration::from_secs(self.arguments.give_up_after), spent)
    }

    fn request(&self, from: LatLon, to: LatLon) -> Request {
        let RouteArguments { move_up_to, least_leg, turn_radius, alternatives, .. } = self.arguments;
        Request {
            move_up_to_m: *move_up_to,
            least_leg_m: *least_leg,
            turn_radius_m: *turn_radius,
            alternatives: usize::from(*alternatives),
            ..Request::new(from, to)
        }
    }

    fn one(&self, format: Option<Format>) -> anyhow::Result<()> {
        let arguments = self.arguments;
        let (Some(from), Some(to)) = (arguments.from, arguments.to) else { bail!("give --from and --to") };
        let needs = self.needs(None, None);
        let request = self.request(from, to);
        let places: Vec<LatLon> =
            [from].into_iter().chain(arguments.via.iter().copied()).chain([to]).collect();
        self.near(&places)?.planned(&places, (&request, &needs), format)
    }

    /// Plans one route and prints it, or why no route exists.
    fn planned(
        &self,
        places: &[LatLon],
        (request, needs): (&Request, &Needs),
        format: Option<Format>,
    ) -> anyhow::Result<()> {
        let arguments = self.arguments;
        let began = Instant::now();
        let spent = || began.elapsed();
        let cancel = self.cancel(&spent).reporting(&report);
        match self.router.route_by(places, request, needs, &cancel) {
            Ok(route) => {
                let time_us = began.elapsed().as_micros();
                let took_ms = began.elapsed().as_secs_f64() * 1e3;
                let compared = if arguments.classic.is_asked() {
                    let index = self.router.index();
                    Some(arguments.classic.compared(index, (&route, took_ms), needs, &cancel)?)
                } else {
                    None
                };
                if let (Some(out), Some(format)) = (&arguments.output, format) {
                    let speed_mps = route.speed_mps(&self.objective);
                    let slow = write(out, format, &route, (speed_mps, &route.reckon(&self.objective)))?;
                    if slow && format == Format::Gpx {
                        complain!(
                            "{}: GPX has no speeds, so it does not keep the speed limits; write .json or .geojson",
                            out.display()
                        );
                    } else if slow {
                        complain!(
                            "{}: legs that enter an area with a speed limit keep it from end to end, so the plan takes longer than is said here",
                            out.display()
                        );
                    }
                }
                if arguments.json {
                    let mut answer = self.described(&Value::Null, &route, time_us);
                    let others = route.alternatives.iter();
                    let others = others.map(|other| self.described(&Value::Null, other, time_us));
                    answer["alternatives"] = others.collect();
                    if let Some(compared) = compared {
                        answer["classic"] = compared.json();
                    }
                    say!("{answer}");
                } else {
                    self.print(&route, needs);
                    self.print_shortest(&route, needs);
                    self.print_alternatives(&route, needs);
                    if let Some(compared) = compared {
                        compared.print();
                    }
                }
                Ok(())
            }
            Err((stretch, refusal)) => {
                let ends = Request { from: places[stretch], to: places[stretch + 1], ..*request };
                self.refuse(&ends, needs, &refusal, &cancel)
            }
        }
    }

    /// Says that no route exists, with what would do as far as the time allows to look for it.
    fn refuse(
        &self,
        ends: &Request,
        needs: &Needs,
        refusal: &Refusal,
        cancel: &Cancel<'_>,
    ) -> anyhow::Result<()> {
        let (mut passable, mut would_do_words) = (None, String::new());
        if matches!(refusal, Refusal::NoWay { .. }) {
            match self.router.passable(ends, needs, cancel) {
                Ok(found) => {
                    would_do_words = would_do_text(&found);
                    passable = Some(found);
                }
                Err(PlanError::OutOfTime) => NOT_LOOKED_TO_THE_END.clone_into(&mut would_do_words),
                Err(error) => return Err(error.into()),
            }
        }
        if self.arguments.json {
            let mut value = refused(&Value::Null, refusal);
            if let Some(passable) = &passable {
                would_do(&mut value, passable);
            }
            say!("{value}");
        }
        Err(anyhow!("no route: {refusal}{would_do_words}"))
    }

    /// One answer a line, in the order of the file.
    fn pairs(&self, file: &Path) -> anyhow::Result<()> {
        let reader: Box<dyn std::io::Read> = if file == Path::new("-") {
            Box::new(std::io::stdin())
        } else {
            Box::new(File::open(file).with_context(|| file.display().to_string())?)
        };
        let mut reader = BufReader::new(reader);
        let (mut bad, mut number) = (0, 0_u64);
        let mut line = Vec::new();
        loop {
            line.clear();
            // A file without line ends must not fill the memory.
            let mut start = reader.by_ref().take(LONGEST_LINE as u64 + 1);
            if start.read_until(b'\n', &mut line).with_context(|| file.display().to_string())? == 0 {
                break;
            }
            number += 1;
            if line.len() > LONGEST_LINE {
                bail!(
                    "{}: line {number} is longer than {LONGEST_LINE} bytes; one JSON object a line is read",
                    file.display()
                );
            }
            if line.trim_ascii().is_empty() {
                continue;
            }
            match self.pair(&line) {
                Ok(answer) => say!("{answer}"),
                Err(text) => {
                    bad += 1;
                    let reason = format!("line {number}: {text}");
                    let id = serde_json::from_slice::<Value>(&line)
                        .ok()
                        .map_or(Value::Null, |value| value["id"].clone());
                    say!("{}", json!({"id": id, "ok": false, "code": "malformed", "reason": reason}));
                }
            }
        }
        ensure!(bad == 0, "{}: malformed lines: {bad}; their answers say why", file.display());
        Ok(())
    }

    fn pair(&self, line: &[u8]) -> Result<Value, String> {
        let pair: Pair = serde_json::from_slice(line).map_err(|error| error.to_string())?;
        let place = |name: &str, [lat, lon]: [f64; 2]| {
            LatLon::from_deg(lat, lon)
                .map_err(|error| format!("{name}: {lat}, {lon} is not a place: {error}"))
        };
        let request = self.request(place("from", pair.from)?, place("to", pair.to)?);
        let needs = self.needs(pair.min_depth, pair.clearance);
        needs.validate().map_err(|error| error.to_string())?;
        let near = self.near(&[request.from, request.to]).map_err(|error| error.to_string())?;
        let began = Instant::now();
        let spent = || began.elapsed();
        // Where the search for an earlier pair was long, the further ones gain by it. Like preparing water it is done once.
        let learned = self.router.learn(&self.cancel(&spent)).map_err(|error| error.to_string())?;
        let learn_us = began.elapsed().as_micros();
        let began = Instant::now();
        let spent = || began.elapsed();
        let answer = near.router.route(&request, &needs, &self.cancel(&spent));
        let time_us = began.elapsed().as_micros();
        let mut value = match answer {
            Ok(route) => near.described(&pair.id, &route, time_us),
            Err(refusal) => refused(&pair.id, &refusal),
        };
        value["time_us"] = json!(time_us);
        if learned {
            value["learn_us"] = json!(learn_us);
        }
        Ok(value)
    }

    fn described(&self, id: &Value, route: &Route, time_us: u128) -> Value {
        let (speed_mps, costs) = (route.speed_mps(&self.objective), route.reckon(&self.objective));
        let points: Vec<[f64; 2]> = route.places().map(|place| [place.lat_deg(), place.lon_deg()]).collect();
        let legs: Vec<Value> = route
            .legs
            .iter()
            .zip(&costs)
            .map(|(leg, cost)| {
                json!({"length_m": leg.length_m, "duration_s": cost.duration_s,
                       "energy_wh": cost.energy_j.map(|energy_j| energy_j / 3_600.0), "min_depth_m": leg.worst.water.least_m(),
                       "limit_mps": cost.limit_mps, "margin_m": leg.worst.margin_m, "clearance_m": leg.clearance_m,
                       "turn_deg": leg.turn.map(|turn| turn.change_rad.to_degrees()),
                       "traffic": cost.traffic.map(traffic_words),
                       "turn_warning": turn_warning(leg)})
            })
            .collect();
        let moved = |moved: Option<Moved>| moved.map(|moved| moved.distance_m);
        let via = route.moved_via.iter();
        let via: Vec<Value> =
            via.map(|(number, moved)| json!({"via": number, "moved_m": moved.distance_m})).collect();
        let (duration_s, energy_wh) = sum(&costs);
        let unknown_m: f64 = costs.iter().map(|cost| cost.unknown_m).sum();
        let shortest = route.shortest.as_ref().map(|shortest| self.described(id, shortest, time_us));
        json!({"id": id, "ok": true, "length_m": route.length_m, "time_us": time_us, "points": points,
               "min_depth_m": route.least_depth_m(), "min_clearance_m": route.least_clearance_m(),
               "duration_s": duration_s, "energy_wh": energy_wh, "speed_mps": speed_mps,
               "current_unknown_m": unknown_m, "current_too_strong": costs.iter().any(|cost| cost.too_strong), "shortest": shortest,
               "part_only": route.of_part,
               "narrow": route.narrow(self.room_m()).map(|Narrow { leg, least_m, legs, length_m }| {
                   json!({"needed_m": self.room_m(), "leg": leg, "least_m": least_m, "legs": legs, "length_m": length_m})
               }),
               "moved_via": via, "moved_start_m": moved(route.moved_start), "moved_goal_m": moved(route.moved_goal), "legs": legs})
    }

    fn print_shortest(&self, route: &Route, needs: &Needs) {
        if let Some(shortest) = &route.shortest {
            let shorter_m = route.length_m - shortest.length_m;
            // Joining corners can make the shortest one a little longer.
            let than = if shorter_m < 0.0 { "longer" } else { "shorter" };
            say!("\nthe shortest route, {:.0} m {than}:", shorter_m.abs());
            self.print(shortest, needs);
        } else if !self.objective.is_shortest() {
            say!("this is the shortest route too");
        }
    }

    fn print_alternatives(&self, route: &Route, needs: &Needs) {
        if self.arguments.alternatives > 0 && route.alternatives.is_empty() {
            say!("\nno other route differs from this one and is less than twice as long");
        }
        for (number, other) in (1..).zip(&route.alternatives) {
            let longer_m = other.length_m - route.length_m;
            let than = if longer_m < 0.0 { "shorter" } else { "longer" };
            say!("\nalternative {number}, {:.0} m {than}:", longer_m.abs());
            self.print(other, needs);
        }
    }

    fn print(&self, route: &Route, needs: &Needs) {
        for (end, Moved { to, distance_m, .. }) in moved(route) {
            let (lat, lon) = (to.lat_deg(), to.lon_deg());
            complain!(
                "{end} lies too near land, shallow water or a danger; moved by {distance_m:.0} m to {lat:.6},{lon:.6}"
            );
        }
        if route.of_part {
            complain!(
                "only part of the water was looked at in full, as the charts hold too much; a shorter route may lead \
                 elsewhere: --via leads it there"
            );
        }
        if let Some(Narrow { leg, least_m, legs, .. }) = route.narrow(self.room_m()) {
            complain!(
                "on {legs} of {} legs danger is nearer than the {:.0} m that leave room for a vessel off its track (--stray, hull and \
                 position); the nearest is {least_m:.0} m from leg {}: ask for more --clearance, or --prefer-off",
                route.legs.len(),
                self.room_m(),
                leg + 1
            );
        }
        let costs = route.reckon(&self.objective);
        for (number, leg) in (1..).zip(&route.legs) {
            let depth =
                leg.worst.water.least_m().map_or_else(String::new, |depth| format!("{depth:.1} m deep"));
            let clear = leg
                .clearance_m
                .map_or_else(|| "more than 5000 m".to_owned(), |clear| format!("{clear:.0} m"));
            let (lat, lon) = (leg.to.lat_deg(), leg.to.lon_deg());
            say!("{number:>4}  {lat:.6},{lon:.6}  {:>9.1} m  {depth}, clear by {clear}", leg.length_m);
            if let Some(traffic) = costs[number - 1].traffic {
                complain!("{number:>4}  this leg leads through {}", traffic_words(traffic));
            }
            if let Some(warning) = turn_warning(leg) {
                complain!("{number:>4}  the turn at the end of this leg: {warning}");
            }
        }
        let depth = route.least_depth_m().map_or_else(|| "-".to_owned(), |depth_m| format!("{depth_m:.1} m"));
        let clear = route.least_clearance_m();
        let clear = clear.map_or_else(|| "more than 5000 m".to_owned(), |clear_m| format!("{clear_m:.0} m"));
        let speed_mps = route.speed_mps(&self.objective);
        let unknown_m: f64 = costs.iter().map(|cost| cost.unknown_m).sum();
        let takes = match sum(&costs) {
            (Some(duration_s), Some(energy_wh)) => {
                format!("{:.0} min and {energy_wh:.0} Wh (estimate)", duration_s / 60.0)
            }
            (Some(duration_s), None) => format!("{:.0} min", duration_s / 60.0),
            _ => {
                let strong =
                    costs.iter().any(|cost| cost.too_strong).then(|| "the current is too strong".to_owned());
                let unknown =
                    (unknown_m > 0.0).then(|| format!("the current is not known on {unknown_m:.0} m"));
                strong.into_iter().chain(unknown).collect::<Vec<_>>().join(", ")
            }
        };
        say!(
            "{:.1} m in {}, {takes} at {speed_mps:.2} m/s; least depth {depth}, clear by {clear} (asked: {:.1} m, {:.0} m)",
            route.length_m,
            counted(route.legs.len(), "leg"),
            needs.demand.needed_m(),
            needs.clearance_m,
        );
    }
}

/// Time (s) and energy (Wh) of a whole route; nothing where those of a leg are not known.
fn sum(costs: &[LegCost]) -> (Option<f64>, Option<f64>) {
    let energy_j: Option<f64> = costs.iter().map(|cost| cost.energy_j).sum();
    (costs.iter().map(|cost| cost.duration_s).sum(), energy_j.map(|energy_j| energy_j / 3_600.0))
}

/// The ends and places to pass that were moved, in order.
fn moved(route: &Route) -> impl Iterator<Item = (End, Moved)> + '_ {
    let via = route.moved_via.iter().map(|(number, moved)| (End::Via(*number), *moved));
    let start = route.moved_start.map(|moved| (End::Start, moved));
    let goal = route.moved_goal.map(|moved| (End::Goal, moved));
    start.into_iter().chain(via).chain(goal)
}

/// Says on standard error how far the search for a long way has come, every so many tiles.
fn report(Progress { tiles, most_tiles }: Progress) {
    if tiles.is_multiple_of(TILES_BETWEEN_REPORTS) {
        complain!("searched {tiles} tiles of the chart, of {most_tiles} at most");
    }
}

/// What ordered traffic a leg meets.
fn traffic_words(InTraffic { kind, against }: InTraffic) -> String {
    format!("{}{}", kind.words(), if against { ", against its direction" } else { "" })
}

/// Why the turn at the end of a leg cannot be sailed as asked.
fn turn_warning(leg: &RouteLeg) -> Option<String> {
    leg.turn?.trouble.map(|trouble| trouble.to_string())
}

/// Adds the conditions under which there would be a route.
fn would_do(value: &mut Value, passable: &Passable) {
    let degrees = |place: LatLon| [place.lat_deg(), place.lon_deg()];
    let Passable { depth_m, shallowest, clearance_m, gap, by_rule_alone, by_zones_alone, .. } = passable;
    if passable.not_looked {
        return;
    }
    value["passable_by_rule_alone"] = json!(by_rule_alone);
    value["passable_by_zones_alone"] = json!(by_zones_alone);
    value["passable_depth_m"] = json!(depth_m);
    value["passable_shallowest_at"] = json!(shallowest.map(degrees));
    value["passable_clearance_m"] = json!(clearance_m);
    value["passable_gap_at"] = json!(gap.map(|gap| degrees(gap.at)));
    value["passable_gap_width_m"] = json!(gap.map(|gap| gap.width_m));
}

fn would_do_text(passable: &Passable) -> String {
    let Passable { depth_m, shallowest, clearance_m, gap, by_rule_alone, by_zones_alone, .. } = passable;
    if passable.not_looked {
        return "; smaller depths and clearances were not looked for: the charts around are too detailed for that".to_owned();
    }
    let at = |place: LatLon| format!("{:.5},{:.5}", place.lat_deg(), place.lon_deg());
    let mut would_do = Vec::new();
    if let Some(depth_m) = depth_m {
        let place = shallowest.map_or_else(String::new, |place| format!(", shallowest at {}", at(place)));
        would_do.push(format!("; there is one with --min-depth {depth_m}{place}"));
    }
    if let Some(clearance_m) = clearance_m {
        let gap = gap.map(|gap| format!(", through a gap of {:.0} m at {}", gap.width_m, at(gap.at)));
        would_do.push(format!("; there is one with --clearance {clearance_m}{}", gap.unwrap_or_default()));
    }
    if *by_rule_alone {
        would_do.push("; there is one through areas where entry is prohibited or restricted".to_owned());
    }
    if *by_zones_alone {
        would_do.push("; there is one without the areas to avoid or to stay within".to_owned());
    }
    would_do.concat()
}

fn refused(id: &Value, refusal: &Refusal) -> Value {
    let mut value = json!({"id": id, "ok": false, "reason": refusal.to_string()});
    match refusal {
        Refusal::Closed { end, nearest_m, .. } => {
            value["code"] = json!(match end {
                End::Start => "closed_start",
                End::Via(_) => "closed_via",
                End::Goal => "closed_goal",
            });
            value["nearest_open_m"] = json!(nearest_m);
        }
        Refusal::NoWay { nearest, gap_m, looked_km } => {
            value["code"] = json!("no_way");
            value["looked_m"] = json!(looked_km.map(|km| km * 1e3));
            value["nearest"] = json!([nearest.lat_deg(), nearest.lon_deg()]);
            value["gap_m"] = json!(gap_m);
        }
        Refusal::Unknown { looked_km, nearest, gap_m } => {
            value["code"] = json!("not_found");
            value["nearest"] = json!([nearest.lat_deg(), nearest.lon_deg()]);
            value["gap_m"] = json!(gap_m);
            value["looked_m"] = json!(looked_km * 1e3);
        }
        Refusal::GaveUp { tiles, looked_km, .. } => {
            value["code"] = json!("gave_up");
            value["tiles"] = json!(tiles);
            value["looked_m"] = json!(looked_km * 1e3);
        }
        Refusal::TooFar { by, .. } => {
            value["code"] = json!("too_far");
            let place = |place: &LatLon| json!([place.lat_deg(), place.lon_deg()]);
            value["by"] = by.iter().map(place).collect();
        }
        Refusal::TooLong { .. } => value["code"] = json!("too_far"),
        Refusal::NotConfirmed { .. } => value["code"] = json!("not_confirmed"),
        Refusal::Needs(_) => value["code"] = json!("malformed"),
        Refusal::Plan(_) => value["code"] = json!("failed"),
    }
    value
}

/// Writes a route as a plan, at a speed (m/s); legs that enter areas with slower speed limits are maneuvers of their own.
/// Whether there are any.
fn write(
    out: &Path,
    format: Format,
    route: &Route,
    (speed_mps, costs): (f64, &[LegCost]),
) -> anyhow::Result<bool> {
    let place = |place: LatLon| PlanPlace { lat_deg: place.lat_deg(), lon_deg: place.lon_deg() };
    let places: Vec<PlanPlace> = route.places().map(place).collect();
    let of_leg = |cost: &LegCost| cost.limit_mps.unwrap_or(speed_mps);
    let mut maneuvers = Vec::new();
    let mut from = 0;
    let is_same = |one: &LegCost, other: &LegCost| of_leg(one).total_cmp(&of_leg(other)).is_eq();
    for same in costs.chunk_by(is_same) {
        let id = if from == 0 { "Route".to_owned() } else { format!("Route {}", maneuvers.len() + 1) };
        let points = places[from..=from + same.len()].to_vec();
        let speed = PlanSpeed { value: of_leg(&same[0]), unit: SpeedUnit::Mps };
        maneuvers.push(PlanStep { id, speed, task: PlanTask::FollowPath { points } });
        from += same.len();
    }
    let plan = PlanDocument { name: "Route".to_owned(), maneuvers, ..PlanDocument::default() };
    let text = plans::write(&plan, format).map_err(|text| anyhow!("{}: {text}", out.display()))?;
    fs::write(out, text).with_context(|| out.display().to_string())?;
    Ok(costs.iter().any(|cost| cost.limit_mps.is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::depth_index::IndexBuilder;
    use charts::s57::{Cell, NamedBytes};
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: RouteArguments,
    }

    #[test]
    fn what_would_do_is_looked_for_no_longer_than_the_search_may_take() {
        let mut builder = IndexBuilder::new();
        for file in charts::demo::archipelago().unwrap() {
            let named = NamedBytes { name: file.name, bytes: &file.bytes };
            builder.add_cell(&Cell::read(named, &[]).unwrap()).unwrap();
        }
        let router = Router::new(Arc::new(builder.build().unwrap()));
        let line = [
            "route",
            "--from",
            "63.4455,10.352",
            "--to",
            "63.4455,10.314",
            "--min-depth",
            "5",
            "--clearance",
            "190",
        ];
        let Line { arguments } = Line::parse_from(line.into_iter().chain(["--give-up-after", "5"]));
        let objective = arguments.objective.read(arguments.speed).unwrap();
        let terms =
            Terms { arguments: &arguments, limits: GuardLimits::default(), objective, router, traffic: None };
        let (needs, ends) =
            (terms.needs(None, None), terms.request(arguments.from.unwrap(), arguments.to.unwrap()));
        let refusal = terms.router.route(&ends, &needs, &Cancel::never()).unwrap_err();
        let text = |spent_s: u64| {
            let spent = || Duration::from_secs(spent_s);
            terms.refuse(&ends, &needs, &refusal, &terms.cancel(&spent)).unwrap_err().to_string()
        };
        let (in_time, late) = (text(5), text(6));
        assert!(in_time.contains("; there is one with --clearance "), "{in_time}");
        assert!(late.ends_with(NOT_LOOKED_TO_THE_END), "{late}");
    }
}
