//! A closed-form model for tests: a driven mass, spring and damper, discretised exactly.
//!
//! `m x'' + c x' + k x = u` under a zero-order held force, `x` measured as `spring_deflection_m` and
//! `k x` as `force_1_n`. Its effects are laws of the force's sensor, which add to that channel: `cubic-sensor`, `a (k x)^3`,
//! and where it is asked for [`LAWS`], of which the last one contains two others.

use sealegs_model::{
    EffectCard, Excitation, InputHold, Model, ModelError, Parameter, Prediction, Record, Signal, internal,
};

/// What a sensor adds to a force, by the values of its parameters.
#[derive(Debug)]
pub(crate) struct Law {
    pub id: &'static str,
    /// Its amplitude, where a fit starts.
    amplitude: f64,
    /// Its exponent, where a fit starts, if that is not known.
    exponent: Option<f64>,
    adds: fn(&[f64], f64) -> f64,
}

const CUBIC: Law = Law { id: "cubic-sensor", amplitude: 1e-4, exponent: None, adds: |a, f| a[0] * f.powi(3) };

/// All laws that the toy has.
pub(crate) const LAWS: [Law; 4] = [
    CUBIC,
    Law { id: "square-sensor", amplitude: 1e-3, exponent: None, adds: |a, f| a[0] * f * f.abs() },
    Law { id: "even-sensor", amplitude: 1e-3, exponent: None, adds: |a, f| a[0] * f * f },
    Law {
        id: "power-sensor",
        amplitude: 1e-2,
        exponent: Some(1.5),
        adds: |a, f| a[0] * f.signum() * f.abs().powf(a[1]),
    },
];

impl Law {
    fn parameters(&self) -> Vec<Parameter> {
        let mut amplitude = Parameter::new(format!("{}.a", self.id), "N", self.amplitude, -1.0, 1.0);
        amplitude.neutral = Some(0.0);
        let exponent = self.exponent.map(|p| Parameter::new(format!("{}.p", self.id), "1", p, 0.2, 5.0));
        std::iter::once(amplitude).chain(exponent).collect()
    }

