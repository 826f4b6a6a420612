//! What any model is: channels, records, parameters, effects, and the one trait that diagnosis sees.
//!
//! A [`Model`] predicts the output channels of a [`Record`] from its input channels. Everything that
//! compares models with measurements (`sealegs-sysid`) knows a model through this trait only; everything
//! that is a model (a bench, a leg) implements it.
//!
//! # Conventions
//!
//! SI units and radians everywhere; the unit is the suffix of a channel's or parameter's name
//! (`force_1_n`, `motor_angle_rad`). The actuator's axis points from link 1 (the spring side) to link 2
//! (the screw side); forces inside the actuator are positive in compression; the screw's extension
//! `y = r theta` is positive when it lengthens the actuator. A residual is measured minus predicted.

mod channel;
pub mod columns;
mod differences;
mod effect;
mod law;
mod parameter;
mod plain;
mod record;
mod wrapper;

pub use channel::{Unit, UnknownUnit};
pub use differences::{SIXTH_POWER, sixth_differences};
pub use effect::{EffectCard, Excitation, SignalRange, SimplerAt, SimplerLaw};
pub use law::{Curve, Factor, Law, Over};
pub use parameter::{Parameter, Scale};
pub use plain::plain;
pub use record::{InputHold, Prediction, Record, Signal, internal};

use std::fmt;

/// A physical model of a bench, an actuator or a leg, as diagnosis sees it.
///
/// A model is a value: [`Model::with_effect`] returns a new one and leaves the old one as it was, so that
/// sets of effects can be tried side by side and in parallel.
pub trait Model: fmt::Debug + Send + Sync {
    /// A short name for messages and reports, for example `thor-linear on the locked bench`.
    fn name(&self) -> String;

    /// The parameters, the base model's own first, then those of each included effect in the order of
    /// inclusion. An effect's parameter is called `<effect id>.<symbol>`.
    fn parameters(&self) -> &[Parameter];

    /// Names of the input channels of which a record must have exactly one, in order of preference.
    /// Empty if the model brings its own commands (a leg with a scenario).
    fn inputs(&self) -> &[&'static str];

    /// Whether the model can predict this output channel.
    fn predicts(&self, channel: &str) -> bool;

    /// Ids of the effects that are included, in the order of inclusion.
    fn included(&self) -> Vec<String>;

    /// The effects that this model could have and does not include, with parameters whose guesses suit
    /// the excitation that was seen. Scoped effects carry their place in the id:
    /// `sensor-lag@output_torque_nm`, `knee/coulomb-friction`.
    fn effects(&self, seen: &Excitation) -> Vec<EffectCard>;

    /// This model with one more effect. At the neutral values of the effect's parameters the prediction
    /// is the same as without it.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownEffect`] if the id is not one of [`Model::effects`].
    fn with_effect(&self, id: &str, seen: &Excitation) -> Result<Box<dyn Model>, ModelError>;

    /// The prediction of the named output `channels` at the record's time stamps, for parameter `values`
    /// in the order of [`Model::parameters`]. The record's own outputs are not read.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownChannel`], [`ModelError::NoInput`], or [`ModelError::NotFinite`] when the
    /// state runs away.
    fn predict(&self, values: &[f64], record: &Record, channels: &[String])
    -> Result<Prediction, ModelError>;

    /// The outputs of [`Model::predict`] alone, bit for bit: a model that saves time without internal signals and events
    /// leaves them out. For derivatives, which are most of what a fit simulates.
    ///
    /// # Errors
    ///
    /// As [`Model::predict`].
    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        self.predict(values, record, channels)
    }

    /// Whether the prediction of a record can depend on a parameter, by its place among [`Model::parameters`]. Derivatives
    /// that must be zero are then not simulated.
    fn concerns(&self, _parameter: usize, _record: &Record) -> bool {
        true
    }

    /// The places (see [`Prediction::places`]) whose signals are angular, N m and rad in place of N and m; the name of a
    /// bench's only actuator is empty. Only the model knows: a drive may have no sensor whose unit tells.
    fn rotary_places(&self) -> Vec<String> {
        Vec::new()
    }

    /// Runs that could be made on the rig, where an experiment is no input to play but a run of the rig's own: each
    /// record's name says what to do, and [`Model::predict`] knows it by that name.
    fn experiments(&self) -> Vec<Record> {
        Vec::new()
    }

