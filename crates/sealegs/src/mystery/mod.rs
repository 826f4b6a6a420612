//! Mysteries: campaigns with something hidden in them, made by the independent simulators, and the judging of a
//! verdict on them.
//!
//! A bench's mystery comes from [`bench_mystery`], a leg's from [`leg_mystery`]. Whatever makes one returns a
//! [`Mystery`], which is all that the verb writes: a generator for another kind of bench is one more function of this
//! kind.

pub mod answer;
mod judged;
mod leg;
pub mod located;
mod reveal;
pub mod score;
pub mod trial;

pub use judged::{Judged, Judgement, judge};
pub use leg::leg_mystery;
pub use located::{Located, MissingSignal, located};
pub use reveal::{Fitted, Verdict, page};

use crate::Result;
use answer::{Answer, HiddenEffect, Named, TrueSensor};
use sealegs_actuator::ActuatorSpec;
use sealegs_reference::campaign::{
    BEYOND, CATALOGUE, Draws, Hidden, Made, Order, PAIRS, Rig, Rough, SUBSTEPS,
};
use trial::Strength;

/// How hard it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// One effect of the catalogue that dominates the error.
    Easy,
    /// A weak effect, two at once, nothing at all, or one that is in no catalogue.
    Hard,
    /// A plain effect of the catalogue or nothing, in a log with one or two roughnesses: a slow logger, one load cell, no
    /// stated noise, spikes, repeated rows, coarse encoders, a weak command, one fit run, sensors read late.
    Rough,
}

/// A campaign's files, without the answer, and the answer.
#[derive(Debug)]
pub struct Mystery {
    /// Name and text of each.
    pub files: Vec<(String, String)>,
    /// How many runs it has.
    pub runs: usize,
    /// What is true.
    pub answer: Answer,
}

/// Duration of a run on a bench, s, where no other is asked for.
pub const DURATION_S: f64 = 20.0;

/// The shortest run of a bench in which its chirp still is one, s.
pub const SHORTEST_S: f64 = 3.0;

/// A mystery on a bench, with runs of a duration, s. The same seed, level and duration give the same bits.
///
/// ```
/// use sealegs::mystery::{DURATION_S, Level, bench_mystery};
/// use sealegs::reference::campaign::Rig;
///
/// let mystery = bench_mystery("riddle", Rig::Locked, 7, Level::Easy, DURATION_S)?;
/// let names: Vec<&str> = mystery.files.iter().map(|(name, _)| name.as_str()).collect();
/// assert!(names.contains(&"campaign.toml"));
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::TooShort`](crate::Error::TooShort) below [`SHORTEST_S`]; otherwise if a model cannot be simulated.
pub fn bench_mystery(name: &str, rig: Rig, seed: u64, level: Level, duration_s: f64) -> Result<Mystery> {
    if !(SHORTEST_S..=f64::MAX).contains(&duration_s) {
        return Err(crate::Error::TooShort { duration_s, shortest_s: SHORTEST_S });
    }
    let topic = match level {
        Level::Easy => "easy mystery",
        Level::Hard => "hard mystery",
        Level::Rough => "rough mystery",
    };
    let mut draws = Draws::of(seed, topic);
    let rough = if level == Level::Rough { Rough::drawn(&mut draws) } else { Vec::new() };
    // How strong an effect must be is looked for without the dirt: it would be taken for the effect.
    let clean = rough.iter().copied().filter(|r| !r.is_dirt()).collect();
    let plain = Order {
        name: name.to_owned(),
        rig,
        seed: draws.seed(),
        hidden: Vec::new(),
        duration_s,
        substeps: SUBSTEPS,
        rough: clean,
    };
    loop {
        let (ids, strength) = choose(&mut draws, level);
        if let Some(hidden) = hide(&plain, &ids, strength)? {
            let order = Order { hidden, ..plain };
            let base_error = trial::base_error(&order.make())?;
            let made = Order { rough, ..order }.make();
            let answer = answer_of(&made, seed, base_error);
            return Ok(Mystery { runs: made.runs.len(), files: made.files(), answer });
        }
    }
}

/// What to hide, and how strong each of it is alone.
fn choose(draws: &mut Draws, level: Level) -> (Vec<&'static str>, Strength) {
    match level {
        Level::Easy => (vec![draws.one_of(&CATALOGUE)], Strength::Dominant),
        Level::Hard => match draws.one_of(&[0, 0, 1, 1, 2, 3]) {
            0 => (vec![draws.one_of(&CATALOGUE)], Strength::Weak),
            1 => (draws.one_of(&PAIRS).to_vec(), Strength::Middle),
            2 => (Vec::new(), Strength::Weak),
            _ => (vec![draws.one_of(&BEYOND)], Strength::Middle),
        },
        Level::Rough => match draws.one_of(&[0, 1, 1, 2]) {
            0 => (Vec::new(), Strength::Weak),
            1 => (vec![draws.one_of(&CATALOGUE)], Strength::Middle),
            _ => (vec![draws.one_of(&CATALOGUE)], Strength::Dominant),
        },
    }
}

/// The effects at a strength; `None` where one of them cannot be seen here.
fn hide(plain: &Order, ids: &[&str], strength: Strength) -> Result<Option<Vec<Hidden>>> {
    let mut hidden = Vec::new();
    for id in ids {
        if !Hidden::applies(id, plain.rig) {
            return Ok(None);
        }
        match trial::visible(plain, id, strength)? {
            Some(effect) => hidden.push(effect),
            None => return Ok(None),
        }
    }
    Ok(Some(hidden))
}

/// The truth of a made campaign. `seed` is the one that it was asked for by, `base_error` that of [`Answer::base_error`].
#[must_use]
pub fn answer_of(made: &Made, seed: u64, base_error: f64) -> Answer {
    let named = |(name, value): &(&str, f64)| Named { name: (*name).to_owned(), value: *value };
    let spec = ActuatorSpec::preset(made.actuator);
    let base = spec.map(|s| made.individual.base_parameters(&s)).unwrap_or_default();
    Answer {
        campaign: made.name.clone(),
        bench: made.rig.as_str().to_owned(),
        seed,
        base_error,
        base_error_is_estimate: false,
        stamp: made.individual.stamp.as_str().to_owned(),
        rough: made.rough.iter().map(|r| r.as_str().to_owned()).collect(),
        effects: made
            .hidden
            .iter()
            .map(|h| HiddenEffect {
                id: h.id.clone(),
                known: h.beyond.is_none(),
                parameters: h.parameters.iter().map(named).collect(),
                port: h.beyond.map(|b| b.whereabouts().port.to_owned()),
                depends_on: h.beyond.map_or_else(Vec::new, |b| {
                    b.whereabouts().depends_on.iter().map(|d| (*d).to_owned()).collect()
                }),
            })
            .collect(),
        parameters: base.iter().map(named).collect(),
        sensors: ["force_1_n", "force_2_n"]
            .iter()
            .zip(made.individual.gain.iter().zip(&made.individual.bias_n))
            .map(|(channel, (gain, bias))| TrueSensor {
                channel: (*channel).to_owned(),
                gain: *gain,
                bias: *bias,
            })
            .collect(),
    }
}
