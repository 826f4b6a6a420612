//! How far the model without the hidden effect fails on a campaign, and how strong an effect must be for that.

use crate::bench_model;
use sealegs_actuator::bench::BenchModel;
use sealegs_reference::campaign::{Hidden, Made, Order, Rig, reach};
use sealegs_sysid::campaign::{Clock, NoiseOrigin, NoiseStd};
use sealegs_sysid::fit::{self, FitOptions};
use sealegs_sysid::{Bench, Campaign, Data, Role, Run};
use std::path::PathBuf;

/// Steps of the integrator per row while a strength is looked for: 50 us.
const COARSE_SUBSTEPS: usize = 20;

/// Duration of the runs while a strength is looked for, s: the same commands in less time.
const SHORT_S: f64 = 6.0;

/// What `Campaign::read` would make of the campaign's files, and its model.
///
/// # Errors
///
/// None for what the reference simulator makes; those of [`bench_model::of_campaign`].
pub fn campaign_of(made: &Made) -> anyhow::Result<(Campaign, BenchModel)> {
    let noise = made.noise_std.iter().map(|(channel, std)| NoiseStd {
        channel: (*channel).to_owned(),
        std: *std,
        origin: NoiseOrigin::Stated,
        from_differences: *std,
        quantum: None,
    });
    let run = |made: &sealegs_reference::campaign::MadeRun| Run {
        role: if made.holdout { Role::Holdout } else { Role::Fit },
        scored: 0..made.record.len(),
        unknown: Vec::new(),
        clock: Clock::of(&made.record.time_s, None),
        path: PathBuf::from(&made.record.name),
        record: made.record.clone(),
    };
    let mut campaign = Campaign {
        name: made.name.clone(),
        file: PathBuf::from("campaign.toml"),
        bench: match made.rig {
            Rig::Locked => Bench::Locked,
            Rig::Pendulum => Bench::Pendulum,
        },
        actuator: made.actuator.to_owned(),
        scenario: None,
        sample_rate_hz: None,
        noise: noise.collect(),
        sensors: Vec::new(),
        runs: made.runs.iter().map(run).collect(),
        repeats: Vec::new(),
        notes: Vec::new(),
    };
    let model = bench_model::of_campaign(&mut campaign, None)?;
    Ok((campaign, model))
}

/// The refitted base model's error on the holdout runs, in noise units.
///
/// # Errors
///
/// If the model cannot be simulated.
pub fn base_error(made: &Made) -> anyhow::Result<f64> {
    let (campaign, model) = campaign_of(made)?;
    let data = Data::new(&campaign, Some(Role::Fit), &model)?;
    let holdout = Data::new(&campaign, Some(Role::Holdout), &model)?;
    let fitted = fit::fit(&data, &model, &FitOptions::default())?;
    Ok(holdout.judge(&model, &fitted.values, fitted.sensors())?.rms)
}

/// The effect with the seed's shape, so strong that the base model's error on shorter runs of the order lies in
/// a window (noise units); `None` where no strength brings it there: it cannot be seen on this bench.
///
/// # Errors
///
/// Those of [`base_error`].
pub fn visible(order: &Order, id: &str, window: (f64, f64)) -> anyhow::Result<Option<Hidden>> {
    let strength = reach(window, |strength| {
        let hidden = vec![Hidden::drawn(id, order.seed, strength)];
        let duration_s = order.duration_s.min(SHORT_S);
        base_error(&Order { hidden, duration_s, substeps: COARSE_SUBSTEPS, ..order.clone() }.make())
    })?;
    Ok(strength.map(|strength| Hidden::drawn(id, order.seed, strength)))
}
