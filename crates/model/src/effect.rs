//! The card of a physical effect: what it is, where it acts, its law and its parameters.

use crate::Parameter;

/// What a person and a search need to know of an effect before trying it.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCard {
    /// Unique id in files, on the command line and in reports, with its place where it is scoped.
    pub id: String,
    /// One line: what happens physically.
    pub summary: String,
    /// Where it acts: `rotor`, `drive`, `spring`, `spring path`, `screw side`, `force path`, `sensor`,
    /// `output joint`, `output link`, `foot`, `link`.
    pub acts_on: String,
    /// The law as an equation in plain text, with the symbols of the catalogue.
    pub equation: String,
    /// Sign and validity, one or two sentences.
    pub validity: String,
    /// Where the law comes from.
    pub reference: String,
    /// The equation's symbols: `F_c: force; y': speed of the screw`, parameters by their names without a unit.
    pub symbols: String,
    /// How data tell it from the effects that look like it, and which experiment shows the difference.
    pub told_apart: String,
    /// What is usually done about it.
    pub cure: String,
    /// Its parameters with guesses that suit the excitation seen. A parameter called [`EffectCard::PHASE`] says that the
    /// effect is periodic: a negative amplitude is the same as a positive one half a turn on.
    pub parameters: Vec<Parameter>,
    /// Whether it can only take mechanical energy out or store it.
    pub passive: bool,
    /// A simpler law that it becomes at certain values of its parameters.
    pub becomes: Option<SimplerLaw>,
}

impl EffectCard {
    /// The parameter that makes an effect periodic.
    pub const PHASE: &'static str = "phase_rad";

    /// How the parameter is called, up to its unit, after which an effect repeats.
    pub const PERIOD: &'static str = "period";

    /// How the parameter is called, up to its unit, that says where such a period begins: places a period apart are the same.
    pub const PLACE: &'static str = "place";

    /// How the parameter is called that says how often an effect repeats in a turn of the rotor.
    pub const CYCLES: &'static str = "cycles_per_rev";

    /// Whether the effect repeats with some coordinate; see [`EffectCard::parameters`].
    #[must_use]
    pub fn is_periodic(&self) -> bool {
        self.parameters.iter().any(|p| p.name == Self::PHASE || p.name.starts_with(Self::PERIOD))
    }
}

/// A law that another one contains. Its parameters are the richer law's first ones, in the same order and units.
#[derive(Debug, Clone, PartialEq)]
pub struct SimplerLaw {
    /// The simpler effect's id without a place.
    pub id: &'static str,
    /// Place among [`EffectCard::parameters`] of the one that says how far the two laws are apart.
    pub departure: usize,
    /// What that one is for the simpler law.
    pub at: SimplerAt,
    /// Id, without a place, of the effect that makes up the departure beside the simpler law, where one does.
    pub beside: Option<&'static str>,
}

/// What a parameter of a richer law is where that is the simpler one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SimplerAt {
    /// Zero.
    Zero,
    /// What the parameter at this place is.
    Equal(usize),
    /// Beyond any bound: what yields no longer.
    Infinity,
}

impl SimplerAt {
    /// Its value there, given that of the parameter at a place.
    #[must_use]
    pub fn value(self, of: impl Fn(usize) -> f64) -> f64 {
        match self {
            Self::Zero => 0.0,
            Self::Equal(place) => of(place),
            Self::Infinity => f64::INFINITY,
        }
    }
}

/// Least, greatest and root-mean-square value of one signal over the runs at hand.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalRange {
    /// The signal's name with unit suffix.
    pub name: String,
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

impl SignalRange {
    /// Greatest magnitude.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.min.abs().max(self.max.abs())
    }
}

/// What the runs at hand measured and how hard they drove the model: effects choose their guesses by it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Excitation {
    /// The measured output channels.
    pub measured: Vec<String>,
    /// Ranges of the inputs, of the predicted outputs and of the internal signals of the base model.
    pub ranges: Vec<SignalRange>,
    /// Median sampling period, s.
    pub sample_period_s: f64,
}

impl Excitation {
    /// The range of a signal, if it is known.
    #[must_use]
    pub fn range(&self, name: &str) -> Option<&SignalRange> {
        self.ranges.iter().find(|r| r.name == name)
    }

    /// The greatest magnitude of a signal, or `otherwise` where nothing is known of it.
    #[must_use]
    pub fn peak_or(&self, name: &str, otherwise: f64) -> f64 {
        self.range(name).map(SignalRange::peak).filter(|p| *p > 0.0).unwrap_or(otherwise)
    }
}
