//! A mystery on a whole leg: what to hide, where, and what is true of it.

use super::answer::{Answer, HiddenEffect, Named, TrueSensor};
use super::{Level, Mystery};
use crate::{Error, Result};
use sealegs_reference::campaign::leg::{
    LEG_CATALOGUE, LEG_PAIRS, LegOrder, MadeLeg, Plain, Scene, leg_place, leg_plain, leg_visible,
};
use sealegs_reference::campaign::{Draws, Hidden};

/// A mystery on a leg. The same seed and level give the same bits.
///
/// # Errors
///
/// [`Error::NoSuchMystery`] for [`Level::Rough`]; otherwise if a leg cannot be simulated.
pub fn leg_mystery(name: &str, seed: u64, level: Level) -> Result<Mystery> {
    let topic = match level {
        Level::Easy => "easy leg mystery",
        Level::Hard => "hard leg mystery",
        Level::Rough => return Err(Error::NoSuchMystery),
    };
    let mut draws = Draws::of(seed, topic);
    let own = draws.seed();
    loop {
        let scene = draws.one_of(&Scene::ALL);
        let plain =
            LegOrder { name: name.to_owned(), scene, seed: own, hidden: Vec::new(), step_s: scene.step_s() };
        let (effects, wanted) = choose(&mut draws, level);
        if let Some(hidden) = hide(&plain, &effects, wanted, &mut draws)? {
            let order = LegOrder { hidden, ..plain };
            let base_error = if order.hidden.is_empty() { 1.0 } else { leg_plain(&order)? };
            let made = order.make()?;
            let answer = answer_of(&made, seed, base_error);
            return Ok(Mystery { runs: made.runs.len(), files: made.files(), answer });
        }
    }
}

/// What to hide, and how plain each of it is alone.
fn choose(draws: &mut Draws, level: Level) -> (Vec<&'static str>, Plain) {
    match level {
        Level::Easy => (vec![draws.one_of(&LEG_CATALOGUE)], Plain::Dominant),
        Level::Hard | Level::Rough => match draws.one_of(&[0, 0, 1, 1, 2]) {
            0 => (vec![draws.one_of(&LEG_CATALOGUE)], Plain::Weak),
            1 => (draws.one_of(&LEG_PAIRS).to_vec(), Plain::Middle),
            _ => (Vec::new(), Plain::Weak),
        },
    }
}

/// The effects at places of their own; `None` where one of them cannot be seen.
fn hide(plain: &LegOrder, effects: &[&str], wanted: Plain, draws: &mut Draws) -> Result<Option<Vec<Hidden>>> {
    let mut hidden = Vec::new();
    for effect in effects {
        let Some(place) = leg_place(effect, plain.scene, draws) else { return Ok(None) };
        match leg_visible(plain, place, effect, wanted)? {
            Some(found) => hidden.push(found),
            None => return Ok(None),
        }
    }
    Ok(Some(hidden))
}

/// The truth of a made campaign.
fn answer_of(made: &MadeLeg, seed: u64, base_error: f64) -> Answer {
    let effect = |h: &Hidden| HiddenEffect {
        id: h.id.clone(),
        known: true,
        parameters: h.parameters.iter().map(|p| Named { name: p.0.to_owned(), value: p.1 }).collect(),
        port: None,
        depends_on: Vec::new(),
    };
    let sensors = made.sensors.iter().filter(|s| s.may_be_off());
    Answer {
        campaign: made.name.clone(),
        bench: "leg".to_owned(),
        seed,
        base_error,
        base_error_is_estimate: true,
        stamp: "start".to_owned(),
        rough: Vec::new(),
        effects: made.hidden.iter().map(effect).collect(),
        parameters: made
            .parameters
            .iter()
            .map(|(name, value)| Named { name: name.clone(), value: *value })
            .collect(),
        sensors: sensors
            .map(|s| TrueSensor { channel: s.channel.clone(), gain: s.gain, bias: s.bias })
            .collect(),
    }
}
