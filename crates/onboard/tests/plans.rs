//! Plans from a console to their end, in simulation.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod common;

use common::*;
use imc::messages::*;

#[test]
fn sails_a_stored_plan_to_its_end_with_the_exchange_consoles_know() {
    let mut sea = Sea::new().ready();
    sea.upload(&triangle());
    sea.forget();
    let request = sea.ask(PlanControlOp::Start, "triangle", None);
    for (_, packet) in &sea.said { println!("{:?}", packet.message()); }
    let done = sea.run_until(300.0, |sea| sea.replies(request).len() == 3);
    assert!(done, "{:?}", sea.plan_state());
}
