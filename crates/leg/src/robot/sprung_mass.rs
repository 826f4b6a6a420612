//! Sprung masses that a URDF's links already contain, taken out so that the coupling can put them where they move.

use super::{Drive, Inertial, Robot, RobotFault};
use crate::LegError;

impl Robot {
    /// This robot with the sprung masses that links contain ([`super::Placement::sprung_mass_in`]) taken out
    /// of them, each at the actuator's attachment point on that link.
    ///
    /// # Errors
    ///
    /// [`RobotFault::SprungMassTooLarge`] if that leaves a link that no body can be.
    pub fn without_sprung_masses(mut self) -> Result<Self, LegError> {
        for i in 0..self.actuators.len() {
            let Some(link) = self.actuators[i].sprung_mass_in else { continue };
            let rest = self.without_contained(link).map_err(|fault| LegError::Robot {
                file: self.source.placement_name(),
                line: None,
                element: format!("actuator '{}' sprung_mass_in", self.actuators[i].name),
                fault: Box::new(fault),
            })?;
            self.links[link].inertial = Some(rest);
            for placement in self.actuators.iter_mut().filter(|a| a.sprung_mass_in == Some(link)) {
                placement.sprung_mass_in = None;
            }
        }
        Ok(self)
    }

    /// The mass properties of a link without all sprung masses that it contains.
    pub(super) fn without_contained(&self, link: usize) -> Result<Inertial, RobotFault> {
        let mut rest = self.links[link].inertial.clone();
        let mut mass_kg = 0.0;
        for placement in self.actuators.iter().filter(|a| a.sprung_mass_in == Some(link)) {
            let Some(spec) = &placement.spec else { continue };
            let point = match &placement.drive {
                Drive::Linear { point_2, .. } if link == placement.link_2 => point_2,
                Drive::Linear { point_1, .. } => point_1,
                Drive::Hoekens(mount) => &mount.point_1,
                Drive::RigidPosition { .. } => continue,
            };
            let sprung_mass = spec.coefficients().sprung_mass;
            mass_kg += sprung_mass;
            rest = rest.map(|r| r.with_point_mass(-sprung_mass, point));
        }
        rest.filter(Inertial::is_physical)
            .ok_or_else(|| RobotFault::SprungMassTooLarge { link: self.links[link].name.clone(), mass_kg })
    }
}
