//! The catalogue of effects: every card with what a reader needs beside it, and its signature.
//!
//! ```
//! let entry = sealegs::catalogue::find("backlash")?;
//! assert!(entry.card().equation.contains("delta"));
//! // What a log shows of it: the residual of the model that lacks it, and the law over its own argument.
//! let signature = entry.signature()?;
//! assert!(!signature.residual.curves[0].points.is_empty());
//! # Ok::<(), sealegs::Error>(())
//! ```

mod bench;
mod leg;
mod markdown;
mod plot;
mod text;

pub use markdown::{Page, book};
pub use plot::{braille, svg};
pub use text::{card as card_text, table as table_text};

use crate::{Error, Result};
use sealegs_actuator::effect::{CATALOGUE, Graph, Setting};
use sealegs_actuator::text::nearest;
use sealegs_model::{EffectCard, Parameter, Prediction, Signal, Unit};
use serde::Serialize;

/// An effect of the catalogue, at the place where its signature is computed.
#[derive(Debug, Clone)]
pub struct Entry {
    card: EffectCard,
    home: Home,
    on_leg: bool,
}

/// Where an effect can be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Home {
    /// On one of the benches that [`bench`] has.
    Bench(bench::Rig),
    /// At a place of the leg that [`leg`] drops.
    Leg(String),
}

/// What an effect leaves in a log, at the values that a search would begin with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Signature {
    /// The parameters' values, in the card's order.
    pub values: Vec<f64>,
    /// The law over its own argument; `None` where it has no closed form of one argument.
    pub law: Option<Graph>,
    /// What was run, in words.
    pub run: String,
    /// Measured minus predicted over time, in the channel that shows it best, where the truth has the effect and the
    /// model lacks it.
    pub residual: Graph,
}

/// An effect's card as JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Sheet {
    /// Id without a place.
    pub id: String,
    /// One line: what happens physically.
    pub summary: String,
    /// Where it can be: `bench`, `leg` or both.
    pub found_on: Vec<&'static str>,
    /// The part that it acts on.
    pub acts_on: String,
    /// The law in plain text.
    pub equation: String,
    /// The equation's symbols.
    pub symbols: String,
    /// Sign and validity.
    pub validity: String,
    /// Source.
    pub reference: String,
    /// How data tell it from its neighbours.
    pub told_apart: String,
    /// The usual cure.
    pub cure: String,
    /// Whether it can only take energy out or store it.
    pub passive: bool,
    /// The simpler law that it contains.
    pub contains: Option<&'static str>,
    /// Its parameters.
    pub parameters: Vec<SheetParameter>,
    /// Its signature, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signature: Option<Signature>,
}

/// A parameter of an effect, for the rig on which its signature is computed.
#[derive(Debug, Clone, Serialize)]
pub struct SheetParameter {
    /// Its name in files, with the unit as its ending.
    pub name: String,
    /// SI unit; empty for a ratio.
    pub unit: String,
    /// First guess of a search.
    pub guess: f64,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// The value at which the effect vanishes; `None` where it cannot switch it off, or does so at infinity.
    pub off: Option<f64>,
}

/// All effects, the actuators' first, in the order of the catalogues.
///
/// ```
/// for effect in sealegs::catalogue::entries()? {
///     println!("{}: {}", effect.page_name(), effect.card().summary);
/// }
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// If a rig of the program's own cannot be run.
pub fn entries() -> Result<Vec<Entry>> {
    let mut all = bench::entries()?;
    let legs = leg::entries(&mut all)?;
    all.extend(legs);
    Ok(all)
}

