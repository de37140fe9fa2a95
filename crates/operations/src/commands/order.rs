//! The orders to a vessel, and their IMC messages.

use api::{Said, say};
use imc::Address;
use imc::messages::{
    Abort, EntityParameter, Goto, Message, PlanControl, PlanControlOp, PlanControlType, PlanDB, PlanDBOp,
    PlanDBType, PlanManeuver, PlanSpecification, PlanTransition, QueryEntityParameters, SaveEntityParameters,
    SetEntityParameters, SpeedUnits, StationKeeping, Teleoperation, TeleoperationDone, ZUnits,
};
use units::LatLon;

/// Name of the plan that an order to go somewhere makes; it replaces the previous one.
pub const GOTO_PLAN: &str = "lutra-goto";
/// Name of the plan in which a vessel is steered by hand, as Neptus calls it.
pub const TELEOPERATION_PLAN: &str = "teleoperation-mode";
/// Radius within which a vessel stays where it was ordered to go (m).
const STAY_RADIUS_M: f32 = 15.0;
/// Longest name of a plan or an entity (bytes), as vessels take it.
const LONGEST_NAME: usize = 60;
/// Speeds that can be ordered (m/s): DUNE accepts any, also negative ones.
const SPEEDS_MPS: std::ops::RangeInclusive<f32> = 0.1..=5.0;
/// Most parameters set at once, and the longest value (bytes).
const PARAMETERS: usize = 100;
const LONGEST_VALUE: usize = 1_000;

/// An order to a vessel.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Stop, whatever the vessel is doing. Any user may give it, without control.
    Stop,
    /// Start a plan that is stored aboard.
    StartPlan {
        /// Its name.
        plan_id: String,
    },
    /// Stop the plan that runs.
    StopPlan,
    /// Go to a place and stay there.
    Goto {
        /// Where to go.
        place: LatLon,
        /// How fast (m/s).
        speed_mps: f32,
    },
    /// Be steered by hand, by the holder of the server's address.
    Teleoperate {
        /// The server's own address.
        by: Address,
    },
    /// Be steered by hand no more.
    EndTeleoperation {
        /// Why, for the audit log and the list of commands.
        why: String,
    },
    /// Store a plan aboard.
    Upload(Box<PlanSpecification>),
    /// Remove a plan.
    Delete {
        /// Its name.
        plan_id: String,
    },
    /// Report which plans are stored aboard.
    List,
    /// Give a plan.
    Get {
        /// Its name.
        plan_id: String,
    },
    /// Report the parameters of an entity.
    QueryParameters {
        /// The entity's label.
        entity: String,
    },
    /// Change parameters of an entity.
    SetParameters {
        /// The entity's label.
        entity: String,
        /// Names and values.
        values: Vec<(String, String)>,
    },
    /// Keep the parameters of an entity over restarts.
    SaveParameters {
        /// The entity's label.
        entity: String,
    },
}

/// The evidence that an order took effect.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Effect {
    /// The vessel executes this plan.
    Runs(String),
    /// The vessel executes no plan.
    Rests,
    /// The vessel says that it aborted, or executes no plan.
    Aborts,
    /// The vessel stores this plan with this digest.
    Stores(String, [u8; 16]),
    /// It says that the plan is gone.
    Removed(String),
    /// It gives the state of its database.
    Listed,
    /// It gives this plan.
    Gave(String),
    /// It reports an entity's parameters, these among them.
    Reports(String, Vec<(String, String)>),
    /// Nothing: the vessel does not say.
    Silent,
}

impl Order {
    /// The plan that the order contains, for checks of where it leads.
    pub fn plan(&self) -> Option<PlanSpecification> {
        match self {
            Self::Upload(plan) => Some(plan.as_ref().clone()),
            Self::Goto { place, speed_mps } => Some(goto(*place, *speed_mps)),
            _ => None,
        }
    }

