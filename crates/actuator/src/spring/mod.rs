//! Springs as physics: what stiffness a beam has at its setting, and what it can bear.

mod constant;
mod end_loaded_beam;
mod file;
mod limits;
mod material;
mod moment_loaded_beam;
mod softer_than_designed;

pub use constant::{ConstantSpring, TorsionSpring};
pub use end_loaded_beam::{BeamLaw, EndLoadedBeam};
pub use limits::{LimitEvent, LimitKind, LimitWatch, OverLimit, SpringLimits};
pub use material::Material;
pub use moment_loaded_beam::{ClampSetting, MomentLoadedBeam};
pub use softer_than_designed::{Hypothesis, SeriesAndScale, SofterThanDesigned};

use serde::Serialize;

use crate::ActuatorError;
use crate::text::nearest;

/// The spring of an actuator, as its file describes it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum Spring {
    /// None: the drive is rigid.
    None,
    /// A number, N/m.
    Constant(ConstantSpring),
    /// A number, N m/rad, for a rotary actuator.
    Torsion(TorsionSpring),
    /// A cantilever with a movable pivot (SAFFiR).
    EndLoadedBeam(EndLoadedBeam),
    /// A beam under a moment (THOR).
    MomentLoadedBeam(MomentLoadedBeam),
}

