//! The model of the Otter against the published response table and trajectories (data/README.md).

use devices::Pair;
use sim::{Load, Otter, OtterState, STEP_S};
use std::collections::BTreeMap;

/// Worst relative deviation allowed, and the absolute floor below which values count as equal.
const RELATIVE: f64 = 0.01;
const FLOOR: f64 = 1e-3;

type Row = BTreeMap<String, String>;

fn rows(name: &str) -> Option<Vec<Row>> {
    let text = std::fs::read_to_string(testkit::shared(name)?).unwrap();
    let mut lines = text.lines();
    let header: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    Some(lines.map(|line| header.iter().cloned().zip(line.split(',').map(str::to_owned)).collect()).collect())
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn current(speed_mps: f64, to_deg: f64) -> Load {
    let to_rad = to_deg.to_radians();
    Load {
        current_north_mps: speed_mps * to_rad.cos(),
        current_east_mps: speed_mps * to_rad.sin(),
        ..Load::default()
    }
}

/// The states of one case of the response table on a grid of 20 ms.
fn run(row: &Row) -> Vec<OtterState> {
    let payload_kg = if row["case"].starts_with("mp0") { 0.0 } else { 25.0 };
    let otter = Otter::new(payload_kg).unwrap();
    let load = current(number(row, "current_speed"), number(row, "current_dir_deg"));
    let command = Pair::new(number(row, "n_port"), number(row, "n_stbd"));
    let mut states =
        vec![OtterState { psi_rad: number(row, "psi0_deg").to_radians(), ..OtterState::default() }];
    for _ in 0..(number(row, "t_end") / STEP_S).round() as usize {
        states.push(otter.step(&states[states.len() - 1], command, &load, STEP_S));
    }
    states
}

/// First time at which `value` has made `fraction` of its way to its last value, on the grid.
fn rise_s(states: &[OtterState], fraction: f64, value: impl Fn(&OtterState) -> f64) -> f64 {
    let goal = value(&states[states.len() - 1]);
    let at = states.iter().position(|s| value(s) * goal.signum() >= fraction * goal.abs()).unwrap();
    at as f64 * STEP_S
}

#[test]
fn every_case_of_the_response_table_is_met_within_one_percent() {
    let Some(rows) = rows("data/otter_reference_response.csv") else { return };
    assert!(rows.len() > 20);
    let mut worst = 0.0_f64;
    for row in &rows {
        let states = run(row);
        let at = |t_s: f64| states[(t_s / STEP_S).round() as usize];
        let end = states[states.len() - 1];
        let mut values = vec![
            ("u_end", end.u_mps),
            ("v_end", end.v_mps),
            ("r_end_deg_s", end.r_radps.to_degrees()),
            ("u_t1", at(1.0).u_mps),
            ("u_t2", at(2.0).u_mps),
            ("u_t5", at(5.0).u_mps),
            ("r_t1_deg_s", at(1.0).r_radps.to_degrees()),
            ("north_t30", at(30.0).position.north_m),
            ("east_t30", at(30.0).position.east_m),
            ("psi_t30_deg", (at(30.0).psi_rad - states[0].psi_rad).to_degrees()),
        ];
        if row["psi0_deg"] != "0" {
            values.pop();
        }
        if row["t63_u"] != "nan" {
            values.push(("t63_u", rise_s(&states, 0.632, |s| s.u_mps)));
            values.push(("t90_u", rise_s(&states, 0.9, |s| s.u_mps)));
        }
        if row["t63_r"] != "nan" {
            values.push(("t63_r", rise_s(&states, 0.632, |s| s.r_radps)));
        }
        if row["turn_radius"] != "nan" {
            values.push(("turn_radius", end.u_mps.hypot(end.v_mps) / end.r_radps.abs()));
        }
        for (column, value) in values {
            let expected = number(row, column);
            let miss = (value - expected).abs();
            println!("{} {column} {value} {expected}", row["case"]);
            if miss > FLOOR {
                worst = worst.max(miss / expected.abs());
            }
            // Rise times are given on a grid of 20 ms: one step either way is the table's own rounding.
            let grid_s = if column.starts_with('t') && column != "turn_radius" { STEP_S * 1.01 } else { 0.0 };
            assert!(
                miss <= (RELATIVE * expected.abs()).max(FLOOR).max(grid_s),
                "{} {column}: {value} instead of {expected}",
                row["case"]
            );
        }
    }
    println!("worst relative deviation above the floor: {worst:.2e}");
}

#[test]
fn every_trajectory_is_met_within_a_decimetre() {
    let Some(rows) = rows("data/onboard/otter_trajectories.csv") else { return };
    let otter = Otter::new(25.0).unwrap();
    let mut worst_m = 0.0_f64;
    let mut state = OtterState::default();
    for (i, row) in rows.iter().enumerate() {
        if number(row, "t") == 0.0 {
            state = OtterState { psi_rad: number(row, "psi"), ..OtterState::default() };
        }
        let miss_m = (state.position.north_m - number(row, "north"))
            .hypot(state.position.east_m - number(row, "east"));
        worst_m = worst_m.max(miss_m);
        assert!(miss_m < 0.1, "{} at {} s: off by {miss_m} m", row["case"], row["t"]);
        assert!((state.psi_rad - number(row, "psi")).abs() < 0.01, "{} at {} s", row["case"], row["t"]);
        if rows.get(i + 1).is_some_and(|next| next["case"] == row["case"]) {
            // The one case with a current does not state it; 0.4 m/s towards 60° is what its mean drift over
            // a full turn gives.
            let load = if row["case"] == "circle_current" { current(0.4, 60.0) } else { Load::default() };
            let command = Pair::new(number(row, "n_port_cmd"), number(row, "n_stbd_cmd"));
            for _ in 0..50 {
                state = otter.step(&state, command, &load, STEP_S);
            }
        }
    }
    println!("worst distance from the trajectories: {worst_m:.1e} m");
}
