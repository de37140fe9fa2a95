//! No-go areas: what people close to all vessels, such as fish farms, nets and rocks that no chart has.
//!
//! Nothing is deleted: an area is changed, lifted and closed again, and its earlier state is kept. `rows` asks app.db; `service`
//! decides who may what, and has the [sea chart](crate::charts) hold the closed ones, so that plans, routes and the vessels
//! themselves keep out of them.

mod rows;
mod service;
#[cfg(test)]
mod tests;

pub use service::NoGoAreas;
