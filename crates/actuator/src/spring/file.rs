//! The `[spring]` table of an actuator file, before it is known which keys its type needs.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;

use super::{
    BeamLaw, ClampSetting, ConstantSpring, EndLoadedBeam, Material, MomentLoadedBeam, Spring, TorsionSpring,
};
use crate::text::meant;

/// All keys of all types: so that a misspelt key is found with its line and a suggestion.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpringFile {
    r#type: String,
    stiffness_n_m: Option<f64>,
    stiffness_nm_rad: Option<f64>,
    material: Option<Material>,
    total_length_m: Option<f64>,
    width_m: Option<f64>,
    thickness_m: Option<f64>,
    pivot_m: Option<f64>,
    pivot_range_m: Option<[f64; 2]>,
    law: Option<BeamLaw>,
    lever_arm_m: Option<f64>,
    compliant_length_m: Option<f64>,
    stiff_length_m: Option<f64>,
    beam_scale: Option<f64>,
    series_stiffness_n_m: Option<f64>,
    setting: Option<NameOrLength>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum NameOrLength {
    Name(String),
    Length(f64),
}

const TYPES: [&str; 5] = ["none", "constant", "torsion", "end-loaded-beam", "moment-loaded-beam"];

impl SpringFile {
    /// The keys that are there, apart from the type.
    fn present(&self) -> Vec<&'static str> {
        [
            ("stiffness_n_m", self.stiffness_n_m.is_some()),
            ("stiffness_nm_rad", self.stiffness_nm_rad.is_some()),
            ("material", self.material.is_some()),
            ("total_length_m", self.total_length_m.is_some()),
            ("width_m", self.width_m.is_some()),
            ("thickness_m", self.thickness_m.is_some()),
            ("pivot_m", self.pivot_m.is_some()),
            ("pivot_range_m", self.pivot_range_m.is_some()),
            ("law", self.law.is_some()),
            ("lever_arm_m", self.lever_arm_m.is_some()),
            ("compliant_length_m", self.compliant_length_m.is_some()),
            ("stiff_length_m", self.stiff_length_m.is_some()),
            ("beam_scale", self.beam_scale.is_some()),
            ("series_stiffness_n_m", self.series_stiffness_n_m.is_some()),
            ("setting", self.setting.is_some()),
        ]
        .into_iter()
        .filter_map(|(name, present)| present.then_some(name))
        .collect()
    }
}

/// `spring = "none"`, or a `[spring]` table.
impl<'de> Deserialize<'de> for Spring {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordOrTable;

        impl<'de> Visitor<'de> for WordOrTable {
            type Value = Spring;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"none\" or a table with a type")
            }

            fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<Spring, E> {
                match word {
                    "none" => Ok(Spring::None),
                    _ => Err(E::custom(format!(
                        "spring is '{word}'; it must be \"none\" or a table with a type"
                    ))),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Spring, A::Error> {
                let file = SpringFile::deserialize(MapAccessDeserializer::new(map))?;
                Spring::try_from(file).map_err(A::Error::custom)
            }
        }

        deserializer.deserialize_any(WordOrTable)
    }
}

impl TryFrom<SpringFile> for Spring {
    type Error = String;

    fn try_from(file: SpringFile) -> Result<Self, String> {
        let r#type = file.r#type.clone();
        let admitted: &[&str] = match r#type.as_str() {
            "none" => &[],
            "constant" => &["stiffness_n_m"],
            "torsion" => &["stiffness_nm_rad"],
            "end-loaded-beam" => {
                &["material", "total_length_m", "width_m", "thickness_m", "pivot_m", "pivot_range_m", "law"]
            }
            "moment-loaded-beam" => &[
                "material",
                "width_m",
                "thickness_m",
                "lever_arm_m",
                "compliant_length_m",
                "stiff_length_m",
                "beam_scale",
                "series_stiffness_n_m",
                "setting",
            ],
            other => {
                let hint = meant(other, TYPES);
                return Err(format!("no spring type '{other}'{hint}; known are {}", TYPES.join(", ")));
            }
        };
        if let Some(stray) = file.present().into_iter().find(|key| !admitted.contains(key)) {
            let takes = if admitted.is_empty() { "nothing".to_owned() } else { admitted.join(", ") };
            return Err(format!("a spring of type '{type}' has no '{stray}'; it takes {takes}"));
        }
        let missing = |key: &str| format!("a spring of type '{type}' needs '{key}'");
        let need = |value: Option<f64>, key: &str| value.ok_or_else(|| missing(key));
        Ok(match r#type.as_str() {
            "none" => Self::None,
            "constant" => {
                Self::Constant(ConstantSpring { stiffness_n_m: need(file.stiffness_n_m, "stiffness_n_m")? })
            }
            "torsion" => Self::Torsion(TorsionSpring {
                stiffness_nm_rad: need(file.stiffness_nm_rad, "stiffness_nm_rad")?,
            }),
            "end-loaded-beam" => {
                let total_length_m = need(file.total_length_m, "total_length_m")?;
                Self::EndLoadedBeam(EndLoadedBeam {
                    material: file.material.ok_or_else(|| missing("material"))?,
                    total_length_m,
                    width_m: need(file.width_m, "width_m")?,
                    thickness_m: need(file.thickness_m, "thickness_m")?,
                    pivot_m: need(file.pivot_m, "pivot_m")?,
                    pivot_range_m: file.pivot_range_m.ok_or_else(|| missing("pivot_range_m"))?,
                    law: file.law.unwrap_or_default(),
                })
            }
            _ => Self::MomentLoadedBeam(MomentLoadedBeam {
                material: file.material.ok_or_else(|| missing("material"))?,
                width_m: need(file.width_m, "width_m")?,
                thickness_m: need(file.thickness_m, "thickness_m")?,
                lever_arm_m: need(file.lever_arm_m, "lever_arm_m")?,
                compliant_length_m: need(file.compliant_length_m, "compliant_length_m")?,
                stiff_length_m: need(file.stiff_length_m, "stiff_length_m")?,
                beam_scale: need(file.beam_scale, "beam_scale")?,
                series_stiffness_n_m: need(file.series_stiffness_n_m, "series_stiffness_n_m")?,
                setting: match file.setting.ok_or_else(|| missing("setting"))? {
                    NameOrLength::Length(metres) => ClampSetting::Length(metres),
                    NameOrLength::Name(name) => match name.as_str() {
                        "compliant" => ClampSetting::Compliant,
                        "stiff" => ClampSetting::Stiff,
                        "locked-out" => ClampSetting::LockedOut,
                        _ => {
                            let hint = meant(&name, ["compliant", "stiff", "locked-out"]);
                            return Err(format!(
                                "no spring setting '{name}'{hint}; known are compliant, stiff, locked-out, or a free length in m"
                            ));
                        }
                    },
                },
            }),
        })
    }
}
