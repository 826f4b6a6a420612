//! Beam materials: Young's modulus and yield strength (Table 3 and section 2-4-1).

use std::fmt;

use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use crate::text::meant;

/// What bends and when it yields. In a file either a name of [`Material::TABLE`] or a table
/// `{ name, youngs_modulus_pa, yield_strength_pa }`.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Young's modulus `E`, Pa.
    pub youngs_modulus_pa: f64,
    /// Yield strength `S_y`, Pa.
    pub yield_strength_pa: f64,
}

impl Material {
    /// Name, `E` in GPa and `S_y` in MPa: Table 3, then the titanium that was sourced (section 2-4-1).
    pub const TABLE: [(&'static str, f64, f64); 7] = [
        ("steel-1010", 207.0, 179.0),
        ("steel-4140", 207.0, 1641.0),
        ("aluminium-7075", 71.7, 503.0),
        ("titanium-13", 114.0, 1170.0),
        ("hdpe", 1.4, 28.0),
        ("e-glass", 56.0, 1640.0),
        ("titanium-6al-4v", 115.0, 828.0),
    ];

    /// A material of the table by its name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::TABLE.iter().find(|(n, _, _)| *n == name).map(|&(n, gpa, mpa)| Self {
            name: n.to_owned(),
            youngs_modulus_pa: gpa * 1e9,
            yield_strength_pa: mpa * 1e6,
        })
    }

    /// `1000 S_y / E`: how far the material bends before it yields (last column of Table 3).
    #[must_use]
    pub fn bending_merit(&self) -> f64 {
        1000.0 * self.yield_strength_pa / self.youngs_modulus_pa
    }
}

impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if Self::named(&self.name).as_ref() == Some(self) {
            return serializer.serialize_str(&self.name);
        }
        let mut table = serializer.serialize_struct("Material", 3)?;
        table.serialize_field("name", &self.name)?;
        table.serialize_field("youngs_modulus_pa", &self.youngs_modulus_pa)?;
        table.serialize_field("yield_strength_pa", &self.yield_strength_pa)?;
        table.end()
    }
}

impl<'de> de::Deserialize<'de> for Material {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrTable;

        impl<'de> Visitor<'de> for NameOrTable {
            type Value = Material;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a material's name or { name, youngs_modulus_pa, yield_strength_pa }")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Material, E> {
                Material::named(name).ok_or_else(|| {
                    let names = Material::TABLE.map(|(n, _, _)| n);
                    let hint = meant(name, names);
                    E::custom(format!("no material '{name}'{hint}; known are {}", names.join(", ")))
                })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Material, A::Error> {
                #[derive(serde::Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Table {
                    name: String,
                    youngs_modulus_pa: f64,
                    yield_strength_pa: f64,
                }
                let table: Table = de::Deserialize::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(Material {
                    name: table.name,
                    youngs_modulus_pa: table.youngs_modulus_pa,
                    yield_strength_pa: table.yield_strength_pa,
                })
            }
        }

        deserializer.deserialize_any(NameOrTable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_table_3_bending_merit() {
        let printed = [0.87, 7.9, 7.0, 10.0, 20.0, 29.0, 7.2];
        for ((name, _, _), printed) in Material::TABLE.into_iter().zip(printed) {
            let merit = Material::named(name).expect("in the table").bending_merit();
            // Printed to two digits; Ti-13 (10.26) is printed as 10.
            assert!((merit / printed - 1.0).abs() < 0.03, "{name}: {merit} against {printed}");
        }
    }
}
