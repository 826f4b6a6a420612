//! A model whose simulations can be stopped from another thread; otherwise it is the model inside, to the last bit.

use crate::{Error, Options, Result, Stop};
use sealegs_model::{Model, ModelError, Parameter, Prediction, Record};

/// The model of work, or of a search, that [`Stop`] ends: then no simulation is begun, and every prediction is an error.
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

    /// Counts a simulation, unless none is to be begun any more.
    fn begin(&self) -> std::result::Result<(), ModelError> {
        if let Some(reason) = self.stop.refuses() {
            return Err(ModelError::Setup { reason: reason.to_owned() });
        }
        self.stop.count();
        Ok(())
    }
}

impl Model for Stoppable {
    sealegs_model::passes_on_to_inner!();

    fn name(&self) -> String {
        self.inner.name()
    }

    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> std::result::Result<Prediction, ModelError> {
        self.begin()?;
        self.inner.predict(values, record, channels)
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> std::result::Result<Prediction, ModelError> {
        self.begin()?;
        self.inner.predict_outputs(values, record, channels)
    }

    fn concerns(&self, parameter: usize, record: &Record) -> bool {
        self.inner.concerns(parameter, record)
    }
}

/// The result of work that may have been stopped: whatever came of it then is no result.
pub(crate) fn unless_stopped<T, E: Into<Error>>(
    options: &Options,
    done: std::result::Result<T, E>,
) -> Result<T> {
    if options.stop.is_stopped() { Err(Error::Stopped) } else { done.map_err(Into::into) }
}