    fn card(&self) -> EffectCard {
        EffectCard {
            id: self.id.into(),
            summary: "a sensor that is not linear".into(),
            acts_on: "sensor".into(),
            equation: "F + a F^p".into(),
            validity: "any".into(),
            reference: "none".into(),
            symbols: "a: its gain".into(),
            told_apart: "alone".into(),
            cure: "another sensor".into(),
            parameters: self.parameters(),
            passive: true,
            becomes: None,
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Toy {
    pub parameters: Vec<Parameter>,
    /// The laws that it offers as effects.
    pub laws: &'static [Law],
    /// Those that it has.
    with: Vec<&'static Law>,
    /// Amplitude and period of a wave along the first law's amplitude, which gives the error many minima.
    pub wave: (f64, f64),
    /// Factor of the mass in a coarser copy, the error of its steps; where it is not 1 there is an observer that does as the model does.
    pub coarser_by: f64,
    /// The same in this copy.
    by: f64,
}

impl Toy {
    pub fn new() -> Self {
        let mut parameters = vec![
            Parameter::new("mass", "kg", 1.0, 0.2, 5.0),
            Parameter::new("damping", "N s/m", 4.0, 0.1, 50.0),
            Parameter::new("stiffness", "N/m", 400.0, 50.0, 2000.0),
        ];
        parameters[1].scale = sealegs_model::Scale::Logarithmic;
        let (laws, with) = (std::slice::from_ref(&CUBIC), Vec::new());
        Self { parameters, laws, with, wave: (0.0, 1.0), coarser_by: 1.0, by: 1.0 }
    }

    /// What its laws add to a force.
    fn added(&self, values: &[f64], force: f64) -> f64 {
        let (mut at, mut added) = (3, 0.0);
        for (i, law) in self.with.iter().enumerate() {
            let mut own = values[at..at + law.parameters().len()].to_vec();
            if i == 0 {
                let (amplitude, period) = self.wave;
                own[0] += amplitude * (std::f64::consts::TAU * own[0] / period).sin();
            }
            added += (law.adds)(&own, force);
            at += own.len();
        }
        added
    }
}

impl Model for Toy {
    fn name(&self) -> String {
        "toy".into()
    }
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }
    fn inputs(&self) -> &[&'static str] {
        &["motor_force_n"]
    }
    fn predicts(&self, channel: &str) -> bool {
        matches!(channel, "spring_deflection_m" | "force_1_n")
    }
    fn included(&self) -> Vec<String> {
        self.with.iter().map(|law| law.id.into()).collect()
    }
    fn effects(&self, _seen: &Excitation) -> Vec<EffectCard> {
        let free = |law: &&Law| self.with.iter().all(|with| with.id != law.id);
        self.laws.iter().filter(free).map(Law::card).collect()
    }
    fn with_effect(&self, id: &str, _seen: &Excitation) -> Result<Box<dyn Model>, ModelError> {
        let law = self.laws.iter().find(|law| law.id == id);
        let law = law.ok_or(ModelError::UnknownEffect { id: id.into(), suggestion: None })?;
        let mut with = self.clone();
        with.parameters.extend(law.parameters());
        with.with.push(law);
        Ok(Box::new(with))
    }
    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let (m, c, k) = (self.by * values[0], values[1], values[2]);
        let force = record.input("motor_force_n").ok_or(ModelError::NoInput {
            record: record.name.clone(),
            wanted: vec!["motor_force_n".into()],
            found: Vec::new(),
        })?;
        let (mut x, mut v) = (0.0, 0.0);
        let (mut position, mut speed) = (Vec::new(), Vec::new());
        let mut step = (0.0, nalgebra::Matrix3::identity());
        for i in 0..record.len() {
            position.push(x);
            speed.push(v);
            let Some(next) = record.time_s.get(i + 1) else { break };
            let dt = next - record.time_s[i];
            // The same for steps that differ by rounding alone.
            if (dt - step.0).abs() > 1e-9 * dt {
                let a = nalgebra::Matrix3::new(0.0, 1.0, 0.0, -k / m, -c / m, 1.0 / m, 0.0, 0.0, 0.0);
                step = (dt, (a * dt).exp());
            }
            let s = step.1 * nalgebra::Vector3::new(x, v, force[i]);
            (x, v) = (s[0], s[1]);
            if !x.is_finite() {
                return Err(ModelError::NotFinite { time_s: *next, what: "x".into() });
            }
        }
        let load: Vec<f64> = position.iter().map(|x| k * x).collect();
        let outputs = channels
            .iter()
            .map(|channel| {
                let values = match channel.as_str() {
                    "spring_deflection_m" => position.clone(),
                    "force_1_n" => load.iter().map(|f| f + self.added(values, *f)).collect(),
                    _ => return Err(ModelError::UnknownChannel { channel: channel.clone() }),
                };
                Ok(Signal { channel: channel.clone(), values })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let internals = vec![
            Signal { channel: internal::SCREW_SPEED.into(), values: speed },
            Signal { channel: internal::SCREW_FORCE.into(), values: load },
            Signal { channel: internal::SPRING_DEFLECTION.into(), values: position },
        ];
        Ok(Prediction { outputs, internals, ..Prediction::default() })
    }
    fn coarser(&self, _steps_per_sample: f64) -> Box<dyn Model> {
        Box::new(Self { by: self.coarser_by, ..self.clone() })
    }
    fn observing(&self, _records: &[&Record]) -> Option<Box<dyn Model>> {
        (self.coarser_by != 1.0).then(|| self.clone_box())
    }
    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}

pub(crate) use crate::stats::Noise;

/// A run of `n` samples at 200 Hz with a held random staircase, simulated with `values` and noise of
/// `noise_std` on both channels (force and deflection), a gain and a bias on the force, a gain on the
/// deflection.
pub(crate) fn run(
    values: &[f64],
    n: usize,
    seed: u64,
    noise_std: (f64, f64),
    gain_bias: (f64, f64),
    gain_x: f64,
) -> Record {
    distorted(values, n, seed, noise_std, gain_bias, gain_x, &|_, f| f)
}

/// The same with a force sensor that shows something else than the force, by time and force.
pub(crate) fn distorted(
    values: &[f64],
    n: usize,
    seed: u64,
    noise_std: (f64, f64),
    gain_bias: (f64, f64),
    gain_x: f64,
    shows: &dyn Fn(f64, f64) -> f64,
) -> Record {
    let mut noise = Noise::new(seed);
    let mut level = 0.0;
    let force: Vec<f64> = (0..n)
        .map(|i| {
            if i % 20 == 0 && i >= 40 {
                level = 20.0 * (noise.uniform() - 0.5);
            }
            level
        })
        .collect();
    let mut record = Record {
        cut: false,
        name: format!("toy-{seed}"),
        time_s: (0..n).map(|i| 0.005 * i as f64).collect(),
        hold: InputHold::ZeroOrder,
        inputs: vec![Signal { channel: "motor_force_n".into(), values: force }],
        outputs: Vec::new(),
    };
    let channels = ["force_1_n".to_owned(), "spring_deflection_m".to_owned()];
    let mut truth = Toy::new().predict(values, &record, &channels).unwrap().outputs;
    for (v, t) in truth[0].values.iter_mut().zip(&record.time_s) {
        *v = gain_bias.0 * shows(*t, *v) + gain_bias.1 + noise_std.0 * noise.normal();
    }
    for v in &mut truth[1].values {
        *v = gain_x * *v + noise_std.1 * noise.normal();
    }
    record.outputs = truth;
    record
}

/// A campaign of such runs, stated noise, all of one file that does not exist.
pub(crate) fn campaign(
    runs: Vec<(crate::campaign::Role, Record)>,
    noise: (f64, f64),
) -> crate::campaign::Campaign {
    use crate::campaign::{Bench, Campaign, Clock, NoiseOrigin, NoiseStd, Run};
    let channel = |name: &str, std: f64| NoiseStd {
        channel: name.into(),
        std,
        origin: NoiseOrigin::Stated,
        from_differences: std,
        quantum: None,
    };
    Campaign {
        name: "toy".into(),
        file: "toy/campaign.toml".into(),
        bench: Bench::Locked,
        robot: None,
        gravity_compensated: false,
        actuator: "toy".into(),
        scenario: None,
        model_line: None,
        sample_rate_hz: Some(200.0),
        noise: vec![channel("force_1_n", noise.0), channel("spring_deflection_m", noise.1)],
        sensors: Vec::new(),
        runs: runs
            .into_iter()
            .map(|(role, record)| Run {
                rig: crate::campaign::RigValues::default(),
                role,
                scenario: None,
                scored: 0..record.len(),
                left_out: crate::campaign::LeftOut::default(),
                unknown: Vec::new(),
                clock: Clock::of(&record.time_s, Some(200.0)),
                path: record.name.clone().into(),
                unit: None,
                record,
            })
            .collect(),
        repeats: Vec::new(),
        notes: Vec::new(),
    }
}
