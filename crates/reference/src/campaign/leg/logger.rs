//! A leg's sensors: what stands in the file of a run.

use crate::campaign::Draws;
use crate::leg::Instant;
use std::f64::consts::TAU;

/// A kind of sensor: noise (one standard deviation), count, and how far gain and bias of one may be off; digits in the
/// file. Estimates, those of the shipped campaigns of legs.
#[derive(Debug, Clone, Copy)]
struct Kind {
    noise: f64,
    count: f64,
    gain: f64,
    bias: f64,
    digits: usize,
}

const LOAD_CELL: Kind = Kind { noise: 2.0, count: 0.0, gain: 0.01, bias: 3.0, digits: 1 };
const GROUND: Kind = Kind { noise: 10.0, count: 0.0, gain: 0.01, bias: 5.0, digits: 1 };
const CURRENT: Kind = Kind { noise: 0.01, count: 0.0, gain: 0.0, bias: 0.0, digits: 3 };
/// Hall sensors, interpolated.
const ROTOR: Kind = Kind { noise: 0.02, count: TAU / 256.0, gain: 0.0, bias: 0.0, digits: 3 };
const JOINT: Kind = Kind { noise: 1e-4, count: TAU / 16384.0, gain: 0.0, bias: 1e-3, digits: 5 };
const HEIGHT: Kind = Kind { noise: 1e-4, count: 0.0, gain: 0.002, bias: 5e-4, digits: 5 };

/// One sensor of a leg.
#[derive(Debug, Clone)]
pub struct LegSensor {
    /// Its column.
    pub channel: String,
    /// Measured per true.
    pub gain: f64,
    /// In the column's unit.
    pub bias: f64,
    kind: Kind,
}

impl LegSensor {
    /// The sensors of a leg with these joints and actuators, in the order of [`signals`]; a leg that lands has one of
    /// the base's height and one of the ground's force, and load cells that are twice as noisy.
    pub(super) fn all(joints: &[String], actuators: &[String], lands: bool, seed: u64) -> Vec<Self> {
        let load_cell = Kind { noise: LOAD_CELL.noise * if lands { 2.0 } else { 1.0 }, ..LOAD_CELL };
        let of_joints = joints.iter().map(|j| (format!("{j}.angle_rad"), JOINT));
        let of_actuators = actuators.iter().flat_map(|a| {
            [
                ("force_1_n", load_cell),
                ("force_2_n", load_cell),
                ("current_a", CURRENT),
                ("rotor_angle_rad", ROTOR),
            ]
            .map(|(ending, kind)| (format!("{a}.{ending}"), kind))
        });
        let of_landing = [("base.height_m", HEIGHT), ("foot.normal_force_n", GROUND)];
        let of_landing = of_landing.into_iter().filter(|_| lands).map(|(name, kind)| (name.to_owned(), kind));
        let one = |(channel, kind): (String, Kind)| {
            let mut d = Draws::of(seed, &format!("sensor {channel}"));
            let gain = 1.0 + kind.gain * d.between(-1.0, 1.0);
            Self { gain, bias: kind.bias * d.between(-1.0, 1.0), channel, kind }
        };
        of_joints.chain(of_actuators).chain(of_landing).map(one).collect()
    }

    /// Noise, count and last digit together, one standard deviation.
    #[must_use]
    pub fn noise_std(&self) -> f64 {
        let digit = 10f64.powi(-(self.kind.digits as i32));
        let square = self.kind.noise.powi(2) + (self.kind.count.powi(2) + digit.powi(2)) / 12.0;
        square.sqrt()
    }

    /// Whether a bias is to be found.
    #[must_use]
    pub fn may_be_off(&self) -> bool {
        self.kind.bias > 0.0
    }

    /// What it shows of a true signal in a run, as text.
    pub(super) fn column(&self, truth: &[f64], run: &str, seed: u64) -> Vec<String> {
        let mut d = Draws::of(seed, &format!("{run} {}", self.channel));
        let Kind { noise, count, digits, .. } = self.kind;
        let shown = |true_value: &f64| {
            let value = self.gain * true_value + self.bias + noise * d.normal();
            let value = if count > 0.0 { (value / count).round() * count } else { value };
            let text = format!("{value:.digits$}");
            // Minus zero is none.
            if text.trim_start_matches(['-', '0', '.']).is_empty() {
                text.trim_start_matches('-').to_owned()
            } else {
                text
            }
        };
        truth.iter().map(shown).collect()
    }
}

/// The true signals of a run, in the order of the sensors.
pub(super) fn signals(run: &[Instant], lands: bool) -> Vec<Vec<f64>> {
    let Some(first) = run.first() else { return Vec::new() };
    let every = |of: &dyn Fn(&Instant) -> f64| run.iter().map(of).collect::<Vec<f64>>();
    let mut all: Vec<Vec<f64>> = (0..first.q.len()).map(|j| every(&|i| i.q[j])).collect();
    for a in 0..first.force_1.len() {
        all.push(every(&|i| i.force_1[a]));
        all.push(every(&|i| i.force_2[a]));
        all.push(every(&|i| i.current[a]));
        all.push(every(&|i| i.rotor_angle[a]));
    }
    if lands {
        all.push(every(&|i| i.base_height));
        all.push(every(&|i| i.ground));
    }
    all
}
