//! A model whose simulations can be stopped from another thread; otherwise it is the model inside, to the last bit.

use crate::{Error, Options, Result, Stop};
use sealegs_model::{Model, ModelError, Parameter, Prediction, Record};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// The search of a diagnosis, which may end before it is done.
#[derive(Debug)]
pub(crate) struct SearchEnd {
    stop: Stop,
    until: Option<Instant>,
    under_way: AtomicBool,
    cut: AtomicBool,
}

impl SearchEnd {
    /// That of a search that ends at a time at the latest, or when the options' handle says so.
    pub fn new(options: &Options, until: Option<Instant>) -> Arc<Self> {
        let (under_way, cut) = (AtomicBool::new(false), AtomicBool::new(false));
        Arc::new(Self { stop: options.stop.clone(), until, under_way, cut })
    }

    /// Says whether the search is under way now.
    pub fn set_under_way(&self, now: bool) {
        self.under_way.store(now, Ordering::Relaxed);
    }

    /// Whether it was refused a simulation.
    pub fn has_cut(&self) -> bool {
        self.cut.load(Ordering::Relaxed)
    }

    /// Whether it is over though it is under way.
    fn refuses(&self) -> bool {
        let is_late = || self.until.is_some_and(|until| Instant::now() >= until);
        let refuses = self.under_way.load(Ordering::Relaxed) && (self.stop.ends_search() || is_late());
        if refuses {
            self.cut.store(true, Ordering::Relaxed);
        }
        refuses
    }
}

/// The model of work, or of a search, that [`Stop`] ends: then no simulation is begun, and every prediction is an error.
#[derive(Debug)]
pub(crate) struct Stoppable {
    inner: Box<dyn Model>,
    stop: Stop,
    search: Option<Arc<SearchEnd>>,
}

impl Stoppable {
    pub(crate) fn new(model: &dyn Model, options: &Options) -> Self {
        Self { inner: model.clone_box(), stop: options.stop.clone(), search: None }
    }

    /// The model of a diagnosis whose search may end before it is done.
    pub(crate) fn searched(model: &dyn Model, options: &Options, search: &Arc<SearchEnd>) -> Self {
        Self { search: Some(search.clone()), ..Self::new(model, options) }
    }

    fn around(&self, inner: Box<dyn Model>) -> Box<dyn Model> {
        Box::new(Self { inner, stop: self.stop.clone(), search: self.search.clone() })
    }

    /// Counts a simulation, unless none is to be begun any more.
    fn begin(&self) -> std::result::Result<(), ModelError> {
        let refused = |reason: &str| Err(ModelError::Setup { reason: reason.to_owned() });
        if self.stop.is_stopped() {
            return refused("stopped");
        }
        if self.search.as_ref().is_some_and(|search| search.refuses()) {
            return refused("the search was ended");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_that_was_late_leaves_the_next_one_of_the_same_options_alone() {
        let options = Options::new();
        let late = SearchEnd::new(&options, Some(Instant::now()));
        // Before it is under way nothing is refused.
        assert!(!late.refuses() && !late.has_cut());
        late.set_under_way(true);
        assert!(late.refuses() && late.has_cut());
        let next = SearchEnd::new(&options, None);
        next.set_under_way(true);
        assert!(!next.refuses());
        // A handle's word is for all of its work.
        options.stop_handle().end_search();
        assert!(next.refuses() && next.has_cut());
        next.set_under_way(false);
        assert!(!next.refuses());
    }
}
