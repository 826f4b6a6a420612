//! A closed-form model for tests: a driven mass, spring and damper, discretised exactly.
//!
//! `m x'' + c x' + k x = u` under a zero-order held force, `x` measured as `spring_deflection_m` and
//! `k x` as `force_1_n`. Its one effect, `cubic-sensor`, adds `a (k x)^3` to the force channel.

use sealegs_model::{
    EffectCard, Excitation, InputHold, Model, ModelError, Parameter, Prediction, Record, Signal, internal,
};

#[derive(Debug, Clone)]
pub(crate) struct Toy {
    pub parameters: Vec<Parameter>,
    /// Amplitude and period of a wave along the effect's parameter, which gives the error many minima.
    pub wave: (f64, f64),
    /// Factor of the mass in a coarser copy, the error of its steps; where it is not 1 there is an observer that does as the model does.
    pub coarser_by: f64,
    /// The same in this copy.
    by: f64,
    cubic: bool,
}

impl Toy {
    pub fn new() -> Self {
        let mut parameters = vec![
            Parameter::new("mass", "kg", 1.0, 0.2, 5.0),
            Parameter::new("damping", "N s/m", 4.0, 0.1, 50.0),
            Parameter::new("stiffness", "N/m", 400.0, 50.0, 2000.0),
        ];
        parameters[1].scale = sealegs_model::Scale::Logarithmic;
        Self { parameters, wave: (0.0, 1.0), coarser_by: 1.0, by: 1.0, cubic: false }
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
        if self.cubic { vec!["cubic-sensor".into()] } else { Vec::new() }
    }
    fn effects(&self, _seen: &Excitation) -> Vec<EffectCard> {
        if self.cubic {
            return Vec::new();
        }
        let mut parameter = Parameter::new("cubic-sensor.a", "1/N^2", 1e-4, -1.0, 1.0);
        parameter.neutral = Some(0.0);
        vec![EffectCard {
            id: "cubic-sensor".into(),
            summary: "a sensor that stiffens".into(),
            acts_on: "sensor".into(),
            equation: "F + a F^3".into(),
            validity: "any".into(),
            reference: "none".into(),
            symbols: "a: cubic gain".into(),
            told_apart: "alone".into(),
            cure: "another sensor".into(),
            parameters: vec![parameter],
            passive: true,
            becomes: None,
        }]
    }
    fn with_effect(&self, id: &str, seen: &Excitation) -> Result<Box<dyn Model>, ModelError> {
        let card = self.effects(seen).into_iter().find(|c| c.id == id);
        let card = card.ok_or(ModelError::UnknownEffect { id: id.into(), suggestion: None })?;
        let mut with = self.clone();
        with.parameters.extend(card.parameters);
        with.cubic = true;
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
        for i in 0..record.len() {
            position.push(x);
            speed.push(v);
            let Some(next) = record.time_s.get(i + 1) else { break };
            let dt = next - record.time_s[i];
            let a = nalgebra::Matrix3::new(0.0, 1.0, 0.0, -k / m, -c / m, 1.0 / m, 0.0, 0.0, 0.0) * dt;
            let s = a.exp() * nalgebra::Vector3::new(x, v, force[i]);
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
                    "force_1_n" if self.cubic => {
                        let (amplitude, period) = self.wave;
                        let cubic =
                            values[3] + amplitude * (std::f64::consts::TAU * values[3] / period).sin();
                        load.iter().map(|f| f + cubic * f.powi(3)).collect()
                    }
                    "force_1_n" => load.clone(),
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
    for v in &mut truth[0].values {
        *v = gain_bias.0 * *v + gain_bias.1 + noise_std.0 * noise.normal();
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