    /// A stable word for people and machines.
    pub fn verb(&self) -> &'static str {
        match self {
            Self::Stop => "vessel.abort",
            Self::StartPlan { .. } => "plan.start",
            Self::StopPlan => "plan.stop",
            Self::Goto { .. } => "goto",
            Self::Teleoperate { .. } => "teleop.begin",
            Self::EndTeleoperation { .. } => "teleop.end",
            Self::Upload(_) => "plan.upload",
            Self::Delete { .. } => "plan.delete",
            Self::List => "plan.list",
            Self::Get { .. } => "plan.get",
            Self::QueryParameters { .. } => "parameters.query",
            Self::SetParameters { .. } => "parameters.set",
            Self::SaveParameters { .. } => "parameters.save",
        }
    }

    /// Its subject, in words.
    pub fn subject(&self) -> String {
        match self {
            Self::StartPlan { plan_id } | Self::Delete { plan_id } | Self::Get { plan_id } => plan_id.clone(),
            Self::Upload(plan) => plan.plan_id.to_str_lossy().into_owned(),
            Self::Stop | Self::StopPlan | Self::List | Self::Teleoperate { .. } => String::new(),
            Self::EndTeleoperation { why } => why.clone(),
            Self::Goto { place, speed_mps } => {
                format!("{:.6}, {:.6} at {speed_mps:.1} m/s", place.lat_deg(), place.lon_deg())
            }
            Self::QueryParameters { entity } | Self::SaveParameters { entity } => entity.clone(),
            Self::SetParameters { entity, values } => {
                let set: Vec<String> = values.iter().map(|(name, value)| format!("{name}={value}")).collect();
                format!("{entity}: {}", set.join(", "))
            }
        }
    }

    /// Whether it commands the vessel; else it only asks.
    pub fn commands(&self) -> bool {
        !matches!(self, Self::List | Self::Get { .. } | Self::QueryParameters { .. })
    }

    /// Whether it is the stop that goes ahead of everything.
    pub fn is_stop(&self) -> bool {
        matches!(self, Self::Stop)
    }

    /// Whether it needs the lease.
    pub fn takes_lease(&self) -> bool {
        self.commands() && !self.is_stop()
    }

    /// Checks that it is valid.
    ///
    /// # Errors
    /// What is wrong with it and what to do.
    pub fn check(&self) -> Result<(), Said> {
        match self {
            Self::StartPlan { plan_id } | Self::Delete { plan_id } | Self::Get { plan_id } => {
                name("plan_id", plan_id)
            }
            Self::Upload(plan) => {
                let plan_id = plan.plan_id.as_str().ok_or_else(|| say("the plan's name is not a text"))?;
                name("plan_id", plan_id)?;
                imc::plan_digest::plan_md5(plan)
                    .map(drop)
                    .map_err(|error| say("the plan: {error}").with("error", error).into())
            }
            Self::Stop
            | Self::StopPlan
            | Self::List
            | Self::Teleoperate { .. }
            | Self::EndTeleoperation { .. } => Ok(()),
            Self::Goto { speed_mps, .. } if SPEEDS_MPS.contains(speed_mps) => Ok(()),
            Self::Goto { speed_mps, .. } => {
                let (least, most) = SPEEDS_MPS.into_inner();
                Err(say("speed_mps: {speed_mps} is not within {least} to {most} m/s")
                    .with("speed_mps", speed_mps)
                    .with("least", least)
                    .with("most", most)
                    .into())
            }
            Self::QueryParameters { entity } | Self::SaveParameters { entity } => name("entity", entity),
            Self::SetParameters { entity, values } => {
                name("entity", entity)?;
                if values.is_empty() || values.len() > PARAMETERS {
                    return Err(say("values: give 1 to {most} parameters").with("most", PARAMETERS).into());
                }
                for (parameter, value) in values {
                    name("the name of a parameter", parameter)?;
                    if value.len() > LONGEST_VALUE {
                        let text = say("{parameter}: the value is longer than {most} bytes");
                        return Err(text.with("parameter", parameter).with("most", LONGEST_VALUE).into());
                    }
                }
                Ok(())
            }
        }
    }

    /// The message that says it.
    pub(super) fn message(&self, request_id: u16) -> Message {
        let control = |op, plan_id: &str, arg: Option<Message>| {
            let (r#type, plan_id, arg) = (PlanControlType::Request, plan_id.into(), arg.into());
            PlanControl { r#type, op, request_id, plan_id, arg, ..PlanControl::default() }.into()
        };
        let database = |op, plan_id: &str, arg: Option<Message>| {
            let (r#type, plan_id, arg) = (PlanDBType::Request, plan_id.into(), arg.into());
            PlanDB { r#type, op, request_id, plan_id, arg, ..PlanDB::default() }.into()
        };
        match self {
            Self::Stop => Abort.into(),
            Self::StartPlan { plan_id } => control(PlanControlOp::Start, plan_id, None),
            Self::StopPlan => control(PlanControlOp::Stop, "", None),
            Self::Goto { place, speed_mps } => {
                control(PlanControlOp::Start, GOTO_PLAN, Some(goto(*place, *speed_mps).into()))
            }
            Self::Teleoperate { by } => {
                // Decimal, as DUNE reads it: keys of other systems are ignored.
                let maneuver = Teleoperation { custom: format!("src={}", by.0).as_str().into() };
                control(PlanControlOp::Start, TELEOPERATION_PLAN, Some(maneuver.into()))
            }
            Self::EndTeleoperation { .. } => TeleoperationDone.into(),
            Self::Upload(plan) => {
                database(PlanDBOp::Set, &plan.plan_id.to_str_lossy(), Some((**plan).clone().into()))
            }
            Self::Delete { plan_id } => database(PlanDBOp::Del, plan_id, None),
            Self::List => database(PlanDBOp::GetState, "", None),
            Self::Get { plan_id } => database(PlanDBOp::Get, plan_id, None),
            Self::QueryParameters { entity } => QueryEntityParameters {
                name: entity.as_str().into(),
                visibility: "developer".into(),
                scope: "global".into(),
            }
            .into(),
            Self::SetParameters { entity, values } => {
                let one = |(name, value): &(String, String)| EntityParameter {
                    name: name.as_str().into(),
                    value: value.as_str().into(),
                };
                let params = values.iter().map(one).collect();
                SetEntityParameters { name: entity.as_str().into(), params }.into()
            }
            Self::SaveParameters { entity } => SaveEntityParameters { name: entity.as_str().into() }.into(),
        }
    }

    pub(super) fn effect(&self) -> Effect {
        match self {
            Self::StartPlan { plan_id } => Effect::Runs(plan_id.clone()),
            Self::Goto { .. } => Effect::Runs(GOTO_PLAN.to_owned()),
            Self::Teleoperate { .. } => Effect::Runs(TELEOPERATION_PLAN.to_owned()),
            Self::Stop => Effect::Aborts,
            Self::StopPlan | Self::EndTeleoperation { .. } => Effect::Rests,
            Self::Upload(plan) => {
                // An order that does not fit a packet has been refused.
                let digest = imc::plan_digest::plan_md5(plan).unwrap_or_default();
                Effect::Stores(plan.plan_id.to_str_lossy().into_owned(), digest)
            }
            Self::Delete { plan_id } => Effect::Removed(plan_id.clone()),
            Self::List => Effect::Listed,
            Self::Get { plan_id } => Effect::Gave(plan_id.clone()),
            Self::QueryParameters { entity } => Effect::Reports(entity.clone(), Vec::new()),
            Self::SetParameters { entity, values } => Effect::Reports(entity.clone(), values.clone()),
            Self::SaveParameters { .. } => Effect::Silent,
        }
    }
}

/// Going straight to a place, then staying there until the next order.
fn goto(place: LatLon, speed_mps: f32) -> PlanSpecification {
    let (lat, lon) = (place.lat_rad(), place.lon_rad());
    let there = Goto {
        lat,
        lon,
        z_units: ZUnits::Depth,
        speed: speed_mps,
        speed_units: SpeedUnits::MetersPs,
        ..Goto::default()
    };
    let stay = StationKeeping {
        lat,
        lon,
        z_units: ZUnits::Depth,
        radius: STAY_RADIUS_M,
        speed: speed_mps,
        speed_units: SpeedUnits::MetersPs,
        ..StationKeeping::default()
    };
    let step = |id: &str, data: Message| PlanManeuver {
        maneuver_id: id.into(),
        data: data.into(),
        ..PlanManeuver::default()
    };
    let then = PlanTransition {
        source_man: "go".into(),
        dest_man: "stay".into(),
        conditions: "ManeuverIsDone".into(),
        ..PlanTransition::default()
    };
    PlanSpecification {
        plan_id: GOTO_PLAN.into(),
        start_man_id: "go".into(),
        maneuvers: [step("go", there.into()), step("stay", stay.into())].into_iter().collect(),
        transitions: [then].into_iter().collect(),
        ..PlanSpecification::default()
    }
}

fn name(what: &str, given: &str) -> Result<(), Said> {
    if given.is_empty() || given.len() > LONGEST_NAME {
        return Err(say("{what}: give 1 to {most} bytes")
            .with("what", what)
            .with("most", LONGEST_NAME)
            .into());
    }
    if given.chars().any(char::is_control) {
        return Err(say("{what}: a name cannot have control characters").with("what", what).into());
    }
    Ok(())
}
