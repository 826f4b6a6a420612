//! What simulations in the time domain give: the identifications of section 3-4 rehearsed, and a link that moves.

use std::f64::consts::TAU;

use sealegs_actuator::Configuration;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_model::{InputHold, Model, Record, Signal};

use super::{Call, Function};
use crate::ReproduceError;
use crate::setup::Setup;
use crate::thor::STIFF_N_M;

pub(super) const FUNCTIONS: [Function; 3] = [
    Function {
        name: "locked_rehearsal",
        usage: "field: identification of the locked bench by H1 and a second-order fit",
        law: locked_rehearsal,
    },
    Function {
        name: "moving_rehearsal",
        usage: "field: the pendulum bench under noise, by H1",
        law: moving_rehearsal,
    },
    Function {
        name: "simulated_force_ratio",
        usage: "mass of a free link at the spring in kg, Hz: F_sprung/F_unsprung by time integration, as a ratio",
        law: simulated_force_ratio,
    },
];

fn locked_rehearsal(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let found = setup.rehearsals()?;
    let per_cent = |value: f64, truth: f64| 100.0 * (value / truth - 1.0);
    let (without, with) = (&found.fit, &found.fit_with_hold);
    let [numerator, first, zeroth] = found.truth;
    match call.word(0)? {
        "numerator_error_per_cent" => Ok(per_cent(without.numerator, numerator)),
        "first_error_per_cent" => Ok(per_cent(without.first, first)),
        "zeroth_error_per_cent" => Ok(per_cent(without.zeroth, zeroth)),
        "first_error_with_hold_per_cent" => Ok(per_cent(with.first, first)),
        "zeroth_error_with_hold_per_cent" => Ok(per_cent(with.zeroth, zeroth)),
        "static_gain_with_hold" => Ok(with.static_gain()),
        other => Err(call.unknown("field", other)),
    }
}

fn moving_rehearsal(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let found = &setup.rehearsals()?.moving;
    match call.word(0)? {
        "unlumped_peak_hz" => Ok(found.unlumped_peak.frequency_hz),
        "unlumped_peak_db" => Ok(found.unlumped_peak.magnitude_db),
        "lumped_peak_hz" => Ok(found.lumped_peak.frequency_hz),
        "lumped_peak_db" => Ok(found.lumped_peak.magnitude_db),
        "dip_hz" => Ok(found.dip_hz),
        "swing_rms_rad" => Ok(found.swing_rms_rad),
        "swing_greatest_rad" => Ok(found.swing_greatest_rad),
        other => Err(call.unknown("field", other)),
    }
}

/// The link's own oscillation has died away when the last 10 s are taken.
fn simulated_force_ratio(setup: &Setup, call: &Call<'_>) -> Result<f64, ReproduceError> {
    let bench = Bench::Masses { link_1_kg: call.number(0)?, link_2_kg: f64::INFINITY };
    let model = BenchModel::new(setup.thor.spec_with(Configuration::SprungMotorHousing, STIFF_N_M), bench)?;
    let (hz, rate_hz) = (call.number(1)?, 2000.0);
    let time_s: Vec<f64> = (0..40_001).map(|i| f64::from(i) / rate_hz).collect();
    // Rising slowly, so that the free oscillation of the link stays small.
    let values = time_s.iter().map(|t| 500.0 * (t / 5.0).min(1.0) * (TAU * hz * t).sin()).collect();
    let record = Record {
        cut: false,
        name: "free sprung link".to_owned(),
        time_s: time_s.clone(),
        hold: InputHold::Linear,
        inputs: vec![Signal { channel: "motor_force_n".to_owned(), values }],
        outputs: Vec::new(),
    };
    let parameters: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let channels = ["force_1_n".to_owned(), "force_2_n".to_owned()];
    let outputs = model
        .predict(&parameters, &record, &channels)
        .map_err(|e| ReproduceError::simulation("free sprung link", e))?
        .outputs;
    // The part at this frequency of the last 10 s under a Hann window, which what is left of the free oscillation does not reach.
    let part = |values: &[f64]| {
        let (mut re, mut im) = (0.0, 0.0);
        for i in 20_000..40_000 {
            let window = 0.5 - 0.5 * (TAU * (i - 20_000) as f64 / 20_000.0).cos();
            let (sin, cos) = (TAU * hz * time_s[i]).sin_cos();
            re += window * values[i] * cos;
            im += window * values[i] * sin;
        }
        re.hypot(im)
    };
    Ok(part(&outputs[0].values) / part(&outputs[1].values))
}
