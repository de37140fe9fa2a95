//! Tests of the plan database.
