//! What is rough about a log: how real benches are recorded, apart from anything that is hidden in them.

use super::draws::Draws;

/// A roughness of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rough {
    /// The loop that commands and reads runs at 100 to 250 Hz.
    SlowLogger,
    /// The load cell of link 2 is missing.
    OneLoadCell,
    /// The campaign file states no noise.
    NoStatedNoise,
    /// 0.3 % of the rows of a load cell are off by some hundred newton.
    Spikes,
    /// 3 % of the rows repeat the row before, up to 8 at a time.
    RepeatedRows,
    /// Encoders of 64 counts a turn at the rotor and 1024 at the joint.
    CoarseEncoders,
    /// A seventh of the usual command.
    WeakExcitation,
    /// One run to fit on, not two.
    OneFitRun,
    /// Sensors are read half a period after the command went out, under the same time stamp.
    HalfPeriodLate,
}

/// Rates of a slow loop, Hz: each is a whole number of the integrator's steps.
const SLOW_HZ: [f64; 4] = [100.0, 125.0, 200.0, 250.0];

impl Rough {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::SlowLogger,
        Self::OneLoadCell,
        Self::NoStatedNoise,
        Self::Spikes,
        Self::RepeatedRows,
        Self::CoarseEncoders,
        Self::WeakExcitation,
        Self::OneFitRun,
        Self::HalfPeriodLate,
    ];

    /// The name in an answer.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::SlowLogger => "slow-logger",
            Self::OneLoadCell => "one-load-cell",
            Self::NoStatedNoise => "no-stated-noise",
            Self::Spikes => "spikes",
            Self::RepeatedRows => "repeated-rows",
            Self::CoarseEncoders => "coarse-encoders",
            Self::WeakExcitation => "weak-excitation",
            Self::OneFitRun => "one-fit-run",
            Self::HalfPeriodLate => "half-period-late",
        }
    }

    /// Whether it is dirt on a log that says the same without it. What is left decides how much of an effect can be seen.
    #[must_use]
    pub fn is_dirt(self) -> bool {
        matches!(self, Self::NoStatedNoise | Self::Spikes | Self::RepeatedRows | Self::HalfPeriodLate)
    }

    /// One or two of them.
    #[must_use]
    pub fn drawn(draws: &mut Draws) -> Vec<Self> {
        let first = draws.one_of(&Self::ALL);
        let second = draws.one_of(&Self::ALL);
        if first == second { vec![first] } else { vec![first, second] }
    }

    /// Rows a second of a log with these, by a seed.
    #[must_use]
    pub fn rate_hz(of: &[Self], seed: u64) -> f64 {
        if of.contains(&Self::SlowLogger) { Draws::of(seed, "rate").one_of(&SLOW_HZ) } else { super::RATE_HZ }
    }
}