    /// Whether a simulation takes so long, as a whole leg's does, or so many are needed for all parameters and places, that a
    /// search looks only at what promises most and takes derivatives no more often than it must.
    fn is_dear(&self) -> bool {
        false
    }

    /// A copy that may be quicker and less exact: it integrates with no more than about so many steps per
    /// sampling period. A search looks around with it; what it finds is fitted again and judged with the model
    /// itself. A model that has nothing to save returns an exact copy.
    fn coarser(&self, _steps_per_sample: f64) -> Box<dyn Model> {
        self.clone_box()
    }

    /// A copy with half the step, where a model's own is a compromise: how far the two predictions are apart is the error of
    /// the integration. `None` where the model's own step is converged.
    fn finer(&self) -> Option<Box<dyn Model>> {
        None
    }

    /// A copy whose simulations of these records an observer pulls to the motion that was measured there. Their
    /// predictions stay near the measurement where a force is missing, so that the residual is a smooth function of the
    /// parameters, and their internal signals `missing.PORT` ([`internal::MISSING`]) are the forces that the
    /// model lacks. `None` if the records measure no motion that this model could be pulled to.
    fn observing(&self, _records: &[&Record]) -> Option<Box<dyn Model>> {
        None
    }

    /// A copy whose simulations of these records are drawn to the measured motion so slowly that an error is forgotten after
    /// about `memory_s`, as if the run were many short ones that each begin where the log is. For models whose open-loop
    /// motion amplifies errors or adds them up, so that a whole run says as little as one sample. `None` if a run of this
    /// model needs no such thing, or the records measure no motion to be drawn to.
    fn forgetting(&self, _records: &[&Record], _memory_s: f64) -> Option<Box<dyn Model>> {
        None
    }

    /// A copy that could have one more effect: a law that was read off a missing signal, under the id
    /// [`Law::effect`]. `None` if it has no place for such a law.
    fn knowing(&self, _law: &Law) -> Option<Box<dyn Model>> {
        None
    }

    /// A copy behind a new box.
    fn clone_box(&self) -> Box<dyn Model>;
}

impl Clone for Box<dyn Model> {
    fn clone(&self) -> Self {
        self.clone_box()
    }
}

/// Why a model could not do what it was asked.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// No effect has this id, or it is included already.
    UnknownEffect {
        /// The id that was asked for.
        id: String,
        /// The id that comes nearest to it, if one does.
        suggestion: Option<String>,
    },
    /// The model predicts no such channel.
    UnknownChannel {
        /// The channel that was asked for.
        channel: String,
    },
    /// The record has none of the model's input channels, or more than one.
    NoInput {
        /// The record's name.
        record: String,
        /// The channels of which it needs one.
        wanted: Vec<String>,
        /// Those of them that it has.
        found: Vec<String>,
    },
    /// A state or output is no longer finite.
    NotFinite {
        /// When, in the record's time, s.
        time_s: f64,
        /// What: the state's or channel's name.
        what: String,
    },
    /// A parameter value that the physics does not admit.
    BadParameter {
        /// The parameter's name.
        name: String,
        /// The value.
        value: f64,
        /// What is admitted, for example `positive`.
        admitted: &'static str,
    },
    /// What the model is made of cannot be put together with these values.
    Setup {
        /// Why, in words.
        reason: String,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownEffect { id, suggestion } => {
                write!(f, "no effect '{id}' can be added to this model")?;
                match suggestion {
                    Some(s) => write!(f, "; did you mean '{s}'?"),
                    None => Ok(()),
                }
            }
            Self::UnknownChannel { channel } => write!(f, "this model does not predict '{channel}'"),
            Self::NoInput { record, wanted, found } if found.is_empty() => {
                write!(f, "{record}: no input column; one of {} is needed", wanted.join(", "))
            }
            Self::NoInput { record, found, .. } => {
                write!(f, "{record}: two input columns at once: {}", found.join(", "))
            }
            Self::NotFinite { time_s, what } => {
                write!(f, "{what} is no longer finite at {time_s} s")
            }
            Self::BadParameter { name, value, admitted } => {
                write!(f, "{name} = {value}: must be {admitted}")
            }
            Self::Setup { reason } => f.write_str(reason),
        }
    }
}

impl std::error::Error for ModelError {}
