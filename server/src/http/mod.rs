//! The interface for programs: the API, the live stream, health and metrics. [`routes`] lists it.

#[cfg(test)]
mod account_shares_tests;
pub(crate) mod alarms;
#[cfg(test)]
mod alarms_tests;
mod areas;
#[cfg(test)]
mod areas_tests;
#[cfg(test)]
mod ashore_aboard_tests;
#[cfg(test)]
mod browser_tests;
mod charts;
#[cfg(test)]
mod charts_tests;
#[cfg(test)]
mod commands_tests;
mod control;
#[cfg(test)]
mod control_tests;
#[cfg(test)]
mod cors_tests;
mod datasets;
#[cfg(test)]
mod datasets_tests;
mod download;
mod explore;
mod export;
#[cfg(test)]
mod export_tests;
#[cfg(test)]
mod grounding_tests;
pub(crate) mod health;
mod history;
#[cfg(test)]
mod history_tests;
#[cfg(test)]
mod hostile_tests;
#[cfg(test)]
mod import_tests;
mod imports;
#[cfg(test)]
mod known_tests;
mod live;
#[cfg(test)]
mod live_tests;
mod logbook;
#[cfg(test)]
mod logbook_tests;
mod missions;
#[cfg(test)]
mod missions_tests;
mod openapi;
mod people;
mod plans;
#[cfg(test)]
mod plans_tests;
#[cfg(test)]
mod refusals_tests;
mod register;
#[cfg(test)]
mod register_tests;
#[cfg(test)]
mod reports_tests;
pub(crate) mod routes;
mod shares;
#[cfg(test)]
mod shares_tests;
#[cfg(test)]
mod stop_tests;
mod table;
#[cfg(test)]
mod table_tests;
mod teleop;
#[cfg(test)]
mod teleop_tests;
#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;
mod transports;
#[cfg(test)]
mod transports_tests;

pub(crate) use plans::seen_plan;
