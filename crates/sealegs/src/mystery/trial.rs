//! How far the model without the hidden effect fails on a campaign, and how strong an effect must be for that.

use crate::Result;
use crate::bench_model;
use sealegs_actuator::bench::BenchModel;
use sealegs_model::Model;
use sealegs_reference::campaign::{Hidden, Made, Order, Rig, reach};
use sealegs_sysid::campaign::{Clock, LeftOut, NoiseOrigin, NoiseStd, RigValues};
use sealegs_sysid::fit::{self, FitOptions};
use sealegs_sysid::{Bench, Campaign, Data, Role, Run};
use std::path::PathBuf;

/// Steps of the integrator per row while a strength is looked for: 50 us.
const COARSE_SUBSTEPS: usize = 20;

/// Duration of the runs while a strength is looked for, s: the same commands in less time.
const SHORT_S: f64 = 6.0;

/// Error below which runs do not show an effect.
const FELT: f64 = 1.15;

/// How far the model without an effect fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Strength {
    /// A little above the noise.
    Weak,
    /// Plain to see, small beside the motion.
    Middle,
    /// It dominates the error.
    Dominant,
}

impl Strength {
    /// Every one, weakest first.
    pub const ALL: [Self; 3] = [Self::Weak, Self::Middle, Self::Dominant];

    /// The name in tables.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Weak => "weak",
            Self::Middle => "middle",
            Self::Dominant => "dominant",
        }
    }

    /// The base model's error that it means for an effect, noise units.
    ///
    /// The rotor's encoder resolves a deflection of 0.16 um, 0.1 N: what moves the rotor leaves errors of hundreds,
    /// what only the load cells (2 N) see can leave some tens at most.
    #[must_use]
    pub fn window(self, id: &str) -> (f64, f64) {
        let seen_by_load_cells_only = [
            "structural-mode",
            "sensor-lag",
            "sensor-delay@force",
            "clipped-load-cell",
            "drifting-bias",
            "dead-band-load-cell",
        ]
        .iter()
        .any(|of| id.starts_with(of));
        match (self, seen_by_load_cells_only) {
            (Self::Weak, _) => (1.3, 1.5),
            (Self::Middle, true) => (2.5, 5.0),
            (Self::Middle, false) => (8.0, 25.0),
            (Self::Dominant, true) => (8.0, 20.0),
            (Self::Dominant, false) => (100.0, 400.0),
        }
    }
}

/// What `Campaign::read` would make of the campaign's files, and its model.
///
/// # Errors
///
/// None for what the reference simulator makes; those of [`bench_model::of_campaign`].
pub fn campaign_of(made: &Made) -> Result<(Campaign, BenchModel)> {
    let noise = made.noise_std.iter().map(|(channel, std)| NoiseStd {
        channel: (*channel).to_owned(),
        std: *std,
        origin: NoiseOrigin::Stated,
        from_differences: *std,
        quantum: None,
    });
    let run = |made: &sealegs_reference::campaign::MadeRun| Run {
        role: if made.holdout { Role::Holdout } else { Role::Fit },
        scenario: None,
        rig: RigValues::default(),
        scored: 0..made.record.len(),
        left_out: LeftOut::default(),
        unknown: Vec::new(),
        clock: Clock::of(&made.record.time_s, None),
        path: PathBuf::from(&made.record.name),
        unit: None,
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
        robot: None,
        gravity_compensated: false,
        model_line: None,
        sample_rate_hz: None,
        noise: noise.collect(),
        sensors: Vec::new(),
        runs: made.runs.iter().map(run).collect(),
        repeats: Vec::new(),
        notes: Vec::new(),
    };
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new())?;
    Ok((campaign, model))
}

/// The refitted base model's error on the holdout runs, in noise units.
///
/// # Errors
///
/// If the model cannot be simulated.
pub fn base_error(made: &Made) -> Result<f64> {
    Ok(errors(made)?.1)
}

/// The refitted base model's error on the fit runs and on the holdout runs, in noise units.
fn errors(made: &Made) -> Result<(f64, f64)> {
    let (campaign, model) = campaign_of(made)?;
    let data = Data::new(&campaign, Some(Role::Fit), &model)?;
    let holdout = Data::new(&campaign, Some(Role::Holdout), &model)?;
    let fitted = fit::fit(&data, &model, &FitOptions::default())?;
    let judged = holdout.judge(&model, &fitted.values, fitted.sensors())?;
    Ok((fitted.error(), judged.rms))
}

/// How far an effect shows: in fit and holdout runs alike, for what only held-out runs show cannot be found.
fn shown(made: &Made) -> Result<f64> {
    let (fit, holdout) = errors(made)?;
    Ok(fit.min(holdout))
}

/// Whether every parameter of the hidden effects lies where a fit may look for it.
fn admitted(made: &Made) -> Result<bool> {
    let (campaign, model) = campaign_of(made)?;
    let data = Data::new(&campaign, Some(Role::Fit), &model)?;
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let cards = model.effects(&data.excitation(&data.predict(&model, &nominal)?));
    let within = |hidden: &Hidden| {
        let Some(card) = cards.iter().find(|c| c.id == hidden.id) else { return hidden.beyond.is_some() };
        let mut pairs = card.parameters.iter().zip(&hidden.parameters);
        pairs.all(|(p, (_, value))| (p.min..=p.max).contains(value))
    };
    Ok(made.hidden.iter().all(within))
}

/// The effect with the seed's shape, so strong that the base model's error on shorter runs of the order, fit and holdout
/// alike, is that of a strength; `None` where nothing brings it there: it cannot be seen on this bench, or only beyond
/// the bounds that its card admits.
///
/// # Errors
///
/// Those of [`base_error`].
pub fn visible(order: &Order, id: &str, strength: Strength) -> Result<Option<Hidden>> {
    let short = |amount: f64| Order {
        hidden: vec![Hidden::drawn(id, order.seed, amount)],
        duration_s: order.duration_s.min(SHORT_S),
        substeps: COARSE_SUBSTEPS,
        ..order.clone()
    };
    let Some(amount) = reach(strength.window(id), |amount| shown(&short(amount).make()))? else {
        return Ok(None);
    };
    let admitted = admitted(&short(amount).make())?;
    // Whole runs may be driven otherwise than short ones.
    let whole = Order { duration_s: order.duration_s, ..short(amount) };
    let shows = order.duration_s <= SHORT_S || shown(&whole.make())? >= FELT;
    Ok((admitted && shows).then(|| Hidden::drawn(id, order.seed, amount)))
}
