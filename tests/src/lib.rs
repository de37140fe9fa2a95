//! Tests that look at the whole of Lutra.
