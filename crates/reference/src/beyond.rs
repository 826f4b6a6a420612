//! Effects that are in no catalogue: where one of them is hidden, no known effect is the right answer.

/// Something that the catalogue does not have. SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beyond {
    /// Dry friction of the rotor that comes and goes along the screw: `F (1 + sin(2 pi y / period))`.
    PositionFriction {
        /// Mean bound, N.
        force_n: f64,
        /// Travel after which it repeats, m.
        period_m: f64,
    },
    /// A spring that is stiffer beyond a deflection, in compression only: `+ ratio k (delta - from)`.
    KinkedSpring {
        /// m.
        from_m: f64,
        /// Additional stiffness as a ratio of the spring's.
        ratio: f64,
    },
    /// The torque constant falls as the motor warms up: `1 - fall (1 - exp(-t / time constant))`.
    HotMotor {
        /// Ratio lost in the end.
        fall: f64,
        /// s.
        time_constant_s: f64,
    },
    /// Resistance of the rotor by the square root of the speed: `c sqrt(abs(y')) sign(y')`.
    SquareRootDamper {
        /// N (s/m)^(1/2).
        coefficient: f64,
    },
    /// The drive gives more one way than the other: `1 + ratio sign(I)`.
    DirectedGain {
        /// Half the difference between the two gains.
        ratio: f64,
    },
    /// A load cell on link 1 that shows no more than its range.
    ClippedLoadCell {
        /// N.
        limit_n: f64,
    },
    /// A load cell on link 1 whose zero swings slowly: `A sin(2 pi t / period)`.
    DriftingBias {
        /// N.
        amplitude_n: f64,
        /// s.
        period_s: f64,
    },
    /// A logger that loses samples and writes the last ones again, in bursts of up to 8 rows.
    StaleSamples {
        /// Share of the rows that are not new.
        share: f64,
    },
}

impl Beyond {
    /// Name and numbers, as an answer states them.
    #[must_use]
    pub fn described(&self) -> (&'static str, Vec<(&'static str, f64)>) {
        match *self {
            Self::PositionFriction { force_n, period_m } => {
                ("position-dependent-friction", vec![("force_n", force_n), ("period_m", period_m)])
            }
            Self::KinkedSpring { from_m, ratio } => {
                ("kinked-spring", vec![("from_m", from_m), ("ratio", ratio)])
            }
            Self::HotMotor { fall, time_constant_s } => {
                ("hot-motor", vec![("fall", fall), ("time_constant_s", time_constant_s)])
            }
            Self::SquareRootDamper { coefficient } => {
                ("square-root-damper", vec![("coefficient_n_s05_m05", coefficient)])
            }
            Self::DirectedGain { ratio } => ("directed-gain", vec![("ratio", ratio)]),
            Self::ClippedLoadCell { limit_n } => ("clipped-load-cell", vec![("limit_n", limit_n)]),
            Self::DriftingBias { amplitude_n, period_s } => {
                ("drifting-bias", vec![("amplitude_n", amplitude_n), ("period_s", period_s)])
            }
            Self::StaleSamples { share } => ("stale-samples", vec![("share", share)]),
        }
    }
}
