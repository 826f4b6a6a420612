//! A model whose simulations can be stopped from another thread; otherwise it is the model inside, to the last bit.

use crate::{Error, Options, Result, Stop};
use sealegs_model::{EffectCard, Excitation, Law, Model, ModelError, Parameter, Prediction, Record};

/// The model of work that [`Stop`] ends: then no simulation is begun, and every prediction is an error.
#[derive(Debug)]
pub(crate) struct Stoppable {
    inner: Box<dyn Model>,
    stop: Stop,
}

impl Stoppable {
    pub(crate) fn new(model: &dyn Model, options: &Options) -> Self {
        Self { inner: model.clone_box(), stop: options.stop.clone() }
    }

    fn around(&self, inner: Box<dyn Model>) -> Box<dyn Model> {
        Box::new(Self { inner, stop: self.stop.clone() })
    }
}

impl Model for Stoppable {
    fn name(&self) -> String {
        self.inner.name()
    }

    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn inputs(&self) -> &[&'static str] {
        self.inner.inputs()
    }

    fn predicts(&self, channel: &str) -> bool {
        self.inner.predicts(channel)
    }

    fn included(&self) -> Vec<String> {
        self.inner.included()
    }

    fn effects(&self, seen: &Excitation) -> Vec<EffectCard> {
        self.inner.effects(seen)
    }

    fn with_effect(&self, id: &str, seen: &Excitation) -> std::result::Result<Box<dyn Model>, ModelError> {
        self.inner.with_effect(id, seen).map(|model| self.around(model))
    }

    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> std::result::Result<Prediction, ModelError> {
        if self.stop.is_stopped() {
            return Err(ModelError::Setup { reason: "stopped".to_owned() });
        }
        self.stop.count();
        self.inner.predict(values, record, channels)
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> std::result::Result<Prediction, ModelError> {
        if self.stop.is_stopped() {
            return Err(ModelError::Setup { reason: "stopped".to_owned() });
        }
        self.stop.count();
        self.inner.predict_outputs(values, record, channels)
    }

    fn concerns(&self, parameter: usize, record: &Record) -> bool {
        self.inner.concerns(parameter, record)
    }

    fn experiments(&self) -> Vec<Record> {
        self.inner.experiments()
    }

    fn coarser(&self, steps_per_sample: f64) -> Box<dyn Model> {
        self.around(self.inner.coarser(steps_per_sample))
    }

    fn observing(&self, records: &[&Record]) -> Option<Box<dyn Model>> {
        self.inner.observing(records).map(|model| self.around(model))
    }

    fn forgetting(&self, records: &[&Record], memory_s: f64) -> Option<Box<dyn Model>> {
        self.inner.forgetting(records, memory_s).map(|model| self.around(model))
    }

    fn knowing(&self, law: &Law) -> Option<Box<dyn Model>> {
        self.inner.knowing(law).map(|model| self.around(model))
    }

    fn clone_box(&self) -> Box<dyn Model> {
        self.around(self.inner.clone_box())
    }
}

/// The result of work that may have been stopped: whatever came of it then is no result.
pub(crate) fn unless_stopped<T, E: Into<Error>>(
    options: &Options,
    done: std::result::Result<T, E>,
) -> Result<T> {
    if options.stop.is_stopped() { Err(Error::Stopped) } else { done.map_err(Into::into) }
}
