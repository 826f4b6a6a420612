//! Campaigns with something hidden in them: an individual actuator on a bench, four runs, sensors with errors.

mod commands;
mod draws;
mod hidden;
mod individual;
pub mod leg;
mod logger;
mod rough;
mod strength;

pub use commands::Planned;
pub use draws::Draws;
pub use hidden::{BEYOND, CATALOGUE, Hidden, PAIRS, TRIPLES};
pub use individual::{Individual, Stamp};
pub use rough::Rough;
pub use strength::reach;

use logger::Logger;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::{Bench, PendulumRig};
use sealegs_model::{Record, Signal};
use std::fmt::Write;

/// Which bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rig {
    /// Both links held.
    Locked,
    /// The screw turns the dissertation's pendulum.
    Pendulum,
}

impl Rig {
    /// The name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Locked => "locked",
            Self::Pendulum => "pendulum",
        }
    }

    /// The bench that it stands for.
    #[must_use]
    pub fn bench(self) -> Bench {
        match self {
            Self::Locked => Bench::Locked,
            Self::Pendulum => Bench::Pendulum(PendulumRig::default()),
        }
    }

    /// Lever arm, m.
    fn arm_m(self) -> f64 {
        PendulumRig::default().arm_m
    }
}

/// Rows per second of a logger that is not slow.
pub const RATE_HZ: f64 = 1000.0;

/// Steps of the integrator per row: 10 us. Halving it changes no signal by a tenth of its noise, whatever is hidden.
pub const SUBSTEPS: usize = 100;

/// Greatest swing of the pendulum, rad: beyond it the bench would be another one.
const MOST_SWING_RAD: f64 = 1.2;

/// What is to be made.
#[derive(Debug, Clone)]
pub struct Order {
    /// The campaign's name.
    pub name: String,
    /// The bench.
    pub rig: Rig,
    /// Seed of the individual, the commands and the noise.
    pub seed: u64,
    /// What is hidden.
    pub hidden: Vec<Hidden>,
    /// Duration of a run, s.
    pub duration_s: f64,
    /// Steps of the integrator per row of a logger of the usual rate.
    pub substeps: usize,
    /// What is rough about the log.
    pub rough: Vec<Rough>,
}

/// A run as it was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeRun {
    /// Held out rather than fitted.
    pub holdout: bool,
    /// Its name is its file's.
    pub record: Record,
}

/// A campaign and the truth about it.
#[derive(Debug, Clone)]
pub struct Made {
    /// Its name.
    pub name: String,
    /// The bench.
    pub rig: Rig,
    /// The preset.
    pub actuator: &'static str,
    /// The stated noise, one standard deviation, by column.
    pub noise_std: Vec<(&'static str, f64)>,
    /// The runs, those to fit on first.
    pub runs: Vec<MadeRun>,
    /// The individual.
    pub individual: Individual,
    /// What is hidden.
    pub hidden: Vec<Hidden>,
    /// What is rough about the log.
    pub rough: Vec<Rough>,
    /// Rows per second.
    pub rate_hz: f64,
}

/// The actuator that campaigns are made of.
const ACTUATOR: &str = "thor-linear";

/// What a thermometer at a drive shows that warms evenly from 25 degrees Celsius.
fn thermometer(time_s: &[f64], warms_k_s: f64) -> Signal {
    let values = time_s.iter().map(|t| 25.0 + warms_k_s * t).collect();
    Signal { channel: "temperature_c".to_owned(), values }
}

impl Order {
    /// Makes it. The same order gives the same bits.
    ///
    /// # Panics
    ///
    /// Only if the preset that comes with the program cannot be read.
    #[must_use]
    pub fn make(&self) -> Made {
        let spec = ActuatorSpec::preset(ACTUATOR).unwrap_or_else(|e| panic!("a preset: {e}"));
        let individual = Individual::drawn(self.seed);
        let plain = individual.on(&spec, self.rig.bench());
        let machine = self.hidden.iter().fold(plain.clone(), |r, h| h.put_into(r));
        let rate_hz = Rough::rate_hz(&self.rough, self.seed);
        let deflection_sensor = self.hidden.iter().any(|h| Hidden::needs_deflection_sensor(&h.id));
        let logger = Logger {
            rig: self.rig,
            spec: &spec,
            individual: &individual,
            deflection_sensor,
            beyond: self.hidden.iter().find_map(|h| h.beyond),
            rough: &self.rough,
            seed: self.seed,
            period_s: 1.0 / rate_hz,
        };
        let planned = commands::plan(self.rig, self.seed, self.duration_s, rate_hz).into_iter();
        let runs = planned.filter(|p| !(self.is(Rough::OneFitRun) && p.file == commands::SECOND_FIT)).map(
            |mut planned| {
                self.keep_upright(&plain, &mut planned.command);
                if self.is(Rough::WeakExcitation) {
                    commands::weaken(&mut planned.command);
                }
                let truth = self.recorded(&machine, &planned.command);
                let mut record = logger.write(planned.file, &planned.command, &truth);
                if machine.warms_k_s != 0.0 {
                    record.inputs.push(thermometer(&record.time_s, machine.warms_k_s));
                }
                MadeRun { holdout: planned.holdout, record }
            },
        );
        Made {
            name: self.name.clone(),
            rig: self.rig,
            actuator: ACTUATOR,
            noise_std: logger::sensors(self.rig, deflection_sensor, &self.rough),
            runs: runs.collect(),
            individual,
            hidden: self.hidden.clone(),
            rough: self.rough.clone(),
            rate_hz,
        }
    }