impl Spring {
    /// Stiffness at the present setting, N/m (N m/rad for a torsion spring); infinite where there is none.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        match self {
            Self::None => f64::INFINITY,
            Self::Constant(spring) => spring.stiffness_n_m,
            Self::Torsion(spring) => spring.stiffness_nm_rad,
            Self::EndLoadedBeam(beam) => beam.stiffness_n_m(),
            Self::MomentLoadedBeam(beam) => beam.stiffness_n_m(),
        }
    }

    /// The present setting as [`Spring::with_setting`] takes it: `stiff`, `70 mm`, `655000`. Lengths are rounded to
    /// 0.1 um.
    #[must_use]
    pub fn setting(&self) -> String {
        // Through a rounded number, so that 70 mm does not read 70.0000.
        let millimetres = |metres: f64| format!("{} mm", (1e7 * metres).round() * 1e-4);
        match self {
            Self::None => "none".to_owned(),
            Self::Constant(spring) => spring.stiffness_n_m.to_string(),
            Self::Torsion(spring) => spring.stiffness_nm_rad.to_string(),
            Self::EndLoadedBeam(beam) => millimetres(beam.pivot_m),
            Self::MomentLoadedBeam(beam) => match beam.setting {
                ClampSetting::Compliant => "compliant".to_owned(),
                ClampSetting::Stiff => "stiff".to_owned(),
                ClampSetting::LockedOut => "locked-out".to_owned(),
                ClampSetting::Length(metres) => millimetres(metres),
            },
        }
    }

    /// What [`Spring::with_setting`] takes, in words.
    #[must_use]
    pub fn settings(&self) -> &'static str {
        match self {
            Self::None => "no setting: there is no spring",
            Self::Constant(_) => "a stiffness in N/m",
            Self::Torsion(_) => "a stiffness in N m/rad",
            Self::EndLoadedBeam(_) => "a pivot position such as '70mm' or 0.070 (m)",
            Self::MomentLoadedBeam(_) => {
                "compliant, stiff, locked-out, or a free length such as '80mm' or 0.080 (m)"
            }
        }
    }

    /// The same spring at another setting: a name, a length in metres or with `mm`, or a stiffness for a
    /// spring that is a number.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::UnknownSetting`] with the nearest name; [`ActuatorError::Value`] for a number that is
    /// not positive.
    pub fn with_setting(&self, setting: &str) -> Result<Self, ActuatorError> {
        let number = || {
            let number = parse_length(setting).ok_or_else(|| ActuatorError::UnknownSetting {
                setting: setting.to_owned(),
                suggestion: match self {
                    Self::MomentLoadedBeam(_) => nearest(setting, ["compliant", "stiff", "locked-out"]),
                    _ => None,
                },
                takes: self.settings().to_owned(),
            })?;
            if number > 0.0 && number.is_finite() {
                Ok(number)
            } else {
                Err(ActuatorError::value("spring setting", setting, "positive and finite"))
            }
        };
        Ok(match self {
            Self::None => {
                return Err(ActuatorError::value("spring setting", setting, "absent: there is no spring"));
            }
            Self::Constant(_) => Self::Constant(ConstantSpring { stiffness_n_m: number()? }),
            Self::Torsion(_) => Self::Torsion(TorsionSpring { stiffness_nm_rad: number()? }),
            Self::EndLoadedBeam(beam) => {
                let pivot_m = number()?;
                if pivot_m > beam.total_length_m {
                    return Err(ActuatorError::value(
                        "spring setting",
                        setting,
                        format!("at most the beam's length, {} m", beam.total_length_m),
                    ));
                }
                Self::EndLoadedBeam(EndLoadedBeam { pivot_m, ..beam.clone() })
            }
            Self::MomentLoadedBeam(beam) => {
                let setting = match setting {
                    "compliant" | "soft" => ClampSetting::Compliant,
                    "stiff" => ClampSetting::Stiff,
                    "locked-out" => ClampSetting::LockedOut,
                    _ => ClampSetting::Length(number()?),
                };
                Self::MomentLoadedBeam(MomentLoadedBeam { setting, ..beam.clone() })
            }
        })
    }

    /// The same spring, set so that it has this stiffness (N/m or N m/rad): the inverse of
    /// [`Spring::stiffness`].
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] if it is not positive, [`ActuatorError::StiffnessOutOfReach`] if no setting
    /// gives it. A setting outside the beam's range is an answer, with [`SpringLimits::static_finding`].
    pub fn with_stiffness(&self, stiffness: f64) -> Result<Self, ActuatorError> {
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            return Err(ActuatorError::value("stiffness", stiffness, "positive and finite"));
        }
        Ok(match self {
            Self::None => {
                return Err(ActuatorError::value("stiffness", stiffness, "absent: there is no spring"));
            }
            Self::Constant(_) => Self::Constant(ConstantSpring { stiffness_n_m: stiffness }),
            Self::Torsion(_) => Self::Torsion(TorsionSpring { stiffness_nm_rad: stiffness }),
            Self::EndLoadedBeam(beam) => {
                let pivot_m = beam.pivot_for_stiffness_m(stiffness)?;
                if pivot_m > beam.total_length_m {
                    return Err(ActuatorError::StiffnessOutOfReach {
                        stiffness_n_m: stiffness,
                        least_n_m: beam.stiffness_by(beam.law, beam.total_length_m),
                        greatest_n_m: f64::INFINITY,
                    });
                }
                Self::EndLoadedBeam(EndLoadedBeam { pivot_m, ..beam.clone() })
            }
            Self::MomentLoadedBeam(beam) => {
                let setting = ClampSetting::Length(beam.length_for_stiffness_m(stiffness)?);
                Self::MomentLoadedBeam(MomentLoadedBeam { setting, ..beam.clone() })
            }
        })
    }

    /// Greatest bending stress at a force, Pa; `None` for a spring that is only a number.
    #[must_use]
    pub fn stress_pa(&self, force_n: f64) -> Option<f64> {
        match self {
            Self::None | Self::Constant(_) | Self::Torsion(_) => None,
            Self::EndLoadedBeam(beam) => Some(beam.stress_pa(force_n)),
            Self::MomentLoadedBeam(beam) => Some(beam.stress_pa(force_n)),
        }
    }

    /// What the spring can bear, with the actuator's rated peak force (N, or N m) if it has one.
    #[must_use]
    pub fn limits(&self, rated_force: Option<f64>) -> SpringLimits {
        let (material, yield_force, range_finding) = match self {
            Self::None | Self::Constant(_) | Self::Torsion(_) => (None, f64::INFINITY, None),
            Self::EndLoadedBeam(beam) => (
                Some(&beam.material),
                beam.yield_force_n(),
                (!beam.in_range()).then(|| OverLimit::pivot_out_of_range(beam.pivot_m, beam.pivot_range_m)),
            ),
            Self::MomentLoadedBeam(beam) => (
                Some(&beam.material),
                beam.yield_force_n(),
                beam.length_m().filter(|_| !beam.in_range()).map(|l| {
                    OverLimit::length_out_of_range(l, [beam.stiff_length_m, beam.compliant_length_m])
                }),
            ),
        };
        SpringLimits {
            stiffness: self.stiffness(),
            stress_per_force_pa: self.stress_pa(1.0).unwrap_or(0.0),
            yield_stress_pa: material.map(|m| m.yield_strength_pa),
            yield_force: Some(yield_force).filter(|f| f.is_finite()),
            rated_force,
            torsion: matches!(self, Self::Torsion(_)),
            static_finding: range_finding,
        }
    }

    /// Checks every number of the description; fields are named relative to the spring's table.
    pub(crate) fn validate(&self) -> Result<(), ActuatorError> {
        let positive = |field: &str, value: f64| {
            if value > 0.0 && value.is_finite() {
                Ok(())
            } else {
                Err(ActuatorError::value(field, value, "positive and finite"))
            }
        };
        let material = |m: &Material| {
            positive("material.youngs_modulus_pa", m.youngs_modulus_pa)?;
            positive("material.yield_strength_pa", m.yield_strength_pa)
        };
        match self {
            Self::None => Ok(()),
            Self::Constant(spring) => positive("stiffness_n_m", spring.stiffness_n_m),
            Self::Torsion(spring) => positive("stiffness_nm_rad", spring.stiffness_nm_rad),
            Self::EndLoadedBeam(beam) => {
                material(&beam.material)?;
                positive("total_length_m", beam.total_length_m)?;
                positive("width_m", beam.width_m)?;
                positive("thickness_m", beam.thickness_m)?;
                positive("pivot_m", beam.pivot_m)?;
                if beam.pivot_m > beam.total_length_m {
                    return Err(ActuatorError::value("pivot_m", beam.pivot_m, "at most total_length_m"));
                }
                let [least, greatest] = beam.pivot_range_m;
                if !(0.0 < least && least <= greatest && greatest <= beam.total_length_m) {
                    return Err(ActuatorError::value(
                        "pivot_range_m",
                        format!("[{least}, {greatest}]"),
                        "two increasing positive lengths, at most total_length_m",
                    ));
                }
                Ok(())
            }
            Self::MomentLoadedBeam(beam) => {
                material(&beam.material)?;
                positive("width_m", beam.width_m)?;
                positive("thickness_m", beam.thickness_m)?;
                positive("lever_arm_m", beam.lever_arm_m)?;
                positive("compliant_length_m", beam.compliant_length_m)?;
                positive("stiff_length_m", beam.stiff_length_m)?;
                positive("beam_scale", beam.beam_scale)?;
                positive("series_stiffness_n_m", beam.series_stiffness_n_m)?;
                match beam.setting {
                    ClampSetting::Length(metres) => positive("setting", metres),
                    _ => Ok(()),
                }
            }
        }
    }
}

