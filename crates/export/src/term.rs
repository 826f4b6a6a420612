//! The effects of the catalogue as terms with named numbers, whichever model they come from.

use sealegs_actuator::effect::{CATALOGUE, Setting};
use sealegs_model::Parameter;

/// An effect that a model includes.
#[derive(Debug, Clone, PartialEq)]
pub struct Included {
    /// Its id, without a place.
    pub id: String,
    /// What it is.
    pub term: Term,
}

/// What an effect is; the meaning of each number is that of the effect's card (see `sealegs_actuator::effect`). SI at the
/// screw, or at the output of a rotary actuator.
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    Coulomb {
        force: f64,
    },
    Presliding {
        force: f64,
        stiffness: f64,
    },
    Stribeck {
        coulomb: f64,
        at_rest: f64,
        velocity: f64,
    },
    LoadFriction {
        coefficient: f64,
    },
    DirectedFriction {
        force: f64,
        asymmetry: f64,
    },
    /// Friction by the load, with one coefficient while driving it and another while driven by it.
    ByPower {
        driving: f64,
        driven: f64,
    },
    /// Friction that falls by a share as its own heat warms it.
    Warming {
        force: f64,
        fall: f64,
        energy_j: f64,
    },
    Drag {
        coefficient: f64,
    },
    Ripple {
        amplitude: f64,
        cycles: f64,
        phase: f64,
    },
    CommandLimit {
        limit: f64,
    },
    VoltageLimit {
        bus: f64,
        resistance: f64,
    },
    Delay {
        delay_s: f64,
    },
    Quantisation {
        count: f64,
        rounding: f64,
    },
    Hardening {
        cubic: f64,
    },
    SpringDamping {
        damping: f64,
    },
    SpringSlip {
        stiffness: f64,
        force: f64,
    },
    Backlash {
        gap: f64,
    },
    Series {
        stiffness: f64,
        mass: f64,
    },
    /// Of a drive without a spring: what lies between its rotor and its load.
    Transmission,
    Mode {
        frequency_hz: f64,
        ratio: f64,
        participation: f64,
    },
    SensorLag {
        channel: Option<String>,
        cutoff_hz: f64,
    },
    SensorDelay {
        channel: Option<String>,
        delay_s: f64,
    },
    OutputFriction {
        torque: f64,
    },
    /// A constant force on the output, N or N m.
    OutputOffset {
        force: f64,
    },
    /// A spring beside the output, slack at `rest`.
    Cable {
        stiffness: f64,
        rest: f64,
    },
    /// The motor gives so much more than it is told.
    Strength {
        ratio: f64,
    },
    /// Another load: written as the lever's mass and length.
    Load,
    /// A duty below which the bridge gives no voltage.
    DeadZone {
        duty: f64,
    },
    /// The supply's own resistance.
    Sag {
        resistance: f64,
    },
    /// Age of the position that a servo's loop sees, beside what its file says.
    FeedbackDelay,
    Wobbling {
        mass: f64,
        radius: f64,
        frequency_hz: f64,
        ratio: f64,
    },
    Own(OwnLaw),
    /// A dry friction of the rotor by its bound, an expression of extension, speed and load.
    Bound {
        expression: String,
    },
    /// One that no writer knows.
    Unknown,
}

/// A law that a user wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnLaw {
    /// `rotor`, `drive`, `spring` or `output`.
    pub acts_on: String,
    /// The expression.
    pub law: String,
    /// Its parameters.
    pub parameters: Vec<(String, f64)>,
}

/// Words that Python keeps for itself, and that an expression may use as names.
const PYTHON_WORDS: [&str; 35] = [
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue", "def",
    "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import", "in", "is",
    "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "try", "while", "with", "yield",
];