    fn is(&self, rough: Rough) -> bool {
        self.rough.contains(&rough)
    }

    /// Steps of the integrator in a row, when there are to be so many in one of the usual rate.
    fn steps(&self, usual: usize) -> usize {
        (usual as f64 * RATE_HZ / Rough::rate_hz(&self.rough, self.seed)).round() as usize
    }

    /// The true signals when the sensors are read.
    fn recorded(&self, machine: &crate::Reference, command: &[f64]) -> crate::Outputs {
        let period_s = 1.0 / Rough::rate_hz(&self.rough, self.seed);
        let substeps = self.steps(self.substeps);
        if !self.is(Rough::HalfPeriodLate) {
            return machine.run(period_s, command, substeps);
        }
        // Two rows a period, of which the second is read.
        let twice: Vec<f64> = command.iter().flat_map(|c| [*c, *c]).collect();
        let all = machine.run(0.5 * period_s, &twice, substeps.div_ceil(2));
        let late = |of: &[f64]| of.iter().skip(1).step_by(2).copied().collect();
        crate::Outputs {
            force_1: late(&all.force_1),
            force_2: late(&all.force_2),
            extension: late(&all.extension),
            deflection: late(&all.deflection),
            link_2: late(&all.link_2),
        }
    }

    /// Makes a command smaller until the pendulum, without the hidden effect, stays within its swing.
    fn keep_upright(&self, plain: &crate::Reference, command: &mut [f64]) {
        if self.rig == Rig::Locked {
            return;
        }
        // A first look: coarse steps will do.
        let swing = |command: &[f64]| {
            let x = plain.run(1.0 / Rough::rate_hz(&self.rough, self.seed), command, self.steps(4)).link_2;
            x.iter().fold(0.0f64, |m, x| m.max(x.abs())) / self.rig.arm_m()
        };
        while swing(command) > MOST_SWING_RAD {
            command.iter_mut().for_each(|c| *c *= 0.85);
        }
    }
}

impl Made {
    /// The text of `campaign.toml`.
    #[must_use]
    pub fn description(&self) -> String {
        let mut text = format!(
            "name = \"{}\"\nbench = \"{}\"\nactuator = \"{}\"\nsample_rate_hz = {:.1}\n",
            self.name,
            self.rig.as_str(),
            self.actuator,
            self.rate_hz
        );
        if !self.rough.contains(&Rough::NoStatedNoise) {
            text.push_str("\n[noise_std]\n");
            for (channel, std) in &self.noise_std {
                let _ = writeln!(text, "{channel} = {std:.3e}");
            }
        }
        for run in &self.runs {
            let role = if run.holdout { "holdout" } else { "fit" };
            let _ = write!(text, "\n[[run]]\nfile = \"{}\"\nrole = \"{role}\"\n", run.record.name);
        }
        text
    }

    /// The text of a run's file.
    #[must_use]
    pub fn csv(run: &MadeRun) -> String {
        let record = &run.record;
        let signals: Vec<_> = record.inputs.iter().chain(&record.outputs).collect();
        let mut text = "time_s".to_owned();
        for signal in &signals {
            text.push(',');
            text.push_str(&signal.channel);
        }
        text.push('\n');
        for (n, t) in record.time_s.iter().enumerate() {
            let _ = write!(text, "{t:.4}");
            for signal in &signals {
                let v = signal.values[n];
                // Digits enough that rounding is far below each sensor's error.
                let _ = match signal.channel.as_str() {
                    "current_a" => write!(text, ",{v:.5}"),
                    "spring_deflection_m" => write!(text, ",{v:.8}"),
                    c if c.ends_with("_rad") => write!(text, ",{v:.7}"),
                    _ => write!(text, ",{v:.2}"),
                };
            }
            text.push('\n');
        }
        text
    }

    /// Every file of the campaign's folder: name and text.
    #[must_use]
    pub fn files(&self) -> Vec<(String, String)> {
        let runs = self.runs.iter().map(|run| (run.record.name.clone(), Self::csv(run)));
        std::iter::once(("campaign.toml".to_owned(), self.description())).chain(runs).collect()
    }
}
