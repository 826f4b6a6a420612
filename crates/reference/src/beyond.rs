//! Effects that are in no catalogue: where one of them is hidden, no known effect is the right answer.

/// Something that the catalogue does not have. SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beyond {
    /// Dry friction of the rotor on one end of the screw alone, worn or dry: `F (1 + tanh((y - from) / width)) / 2`.
    RoughEnd {
        /// Bound far within it, N.
        force_n: f64,
        /// Extension at which it has half of that, m.
        from_m: f64,
        /// m.
        width_m: f64,
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
    /// Dry friction of the rotor at one place of the screw, a dent or dirt: `F exp(-((y - at) / width)^2)`.
    FrictionBump {
        /// Bound at the place itself, N.
        force_n: f64,
        /// Extension at which it is, m.
        at_m: f64,
        /// m.
        width_m: f64,
    },
    /// A spring that softens while it works, as a polymer that warms up does: `k (1 - loss (1 - exp(-t / time constant)))`.
    SofteningSpring {
        /// Ratio of the stiffness lost in the end.
        loss: f64,
        /// s.
        time_constant_s: f64,
    },
    /// A load cell on link 1 that does not feel small forces: nothing within the band, the force less the band beyond.
    DeadBandLoadCell {
        /// Half the width of the band, N.
        band_n: f64,
    },
}

/// Where something acts and what it depends on, in the words of a diagnosis' missing signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Whereabouts {
    /// The port: `command`, `rotor`, `spring`, `sensor/<channel>`; `sensor` for all sensors together.
    pub port: &'static str,
    /// What it depends on, the most telling first: `position`, `speed`, `direction`, `deflection`, `load`, `command`, `time`,
    /// `past`.
    pub depends_on: &'static [&'static str],
}

impl Beyond {
    /// Where it acts, and what it depends on.
    #[must_use]
    pub fn whereabouts(&self) -> Whereabouts {
        let (port, depends_on): (&str, &[&str]) = match self {
            Self::RoughEnd { .. } | Self::FrictionBump { .. } => ("rotor", &["position", "direction"]),
            Self::KinkedSpring { .. } => ("spring", &["deflection"]),
            Self::SofteningSpring { .. } => ("spring", &["time", "deflection"]),
            Self::HotMotor { .. } => ("command", &["time", "command"]),
            Self::DirectedGain { .. } => ("command", &["command"]),
            Self::SquareRootDamper { .. } => ("rotor", &["speed"]),
            Self::ClippedLoadCell { .. } | Self::DeadBandLoadCell { .. } => ("sensor/force_1_n", &["load"]),
            Self::DriftingBias { .. } => ("sensor/force_1_n", &["time"]),
            Self::StaleSamples { .. } => ("sensor", &["past"]),
        };
        Whereabouts { port, depends_on }
    }

    /// Name and numbers, as an answer states them.
    #[must_use]
    pub fn described(&self) -> (&'static str, Vec<(&'static str, f64)>) {
        match *self {
            Self::RoughEnd { force_n, from_m, width_m } => {
                ("rough-end", vec![("force_n", force_n), ("from_m", from_m), ("width_m", width_m)])
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
            Self::FrictionBump { force_n, at_m, width_m } => {
                ("friction-bump", vec![("force_n", force_n), ("at_m", at_m), ("width_m", width_m)])
            }
            Self::SofteningSpring { loss, time_constant_s } => {
                ("softening-spring", vec![("loss", loss), ("time_constant_s", time_constant_s)])
            }
            Self::DeadBandLoadCell { band_n } => ("dead-band-load-cell", vec![("band_n", band_n)]),
        }
    }
}