impl Term {
    /// The term of an effect's id (without a place), with its parameters in the order of its card and, for a user's own
    /// effect, its definition.
    pub fn of(id: &str, parameters: &[(String, f64)], definition: Option<&toml::Table>) -> Self {
        if let Some(own) = definition.map(|d| Self::own(d, parameters)) {
            return own;
        }
        let (family, channel) = id.split_once('@').map_or((id, None), |(f, c)| (f, Some(c.to_owned())));
        let values: Vec<f64> = parameters.iter().map(|p| p.1).collect();
        match (family, values.as_slice()) {
            ("coulomb-friction", &[force]) => Self::Coulomb { force },
            ("presliding-friction", &[force, stiffness]) => Self::Presliding { force, stiffness },
            ("stribeck-friction", &[coulomb, at_rest, velocity]) => {
                Self::Stribeck { coulomb, at_rest: at_rest.max(coulomb), velocity }
            }
            ("load-dependent-friction", &[coefficient]) => Self::LoadFriction { coefficient },
            ("direction-dependent-friction", &[force, asymmetry]) => {
                Self::DirectedFriction { force, asymmetry }
            }
            ("directional-efficiency", &[driving, driven]) => Self::ByPower { driving, driven },
            ("warming-friction", &[force, fall, energy_j]) => Self::Warming { force, fall, energy_j },
            ("quadratic-drag", &[coefficient]) => Self::Drag { coefficient },
            ("torque-ripple", &[amplitude, cycles, phase]) => Self::Ripple { amplitude, cycles, phase },
            ("current-saturation", &[limit]) => Self::CommandLimit { limit },
            ("voltage-saturation", &[bus, resistance]) => Self::VoltageLimit { bus, resistance },
            ("transport-delay", &[delay_s]) => Self::Delay { delay_s },
            ("command-quantisation", &[count, rounding]) => Self::Quantisation { count, rounding },
            ("hardening-spring", &[cubic]) => Self::Hardening { cubic },
            ("spring-damping", &[damping]) => Self::SpringDamping { damping },
            ("spring-hysteresis", &[stiffness, force]) => Self::SpringSlip { stiffness, force },
            ("backlash", &[gap]) => Self::Backlash { gap },
            ("series-compliance", &[_, _]) if parameters[1].0 == "damping_ratio" => Self::Transmission,
            ("series-compliance", &[stiffness, mass]) => Self::Series { stiffness, mass },
            ("backlash", &[_, _]) => Self::Transmission,
            ("structural-mode", &[frequency_hz, ratio, participation]) => {
                Self::Mode { frequency_hz, ratio, participation }
            }
            ("sensor-lag", &[cutoff_hz]) => Self::SensorLag { channel, cutoff_hz },
            ("sensor-delay", &[delay_s]) => Self::SensorDelay { channel, delay_s },
            ("output-friction", &[torque]) => Self::OutputFriction { torque },
            ("output-offset", &[force]) => Self::OutputOffset { force },
            ("cable-stiffness", &[stiffness, rest]) => Self::Cable { stiffness, rest },
            ("motor-strength", &[ratio]) => Self::Strength { ratio },
            ("load-mismatch", &[_, _]) => Self::Load,
            ("pwm-dead-zone", &[duty]) => Self::DeadZone { duty },
            ("supply-sag", &[resistance]) => Self::Sag { resistance },
            ("feedback-delay", &[_]) => Self::FeedbackDelay,
            ("wobbling-mass", &[mass, radius, frequency_hz, ratio]) => {
                Self::Wobbling { mass, radius, frequency_hz, ratio }
            }
            _ => Self::of_catalogue(family, &values),
        }
    }

    /// What the catalogue itself says of an effect for which no writer has an element of its own.
    fn of_catalogue(id: &str, values: &[f64]) -> Self {
        let setting = Setting::unknown();
        let known = CATALOGUE.iter().find(|effect| effect.card(&setting).id == id);
        let bound = known
            .filter(|effect| effect.card(&setting).parameters.len() == values.len())
            .and_then(|effect| effect.friction_bound(values));
        bound.map_or(Self::Unknown, |expression| Self::Bound { expression })
    }

    fn own(definition: &toml::Table, parameters: &[(String, f64)]) -> Self {
        let said = |key: &str| definition.get(key).and_then(toml::Value::as_str).map(str::to_owned);
        let (Some(acts_on), Some(law)) = (said("acts-on"), said("law")) else { return Self::Unknown };
        if parameters.iter().any(|(name, _)| PYTHON_WORDS.contains(&name.as_str())) {
            return Self::Unknown;
        }
        Self::Own(OwnLaw { acts_on, law, parameters: parameters.to_vec() })
    }

