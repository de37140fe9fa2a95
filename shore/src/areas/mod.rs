//! No-go areas: areas that people close to all vessels, such as fish farms, nets and uncharted rocks.
//!
//! Nothing is deleted: an area is changed, lifted and closed again, and its earlier state is kept. `rows` has the queries
//! to app.db; `service` has the access rules, and puts the closed ones into the [sea chart](crate::charts), so that plans,
//! routes and the vessels themselves keep out of them.

mod rows;
mod service;
#[cfg(test)]
mod tests;

pub use service::NoGoAreas;
