//! Files for MuJoCo, as its version 4.0 reads them, with Python beside them for what it has no element for.

pub mod bench;
mod bench_notes;
mod callback;
pub mod driven;
mod driven_callback;
mod driven_notes;
mod law;
pub mod leg;
mod leg_actuator;
mod shape;
mod stages;
mod tendon;

/// The longest step in the files, s: that of the project's own bench.
pub const STEP_S: f64 = 1e-4;

/// Attributes of a dry friction that holds, at a step in s. MuJoCo's constraint is soft: with its impedance at the greatest
/// that is admitted and its time constant at two steps, the shortest that stays stable, it creeps by less than 1e-10 m/s on
/// the bench of THOR's actuator.
fn holding(step_s: f64) -> String {
    let solref = crate::text::nums(&[2.0 * step_s, 1.0]);
    format!("solreffriction=\"{solref}\" solimpfriction=\"0.9999 0.9999 0.001 0.5 2\"")
}

/// Attributes of an actuator for a delay in s at a step in s; nothing for none. MuJoCo reads its buffer of commands between
/// samples by a straight line, which lies half a step before a command that is held: so much is added, and the mean over a
/// step is that of the held command.
fn delayed(delay_s: f64, step_s: f64) -> String {
    if delay_s <= 0.0 {
        return String::new();
    }
    let delay = delay_s + 0.5 * step_s;
    let samples = (delay / step_s).ceil() + 2.0;
    format!(" delay=\"{}\" nsample=\"{samples}\" interp=\"linear\"", crate::text::num(delay))
}

/// The shortest delay that MuJoCo can hold, in steps: it reads its buffer before it writes.
const SHORTEST_DELAY: f64 = 1.5;
