//! Problems and warnings of a plan, by code and figures, so that pages can show them in the reader's language.

use api::{PlanTrouble, Said, Wording, say};
use mission::{PlanProblem, PlanWarning, ProblemKind, SpeedLimits};

/// Code of a problem that has only a text.
const OTHER: &str = "other";

/// A problem of one maneuver, or of the whole plan, that has only a text.
pub(crate) fn trouble(maneuver: Option<&str>, text: impl Into<String>) -> PlanTrouble {
    coded(maneuver, (OTHER, &[], ""), text.into())
}

/// Code, figures by name, and subject.
type Coded<'a> = (&'static str, &'a [(&'static str, f64)], &'a str);

fn coded(maneuver: Option<&str>, (code, values, about): Coded<'_>, text: String) -> PlanTrouble {
    PlanTrouble {
        maneuver: maneuver.map(str::to_owned),
        code: code.to_owned(),
        about: (!about.is_empty()).then(|| about.to_owned()),
        // NaN, and values that mean no limit, are left out.
        values: values
            .iter()
            .filter(|(_, value)| value.abs() < f64::MAX)
            .map(|(name, value)| ((*name).to_owned(), *value))
            .collect(),
        text,
    }
}

/// The rows have more points than the limit.
pub(crate) fn too_many_row_points(most: usize) -> PlanTrouble {
    let text = format!("its rows have more than {most} points together; widen them or divide the plan");
    coded(None, ("too-many-row-points", &[("most", most as f64)], ""), text)
}

/// The plan does not fit into one message.
pub(crate) fn too_long(text: String) -> PlanTrouble {
    coded(None, ("too-long", &[], ""), text)
}

/// Converts a problem; `most` are the speed limits.
pub(crate) fn of_problem(problem: &PlanProblem, most: &SpeedLimits) -> PlanTrouble {
    let maneuver = problem.maneuver.as_deref();
    let text = match &problem.kind {
        ProblemKind::Speed(speed) => format!(
            "a speed of {speed} is not possible; above 0 and up to {} m/s, {} rpm or {} % are",
            most.max_mps, most.max_rpm, most.max_percent
        ),
        ProblemKind::Empty => "the plan has no maneuvers yet".to_owned(),
        kind => kind.to_string(),
    };
    let code = |coded_by: Coded<'_>| coded(maneuver, coded_by, text.clone());
    match &problem.kind {
        ProblemKind::NoPlanId => code(("no-name", &[], "")),
        ProblemKind::Empty => code(("empty", &[], "")),
        ProblemKind::TooManyManeuvers { count, limit } => {
            code(("too-many-maneuvers", &[("count", *count as f64), ("most", *limit as f64)], ""))
        }
        ProblemKind::BadId => code(("bad-name", &[], "")),
        ProblemKind::DuplicateId => code(("name-twice", &[], "")),
        ProblemKind::Unreachable => code(("unreachable", &[], "")),
        ProblemKind::Unsupported(kind) => code(("unsupported", &[], kind)),
        ProblemKind::Depth { depth_m, limit_m } => {
            code(("too-deep", &[("depth_m", *depth_m), ("most_m", *limit_m)], ""))
        }
        ProblemKind::Place(_) => code(("no-place", &[], "")),
        ProblemKind::NullIsland => code(("null-island", &[], "")),
        ProblemKind::OutsideArea(by_m) => code(("outside-area", &[("by_m", *by_m)], "")),
        ProblemKind::Speed(_) => {
            let (mps, rpm, percent) = (most.max_mps, most.max_rpm, most.max_percent);
            code(("speed", &[("mps", mps), ("rpm", rpm), ("percent", percent)], ""))
        }
        ProblemKind::Range { what, value, min, max } => {
            code(("range", &[("value", *value), ("least", *min), ("most", *max)], what))
        }
        ProblemKind::TooManyPoints { count, limit } => {
            code(("too-many-points", &[("count", *count as f64), ("most", *limit as f64)], ""))
        }
        ProblemKind::UnknownStart(_)
        | ProblemKind::TransitionFrom(_)
        | ProblemKind::TransitionTo(_)
        | ProblemKind::NoManeuver
        | ProblemKind::Refused(_)
        | ProblemKind::Timetable { .. } => code((OTHER, &[], "")),
    }
}