/// The effect of this id; a place before it (`knee/`) and a channel behind it (`@force_1_n`) do not count.
///
/// ```
/// let friction = sealegs::catalogue::find("knee/coulomb-friction")?;
/// assert_eq!(friction.card().id, "coulomb-friction");
/// assert_eq!(friction.found_on(), ["bench", "leg"]);
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::NoSuchEffect`] with all ids that contain this one, or else the nearest.
pub fn find(id: &str) -> Result<Entry> {
    let plain = id.rsplit('/').next().unwrap_or(id).split('@').next().unwrap_or(id);
    let at_joint = id.contains('/') && plain == "output-friction";
    let all = entries()?;
    let mut found = all.iter().filter(|e| e.card.id == plain);
    // A leg has a friction of its own at its joints.
    let found = if at_joint { found.next_back() } else { found.next() };
    found.cloned().ok_or_else(|| {
        let ids = || all.iter().map(|e| e.card.id.as_str());
        let mut suggestions: Vec<String> = Vec::new();
        for id in ids().filter(|id| id.contains(plain)) {
            // Some stand in the catalogue for a bench and for a leg.
            if suggestions.iter().all(|s| s != id) {
                suggestions.push(id.to_owned());
            }
        }
        if plain.is_empty() || suggestions.is_empty() {
            suggestions = nearest(plain, ids()).into_iter().collect();
        }
        Error::NoSuchEffect { id: id.to_owned(), suggestions }
    })
}

impl Entry {
    /// The card, with guesses that suit the rig of the signature.
    #[must_use]
    pub fn card(&self) -> &EffectCard {
        &self.card
    }

    /// Where it can be: on a bench, on a leg, or both.
    #[must_use]
    pub fn found_on(&self) -> Vec<&'static str> {
        match &self.home {
            Home::Leg(_) => vec!["leg"],
            Home::Bench(_) if self.on_leg => vec!["bench", "leg"],
            Home::Bench(_) => vec!["bench"],
        }
    }

    /// A name that is unique among [`entries`]: the id, with `leg-` before it where a bench has an effect of the same id.
    #[must_use]
    pub fn page_name(&self) -> String {
        let unknown = Setting::unknown();
        let of_bench = || CATALOGUE.iter().any(|effect| effect.card(&unknown).id == self.card.id);
        match &self.home {
            Home::Leg(_) if of_bench() => format!("leg-{}", self.card.id),
            _ => self.card.id.clone(),
        }
    }

    /// Runs a rig with and without the effect.
    ///
    /// # Errors
    ///
    /// If it cannot be simulated.
    pub fn signature(&self) -> Result<Signature> {
        match &self.home {
            Home::Bench(rig) => bench::signature(*rig, &self.card),
            Home::Leg(place) => leg::signature(place, &self.card),
        }
    }

    /// The card as JSON has it.
    #[must_use]
    pub fn sheet(&self, signature: Option<Signature>) -> Sheet {
        let card = self.card.clone();
        let parameter = |p: Parameter| SheetParameter {
            off: p.neutral.filter(|n| n.is_finite()),
            name: p.name,
            unit: p.unit,
            guess: p.value,
            min: p.min,
            max: p.max,
        };
        Sheet {
            id: card.id,
            summary: card.summary,
            found_on: self.found_on(),
            acts_on: card.acts_on,
            equation: card.equation,
            symbols: card.symbols,
            validity: card.validity,
            reference: card.reference,
            told_apart: card.told_apart,
            cure: card.cure,
            passive: card.passive,
            contains: card.becomes.map(|law| law.id),
            parameters: card.parameters.into_iter().map(parameter).collect(),
            signature,
        }
    }
}

/// A channel's change where the effect is and where it is not.
struct Change {
    channel: String,
    unit: String,
    points: Vec<(f64, f64)>,
    /// Root mean square of the change over the channel's own.
    share: f64,
}

/// The change of every channel.
fn changes(with: &Prediction, without: &Prediction, time_s: &[f64]) -> Vec<Change> {
    let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let of = |(a, b): (&Signal, &Signal)| {
        let change: Vec<f64> = a.values.iter().zip(&b.values).map(|(a, b)| a - b).collect();
        let own = rms(&a.values).max(rms(&b.values)).max(f64::MIN_POSITIVE);
        let unit = Unit::symbol_of(&a.channel);
        Change {
            channel: a.channel.clone(),
            unit: unit.to_owned(),
            share: rms(&change) / own,
            points: time_s.iter().copied().zip(change).collect(),
        }
    };
    with.outputs.iter().zip(&without.outputs).map(of).collect()
}

/// The channel that shows an effect best, relative to its own size.
fn most_telling(changes: Vec<Change>) -> Option<Change> {
    changes.into_iter().filter(|c| c.share.is_finite()).max_by(|a, b| a.share.total_cmp(&b.share))
}

/// The values to show an effect at: the first guess, or the first starting value where the guess is neutral, or where
/// it makes the effect the simpler law that it contains.
fn shown_at(card: &EffectCard) -> Vec<f64> {
    let simpler = |i: usize| {
        let Some(law) = card.becomes.as_ref().filter(|law| law.departure == i) else { return false };
        card.parameters[i].value == law.at.value(|like| card.parameters[like].value)
    };
    let of = |(i, p): (usize, &Parameter)| {
        let idle = p.neutral == Some(p.value) || simpler(i);
        if idle { p.starts.first().copied().unwrap_or(p.value) } else { p.value }
    };
    card.parameters.iter().enumerate().map(of).collect()
}

/// The residual as a graph.
fn residual(change: Change) -> Graph {
    Graph::new(&format!("Residual of {}", change.channel), ("time", "s"), ("residual", &change.unit))
        .curve("", change.points)
}
