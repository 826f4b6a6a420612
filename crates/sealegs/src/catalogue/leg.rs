//! The leg on which its own effects are shown: THOR's, dropped.

use super::bench::seen;
use super::{Entry, Home, Signature, changes, most_telling, residual, shown_at};
use crate::Result;
use sealegs_leg::effect::{CATALOGUE, LegSetting, law_graph};
use sealegs_leg::model::{COMPARISON_STEP_S, LegModel};
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_model::{EffectCard, InputHold, Model, ModelError, Prediction, Record};

/// How long the drop is watched, s: touch-down and the first rebound.
const DURATION_S: f64 = 0.4;

/// Where each effect is shown, where it has several places.
const PLACES: [&str; 3] = ["knee", "shank", "foot"];

/// An effect that changes a channel by less than this share is shown at other values, if those show more.
const SHOWS: f64 = 0.02;

/// What is looked at.
const CHANNELS: [&str; 7] = [
    "knee.angle_rad",
    "hip_pitch.angle_rad",
    "ankle_pitch.angle_rad",
    "knee.force_1_n",
    "knee.rotor_angle_rad",
    "base.height_m",
    "foot.normal_force_n",
];

struct Ready {
    model: LegModel,
    record: Record,
    channels: Vec<String>,
    predicted: Prediction,
}

fn scenario() -> Result<Scenario> {
    Ok(Scenario::load("thor-drop", &[format!("duration_s={DURATION_S}")])?)
}

fn model() -> Result<LegModel> {
    let scenario = scenario()?;
    Ok(LegModel::new(scenario.clone(), &scenario, Vec::new(), Vec::new())?.with_step(COMPARISON_STEP_S))
}

fn ready() -> Result<Ready> {
    let model = model()?;
    let record = Record {
        cut: false,
        name: "signature".to_owned(),
        time_s: (0..=(1e3 * DURATION_S) as usize).map(|i| 1e-3 * i as f64).collect(),
        hold: InputHold::ZeroOrder,
        inputs: Vec::new(),
        outputs: Vec::new(),
    };
    let channels: Vec<String> =
        CHANNELS.iter().filter(|c| model.predicts(c)).map(|c| (*c).to_owned()).collect();
    let predicted = model.predict(&values(&model), &record, &channels)?;
    Ok(Ready { model, record, channels, predicted })
}

fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

/// The leg's own effects in their catalogue's order; those of the benches that a leg can have at an actuator are marked.
pub(super) fn entries(benches: &mut [Entry]) -> Result<Vec<Entry>> {
    let ready = ready()?;
    let cards = ready.model.effects(&seen(&ready.record, &ready.predicted));
    let own = |id: &str| CATALOGUE.iter().any(|effect| effect.id() == id);
    for bench in benches.iter_mut().filter(|b| !own(&b.card.id)) {
        bench.on_leg = cards.iter().any(|c| c.id.ends_with(&format!("/{}", bench.card.id)));
    }
    let entry = |own: &str| {
        let at = |place: &str| cards.iter().find(|c| c.id == format!("{place}/{own}"));
        let card = PLACES.iter().find_map(|place| at(place))?;
        let place = card.id.split('/').next()?.to_owned();
        Some(Entry {
            card: EffectCard { id: own.to_owned(), ..card.clone() },
            home: Home::Leg(place),
            on_leg: true,
        })
    };
    Ok(CATALOGUE.iter().filter_map(|effect| entry(effect.id())).collect())
}

pub(super) fn signature(place: &str, card: &EffectCard) -> Result<Signature> {
    let ready = ready()?;
    let seen = seen(&ready.record, &ready.predicted);
    let id = format!("{place}/{}", card.id);
    let with = ready.model.with_effect(&id, &seen)?;
    let first = shown_at(card);
    let mut sets = vec![first.clone()];
    sets.extend(card.parameters.first().into_iter().flat_map(|p| &p.starts).map(|start| {
        let mut set = first.clone();
        set[0] = *start;
        set
    }));
    let mut best: Option<(super::Change, Vec<f64>)> = None;
    for own in sets {
        let all = [values(&ready.model), own.clone()].concat();
        let truth = with.predict(&all, &ready.record, &ready.channels)?;
        let Some(change) = most_telling(changes(&truth, &ready.predicted, &ready.record.time_s)) else {
            continue;
        };
        let enough = change.share > SHOWS;
        if best.as_ref().is_none_or(|(b, _)| change.share > b.share) {
            best = Some((change, own));
        }
        if enough {
            break;
        }
    }
    let (change, own) =
        best.ok_or_else(|| ModelError::Setup { reason: format!("{id} shows in no channel") })?;
    let scenario = scenario()?;
    let robot = Robot::load(&scenario.robot, None)?;
    let leg = LegSetting { scenario: &scenario, robot: &robot, seen: &seen };
    let law = CATALOGUE
        .iter()
        .find(|effect| effect.id() == card.id)
        .and_then(|effect| law_graph(*effect, &own, place, &leg));
    let run = format!("THOR's leg dropped from 0.1 m (thor-drop), the effect at {place}");
    Ok(Signature { values: own, law, run, residual: residual(change) })
}
