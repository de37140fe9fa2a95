//! Tests of `server` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod attack;
mod backup;
mod chart;
mod chart_sync;
mod clients;
mod clock;
mod commands;
mod demo;
mod detection_import;
mod disk_full;
mod figures;
mod fleet;
mod fleet_vpn;
mod gaps;
mod grafana;
mod hardware;
mod imc_node;
mod imcproxy;
mod influx;
mod journal;
mod kills;
mod manual;
mod mqtt;
mod process;
mod proxy;
mod prune;
mod recordings;
mod recovery;
mod season;
mod stop;
mod support;
mod teleop;
mod tls;
mod two_links;
mod upgrade;
mod vessel;
mod vpn;
mod ways;
