//! Random numbers by a seed and a topic, so that what is drawn for one thing never moves another.

use sealegs_actuator::excitation::{gaussian, uniform};

/// A stream of numbers of its own.
#[derive(Debug, Clone)]
pub struct Draws {
    seed: u64,
    next: u64,
}

impl Draws {
    /// The stream of a topic: its name is mixed into the seed (FNV-1a).
    #[must_use]
    pub fn of(seed: u64, topic: &str) -> Self {
        let hash = topic
            .bytes()
            .fold(0xCBF2_9CE4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01B3));
        Self { seed: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ hash, next: 0 }
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.next += 1;
        low + (high - low) * uniform(self.seed, self.next)
    }

    /// As likely in every octave; both bounds positive.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// One of several.
    pub fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.between(0.0, of.len() as f64) as usize).min(of.len() - 1)]
    }

    /// A seed for something else.
    pub fn seed(&mut self) -> u64 {
        self.next += 1;
        uniform(self.seed, self.next).to_bits()
    }

    /// A standard normal number; its stream is apart from the uniform ones.
    pub fn normal(&mut self) -> f64 {
        self.next += 1;
        gaussian(!self.seed, self.next as i64)
    }
}
