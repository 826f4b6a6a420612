//! Measured and predicted channels side by side in one recording.

/// Runs with what was measured, what the model said before and what it says after.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// The recording's name, for example the campaign's.
    pub name: String,
    /// The runs.
    pub runs: Vec<ComparedRun>,
    /// The verdict and what led to it, Markdown.
    pub summary_markdown: String,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedRun {
    /// Unique name, for example `run-03 (holdout)`.
    pub name: String,
    /// Time stamps, s, strictly increasing.
    pub time_s: Vec<f64>,
    /// The channels, each with one value per time stamp.
    pub channels: Vec<ComparedChannel>,
}

/// One channel of a run. A value that is missing is NaN and leaves a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparedChannel {
    /// The channel with its unit as suffix, for example `force_1_n`; unique in its run.
    pub name: String,
    /// Unit as printed, for example `N`.
    pub unit: String,
    /// Measured values; empty for a channel that was not measured.
    pub measured: Vec<f64>,
    /// The model before, if it predicts this channel. Its residual, measured minus this, is added.
    pub before: Option<Vec<f64>>,
    /// The model after, if there is one. Its residual is added.
    pub after: Option<Vec<f64>>,
}
