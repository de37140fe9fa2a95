//! The bare hull under constant propeller speeds, for checking the model.

use crate::simulate::{SimulateArguments, pair};
use anyhow::{Context as _, bail};
use devices::Pair;
use sim::{Load, Otter, OtterState, STEP_S};
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Writes the states once a second, from rest.
pub(crate) fn run(arguments: &SimulateArguments) -> anyhow::Result<()> {
    let until_s = arguments.until_s()?.context("--open-loop needs --until SECONDS")?;
    let (port, starboard) =
        pair(arguments.open_loop.as_deref().unwrap_or_default()).context("--open-loop")?;
    let command = Pair::new(port, starboard);
    let otter = Otter::new(arguments.payload.unwrap_or(25.0))?;
    let mut load = Load::default();
    if let Some((speed_mps, to_deg)) = arguments.current {
        let to_rad = to_deg.to_radians();
        load.current_north_mps = speed_mps * to_rad.cos();
        load.current_east_mps = speed_mps * to_rad.sin();
    }
    let mut state = OtterState { psi_rad: arguments.heading.to_radians(), ..OtterState::default() };
    if !(port.is_finite() && starboard.is_finite() && state.psi_rad.is_finite()) {
        bail!("speeds and heading are numbers");
    }
    let mut out: Box<dyn Write> = if arguments.csv.as_os_str() == "-" {
        Box::new(io::stdout().lock())
    } else {
        let path = &arguments.csv;
        Box::new(BufWriter::new(File::create(path).with_context(|| format!("making {}", path.display()))?))
    };
    writeln!(out, "t_s,u,v,r_rad_s,north_m,east_m,psi_rad,n_port,n_stbd")?;
    // Whole steps of the model, of which a second has fifty.
    let steps_per_s = (1.0 / STEP_S).round() as u64;
    for second in 0..=until_s as u64 {
        if second > 0 {
            for _ in 0..steps_per_s {
                state = otter.step(&state, command, &load, STEP_S);
            }
        }
        let OtterState { position, psi_rad, u_mps, v_mps, r_radps, shaft_radps } = state;
        writeln!(
            out,
            "{second},{u_mps},{v_mps},{r_radps},{},{},{psi_rad},{},{}",
            position.north_m, position.east_m, shaft_radps.port, shaft_radps.starboard
        )?;
    }
    out.flush()?;
    Ok(())
}