/// Converts a warning: something that the author may not have intended.
pub(crate) fn of_warning(warning: &PlanWarning) -> PlanTrouble {
    match warning {
        PlanWarning::Unheeded { maneuver, text } => trouble(maneuver.as_deref(), text.as_str()),
        PlanWarning::CircleInstead(maneuver) => {
            let text = "a circle is sailed in place of the shape".to_owned();
            coded(Some(maneuver), ("circle-instead", &[], ""), text)
        }
        PlanWarning::NoPoints(maneuver) => {
            coded(Some(maneuver), ("no-points", &[], ""), "has no points and is done at once".to_owned())
        }
        PlanWarning::Cycle => coded(None, ("never-ends", &[], ""), warning.to_string()),
        PlanWarning::NeverReached(maneuver) => {
            coded(Some(maneuver), ("never-reached", &[], ""), "never reached".to_owned())
        }
        PlanWarning::TransitionIgnored { from, to } => {
            let text = format!("the transition to '{to}' is ignored, the first one counts");
            coded(Some(from), ("transition-ignored", &[], to), text)
        }
    }
}

/// A problem as a text for people, with the maneuver that has it.
pub fn said(trouble: &PlanTrouble) -> Said {
    let text = worded(trouble).map_or_else(|| Said::as_is(trouble.text.clone()), Said::from);
    match &trouble.maneuver {
        Some(maneuver) => text.of_field(maneuver),
        None => text,
    }
}

/// The words of a code, which are those of `web/src/state/plantrouble.ts`; `None` for one that has only a text.
fn worded(trouble: &PlanTrouble) -> Option<Wording> {
    let figure = |name: &str| trouble.values.get(name).copied().unwrap_or(f64::NAN);
    let whole = |name: &str| format!("{:.0}", figure(name));
    Some(match trouble.code.as_str() {
        "no-name" => say("The plan has no name"),
        "empty" => say("The plan has no maneuvers yet"),
        "too-many-maneuvers" => say("{count} maneuvers; {most} are allowed")
            .with("count", whole("count"))
            .with("most", whole("most")),
        "bad-name" => say("A maneuver needs a name other than _done_"),
        "name-twice" => say("This name is used twice"),
        "unreachable" => say("No transition leads to it"),
        "unsupported" => say("The vessel does not sail maneuvers of the kind {kind}")
            .with("kind", trouble.about.as_deref().unwrap_or_default()),
        "too-deep" => say("A depth of {depth} m is asked for; {most} m is possible")
            .with("depth", format!("{:.1}", figure("depth_m")))
            .with("most", format!("{:.1}", figure("most_m"))),
        "no-place" => say("This is not a place: latitude −90 to 90°, longitude −180 to 180°"),
        "null-island" => say("The position is 0, 0: it was not filled in"),
        "outside-area" => say("It leaves the area of operation by {distance} m").with("distance", whole("by_m")),
        "speed" => {
            say("This speed is not possible. Choose one above 0 and up to {mps} m/s, {rpm} rpm or {percent} %.")
                .with("mps", format!("{:.2}", figure("mps")))
                .with("rpm", whole("rpm"))
                .with("percent", whole("percent"))
        }
        "too-many-points" => {
            say("{count} points; {most} are allowed").with("count", whole("count")).with("most", whole("most"))
        }
        "too-many-row-points" => {
            say("Its rows have more than {most} points together: put more distance between rows, or divide the plan")
                .with("most", whole("most"))
        }
        "too-long" => say("The plan is too long for one message: divide it"),
        "circle-instead" => say("A circle is sailed in place of the shape"),
        "no-points" => say("Has no points and is done at once"),
        "never-ends" => say("The plan never ends by itself"),
        "never-reached" => say("It is never reached"),
        "transition-ignored" => say("The transition to {to} is ignored: the first one counts")
            .with("to", trouble.about.as_deref().unwrap_or_default()),
        _ => return None,
    })
}
