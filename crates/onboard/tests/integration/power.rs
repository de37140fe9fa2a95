//! Power rails and channels on the bus.

use crate::common::*;
use devices::{PowerChannelReading, RailReading, Reading};
use imc::Packet;
use imc::messages::*;
use onboard::{Entity, Output};

/// The part's reports since the last reset.
fn said(sea: &Sea, entity: Entity) -> Vec<&Packet> {
    let own = sea.said.iter().map(|(_, packet)| packet);
    own.filter(|packet| packet.header.src == OTTER && packet.header.src_ent == entity.number()).collect()
}

fn rail(number: u8, voltage_v: f64) -> Reading {
    let reading = RailReading { number, voltage_v, current_a: -0.003, fuse_a: 17.5, flags: 0 };
    Reading::Rail(reading)
}

#[test]
fn a_rail_reports_voltage_and_current_and_what_is_no_number_is_left_out() {
    let mut sea = Sea::new().ready();
    sea.forget();
    sea.read(rail(2, 27.5));
    for nonsense in [rail(2, f64::NAN), rail(200, 12.0)] {
        sea.read(nonsense);
    }
    let of_rail = said(&sea, Entity::Rail2);
    let values: Vec<_> = of_rail.iter().filter_map(|packet| packet.message()).collect();
    let [Message::Voltage(voltage), Message::Current(current)] = values[..] else { panic!("{values:?}") };
    assert_eq!((voltage.value, current.value), (27.5, -0.003));
}

#[test]
fn a_channel_reports_its_name_and_whether_it_is_on() {
    let mut sea = Sea::new().ready();
    sea.forget();
    let state = |on| PowerChannelReading { rail: 3, name: "Modem".to_owned(), on };
    sea.read(Reading::PowerChannel(state(true)));
    sea.read(Reading::PowerChannel(state(false)));
    let reports: Vec<_> = sea.all::<PowerChannelState>().into_iter().map(|(_, report)| report).collect();
    assert_eq!(reports.len(), 2);
    assert_eq!((reports[0].name.clone(), reports[0].state), ("Modem".into(), PowerChannelStateState::On));
    assert_eq!(reports[1].state, PowerChannelStateState::Off);
    assert_eq!(said(&sea, Entity::Rail3).len(), 2);
}

#[test]
fn the_simulated_card_s_rails_are_parts_of_the_vessel_with_their_voltage() {
    let mut sea = Sea::new().ready();
    sea.run(3.0);
    let states = said(&sea, Entity::Rail4);
    let text = states.iter().rev().find_map(|packet| match packet.message() {
        Some(Message::EntityState(state)) => Some(state.description.to_string()),
        _ => None,
    });
    assert_eq!(text.as_deref(), Some("5.0 V"));
}

/// A vessel with one power channel that its console may switch.
fn with_modem() -> Sea {
    let power = vec![onboard::PowerChannel { name: "Modem".to_owned(), rail: 3 }];
    Sea::with(onboard::Settings { power, ..settings() }, |_| {}).ready()
}

fn switch(name: &str, op: PowerChannelControlOp) -> PowerChannelControl {
    PowerChannelControl { name: name.into(), op, ..PowerChannelControl::default() }
}

fn reported(on: bool) -> Reading {
    Reading::PowerChannel(PowerChannelReading { rail: 3, name: "Modem".to_owned(), on })
}

/// Orders to the card since the last time that was forgotten.
fn orders(sea: &Sea) -> Vec<(&str, bool)> {
    let order = |output| match output {
        &Output::Power { ref channel, on } => Some((&channel[..], on)),
        _ => None,
    };
    sea.outputs.iter().filter_map(|(_, output)| order(output)).collect()
}

fn entries(sea: &Sea) -> Vec<String> {
    sea.all::<LogBookEntry>().into_iter().map(|(_, entry)| entry.text.to_string()).collect()
}

#[test]
fn a_console_switches_a_channel_and_what_the_card_reports_is_answered() {
    let mut sea = with_modem();
    sea.forget();
    sea.send(QueryPowerChannelState);
    assert!(sea.all::<PowerChannelState>().is_empty(), "nothing has been reported");
    sea.send(switch("Modem", PowerChannelControlOp::TurnOn));
    assert_eq!(orders(&sea), [("Modem", true)]);
    sea.read(reported(true));
    sea.forget();
    sea.send(QueryPowerChannelState);
    let states = sea.all::<PowerChannelState>();
    assert_eq!(states.len(), 1);
    assert_eq!(states[0].1.state, PowerChannelStateState::On);
    sea.send(switch("Modem", PowerChannelControlOp::Toggle));
    sea.send(switch("Modem", PowerChannelControlOp::Toggle));
    assert_eq!(orders(&sea), [("Modem", false), ("Modem", true)]);
    sea.run(6.0);
    assert!(!entries(&sea).iter().any(|text| text.contains("does not follow")), "it is on as asked last");
}

#[test]
fn a_refused_channel_and_one_that_nobody_named_are_told() {
    let mut sea = with_modem();
    sea.read(reported(false));
    sea.forget();
    sea.send(switch("Modem", PowerChannelControlOp::TurnOn));
    sea.read(reported(false));
    sea.run(4.0);
    assert!(!entries(&sea).iter().any(|text| text.contains("does not follow")));
    sea.run(2.0);
    let told = entries(&sea);
    let words = "`Modem` was to be on and the card does not follow: it is off";
    assert_eq!(told.iter().filter(|text| text.contains(words)).count(), 1, "{told:?}");
    sea.forget();
    sea.send(switch("Sonar", PowerChannelControlOp::TurnOn));
    sea.send(switch("Modem", PowerChannelControlOp::SchedOn));
    assert!(orders(&sea).is_empty());
    let told = entries(&sea);
    assert!(told[0].contains("`Sonar` is not switched: the configuration names Modem"), "{told:?}");
    assert!(told[1].contains("schedules are not kept aboard"), "{told:?}");
}
