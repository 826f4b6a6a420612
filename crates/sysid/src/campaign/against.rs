//! Whether a model can predict a campaign's runs.

use super::{Campaign, table};
use crate::Error;
use sealegs_model::{Model, Signal};

impl Campaign {
    /// Checks that a model can predict every run: one input column that it takes and at least one output
    /// column that it predicts. Returns a line for each recorded output column that it does not predict.
    ///
    /// # Errors
    ///
    /// [`Error::BadFile`] naming the run's file and its header.
    pub fn check_against(&self, model: &dyn Model) -> Result<Vec<String>, Error> {
        let mut notes = Vec::new();
        for run in &self.runs {
            let bad = |problem: String| Error::bad(&run.path, table::header_of(&run.path), None, problem);
            let wanted = model.inputs();
            let found: Vec<&str> =
                run.record.inputs.iter().map(|s| s.channel.as_str()).filter(|c| wanted.contains(c)).collect();
            if !wanted.is_empty() && found.is_empty() {
                let found = names(&run.record.inputs);
                let found = found.map_or_else(String::new, |names| format!(" (found: {names})"));
                let wanted = wanted.join(" or ");
                return Err(bad(format!(
                    "no input column that {} takes{found}; it needs {wanted}",
                    model.name()
                )));
            }
            if !wanted.is_empty() && found.len() > 1 {
                return Err(bad(format!("two input columns at once: {}", found.join(", "))));
            }
            let outputs = &run.record.outputs;
            if !outputs.iter().any(|s| model.predicts(&s.channel)) {
                let found = names(outputs).unwrap_or_else(|| "none".to_owned());
                return Err(bad(format!(
                    "no output column that {} can predict (found: {found})",
                    model.name()
                )));
            }
            for signal in outputs.iter().filter(|s| !model.predicts(&s.channel)) {
                notes.push(format!(
                    "{}: column '{}' is not predicted by {}; it is kept, and compared with nothing",
                    run.record.name,
                    signal.channel,
                    model.name()
                ));
            }
        }
        Ok(notes)
    }
}

/// The names of some columns; none of none.
fn names(signals: &[Signal]) -> Option<String> {
    let names: Vec<&str> = signals.iter().map(|s| s.channel.as_str()).collect();
    (!names.is_empty()).then(|| names.join(", "))
}