    /// The greatest dry friction of the rotor at rest, where the term is one; of a friction that grows with the load none.
    pub fn dry_friction(&self) -> Option<f64> {
        match *self {
            Self::Coulomb { force } => Some(force),
            Self::Stribeck { at_rest, .. } => Some(at_rest),
            Self::Warming { force, .. } => Some(force),
            Self::LoadFriction { .. } | Self::ByPower { .. } | Self::Bound { .. } => Some(0.0),
            Self::DirectedFriction { force, asymmetry } => Some(force * (1.0 + asymmetry.abs())),
            _ => None,
        }
    }
}

impl OwnLaw {
    /// The expression as Python writes it.
    pub fn python(&self) -> String {
        python(&self.law)
    }
}

/// An expression of a law as Python writes it.
pub fn python(law: &str) -> String {
    law.replace('^', "**")
}

/// The parameters of one effect by its own names, out of a model's parameters and their `values`.
pub fn parameters_of(id: &str, all: &[Parameter], values: &[f64]) -> Vec<(String, f64)> {
    let own =
        |p: &Parameter| p.name.strip_prefix(id).and_then(|rest| rest.strip_prefix('.')).map(str::to_owned);
    all.iter().zip(values).filter_map(|(p, value)| own(p).map(|name| (name, *value))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Effects for which the writers have elements of their own. Any other of the catalogue is written by its
    /// [`Effect::friction_bound`](sealegs_actuator::effect::Effect::friction_bound), or noted as lost.
    const NAMED: [&str; 30] = [
        "coulomb-friction",
        "presliding-friction",
        "stribeck-friction",
        "load-dependent-friction",
        "direction-dependent-friction",
        "directional-efficiency",
        "warming-friction",
        "quadratic-drag",
        "torque-ripple",
        "current-saturation",
        "voltage-saturation",
        "pwm-dead-zone",
        "supply-sag",
        "transport-delay",
        "feedback-delay",
        "command-quantisation",
        "hardening-spring",
        "spring-damping",
        "spring-hysteresis",
        "backlash",
        "series-compliance",
        "structural-mode",
        "sensor-lag",
        "sensor-delay",
        "output-friction",
        "output-offset",
        "cable-stiffness",
        "motor-strength",
        "load-mismatch",
        "wobbling-mass",
    ];

    #[test]
    fn every_effect_is_written_with_as_many_parameters_as_its_card_has() {
        let mut named = Vec::new();
        for effect in CATALOGUE {
            let card = effect.card(&Setting::unknown());
            let parameters: Vec<(String, f64)> =
                card.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
            let values: Vec<f64> = parameters.iter().map(|p| p.1).collect();
            let term = Term::of(&card.id, &parameters, None);
            match effect.friction_bound(&values) {
                Some(expression) => assert_eq!(term, Term::Bound { expression }, "{}", card.id),
                None if NAMED.contains(&card.id.as_str()) => assert_ne!(term, Term::Unknown, "{}", card.id),
                None => assert_eq!(term, Term::Unknown, "{}", card.id),
            }
            named.push(card.id);
        }
        let loaded = Setting { has_spring: false, has_load: true, ..Setting::unknown() };
        for effect in CATALOGUE.iter().map(|e| e.card(&loaded)).filter(|c| c.acts_on == "transmission") {
            let parameters: Vec<(String, f64)> =
                effect.parameters.iter().map(|p| (p.name.clone(), p.value)).collect();
            assert!(matches!(Term::of(&effect.id, &parameters, None), Term::Transmission), "{}", effect.id);
        }
        assert!(NAMED.iter().all(|id| named.iter().any(|n| n == id)));
    }

    #[test]
    fn a_law_of_the_users_own_becomes_python() {
        let text = "id = \"a\"\nacts-on = \"rotor\"\nlaw = \"c*y_dot^2\"";
        let definition: toml::Table = toml::from_str(text).unwrap();
        let of = |name: &str| Term::of("a", &[(name.to_owned(), 2.0)], Some(&definition));
        let Term::Own(own) = of("c") else { panic!("not known") };
        assert_eq!((own.acts_on.as_str(), own.python().as_str()), ("rotor", "c*y_dot**2"));
        assert_eq!(of("lambda"), Term::Unknown);
    }
}
