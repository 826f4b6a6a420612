//! A model of one's own, as diagnosis sees any model: a mass on a spring and a damper, driven by a force.
//!
//! `cargo run --release -p sealegs-model --example own_model`

use sealegs_model::{
    EffectCard, Excitation, InputHold, Model, ModelError, Parameter, Prediction, Record, Signal,
};

/// `m x'' + b x' + k x = F`, with `m` of 1 kg.
#[derive(Debug, Clone)]
struct Oscillator {
    parameters: Vec<Parameter>,
}

impl Model for Oscillator {
    fn name(&self) -> String {
        "a mass on a spring".to_owned()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn inputs(&self) -> &[&'static str] {
        &["motor_force_n"]
    }

    fn predicts(&self, channel: &str) -> bool {
        channel == "position_m"
    }

    fn included(&self) -> Vec<String> {
        Vec::new()
    }

    fn effects(&self, _seen: &Excitation) -> Vec<EffectCard> {
        Vec::new()
    }

    fn with_effect(&self, id: &str, _seen: &Excitation) -> Result<Box<dyn Model>, ModelError> {
        Err(ModelError::UnknownEffect { id: id.to_owned(), suggestion: None })
    }

    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        if let Some(channel) = channels.iter().find(|c| !self.predicts(c)) {
            return Err(ModelError::UnknownChannel { channel: channel.clone() });
        }
        let no_input = || ModelError::NoInput {
            record: record.name.clone(),
            wanted: vec!["motor_force_n".to_owned()],
            found: Vec::new(),
        };
        let force_n = record.input("motor_force_n").ok_or_else(no_input)?;
        let [stiffness_n_m, damping_n_s_m] = [values[0], values[1]];
        let (mut position_m, mut speed_m_s) = (0.0, 0.0);
        let mut positions_m = vec![position_m];
        for (i, step) in record.time_s.windows(2).enumerate() {
            let step_s = step[1] - step[0];
            speed_m_s += step_s * (force_n[i] - damping_n_s_m * speed_m_s - stiffness_n_m * position_m);
            position_m += step_s * speed_m_s;
            positions_m.push(position_m);
        }
        let outputs =
            channels.iter().map(|c| Signal { channel: c.clone(), values: positions_m.clone() }).collect();
        Ok(Prediction { outputs, ..Prediction::default() })
    }

    fn clone_box(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }
}

fn main() -> Result<(), ModelError> {
    let model = Oscillator {
        parameters: vec![
            Parameter::new("stiffness", "N/m", 400.0, 1.0, 1e6),
            Parameter::new("damping", "N s/m", 4.0, 0.0, 1e3),
        ],
    };
    let time_s: Vec<f64> = (0..2000).map(|i| 1e-3 * f64::from(i)).collect();
    let record = Record {
        cut: false,
        name: "a step of 8 N".to_owned(),
        inputs: vec![Signal { channel: "motor_force_n".to_owned(), values: vec![8.0; time_s.len()] }],
        outputs: Vec::new(),
        hold: InputHold::ZeroOrder,
        time_s,
    };
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let channels = ["position_m".to_owned()];
    for (name, values) in
        [("nominal", nominal.clone()), ("twice as stiff", vec![2.0 * nominal[0], nominal[1]])]
    {
        let prediction = model.predict(&values, &record, &channels)?;
        let position_m = prediction.output("position_m").expect("it was asked for");
        let most_m = position_m.iter().copied().fold(0.0, f64::max);
        let last_m = position_m.last().copied().unwrap_or_default();
        println!("{name}: overshoots to {:.1} mm, ends at {:.1} mm", 1e3 * most_m, 1e3 * last_m);
    }
    Ok(())
}