/// `0.07`, `0.07 m`, `0.07m`, `70mm`, `70 mm`, in metres.
fn parse_length(text: &str) -> Option<f64> {
    let text = text.trim();
    let (number, scale) = match text.strip_suffix("mm") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('m').unwrap_or(text), 1.0),
    };
    number.trim().parse::<f64>().ok().map(|n| n * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_by_name_and_by_length() {
        let thor = Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::Compliant));
        let stiff = thor.with_setting("stiff").expect("a setting of THOR");
        assert!((stiff.stiffness() / 655.4e3 - 1.0).abs() < 1e-3);
        assert_eq!(thor.with_setting("55 mm").expect("a length").stiffness(), stiff.stiffness());
        assert_eq!(stiff.setting(), "stiff");
        let saffir = Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.1));
        assert!((saffir.with_setting("70mm").expect("a length").stiffness() / 429.67e3 - 1.0).abs() < 1e-4);

        let message = thor.with_setting("compliantt").expect_err("misspelt").to_string();
        assert!(message.contains("did you mean 'compliant'?"), "{message}");
        let negative = thor.with_setting("-5mm").expect_err("negative").to_string();
        assert_eq!(negative, "spring setting = -5mm: must be positive and finite");
        assert!(saffir.with_setting("200mm").is_err());
        assert!(saffir.with_setting("NaN").is_err());
    }

    #[test]
    fn the_setting_in_words_is_taken_back() {
        for spring in [
            Spring::Constant(ConstantSpring { stiffness_n_m: 655e3 }),
            Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.0701)),
            Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::LockedOut)),
            Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::Length(0.08123))),
        ] {
            let again = spring.with_setting(&spring.setting()).expect("its own setting");
            assert!((again.stiffness() / spring.stiffness() - 1.0).abs() < 1e-5, "{}", spring.setting());
        }
        assert_eq!(Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.07)).setting(), "70 mm");
    }

    #[test]
    fn with_stiffness_gives_that_stiffness() {
        for spring in [
            Spring::Constant(ConstantSpring { stiffness_n_m: 1.0 }),
            Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.1)),
            Spring::MomentLoadedBeam(MomentLoadedBeam::thor(ClampSetting::Stiff)),
        ] {
            let set = spring.with_stiffness(400e3).expect("within reach");
            assert!((set.stiffness() / 400e3 - 1.0).abs() < 1e-12);
            assert!(spring.with_stiffness(f64::NAN).is_err());
        }
        assert!(Spring::EndLoadedBeam(EndLoadedBeam::saffir(0.1)).with_stiffness(1e3).is_err());
    }
}
