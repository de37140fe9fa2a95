//! Tests of statistics and progress.
