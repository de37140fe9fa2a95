//! The Inter-Module Communication protocol.
