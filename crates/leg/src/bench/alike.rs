//! Effects that all joints of a robot have alike: what passes one bus, or is computed by one controller, is late for all.

use super::RobotModel;
use sealegs_model::{EffectCard, Excitation, Model, ModelError, Parameter};

/// Their ids, which have no joint before them.
const ALIKE: [&str; 2] = ["transport-delay", "feedback-delay"];

pub(super) fn is_alike(id: &str) -> bool {
    ALIKE.contains(&id)
}

impl RobotModel {
    /// The cards of those that every joint can have, of a robot of several joints.
    pub(super) fn alike(&self, seen: &Excitation) -> Vec<EffectCard> {
        let of = |id: &&str| {
            let at_joints = self.joints.iter().map(|joint| {
                let cards = joint.model.effects(&joint.seen(seen));
                cards.into_iter().find(|card| card.id == **id && !joint.refused.contains(&card.id))
            });
            let card = at_joints.collect::<Option<Vec<_>>>()?.swap_remove(0);
            Some(EffectCard { summary: format!("{} All joints alike.", card.summary), ..card })
        };
        let ids = if self.joints.len() > 1 { &ALIKE[..] } else { &[] };
        ids.iter().filter_map(of).collect()
    }

    /// Puts one into every joint, with the same parameters.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for a joint that cannot have it, or has it already.
    pub(super) fn include_alike(&mut self, id: &str, seen: &Excitation) -> Result<(), ModelError> {
        let first = self.parameters.len();
        for joint in &mut self.joints {
            if joint.refused.iter().any(|refused| refused == id) {
                let reason = format!("joint '{}' cannot have the effect '{id}'", joint.name);
                return Err(ModelError::Setup { reason });
            }
            let with = joint.model.including(id, &joint.seen(seen))?;
            let before = Model::parameters(&joint.model).len();
            for (i, p) in Model::parameters(&with)[before..].iter().enumerate() {
                joint.at.push(first + i);
                if self.parameters.len() == first + i {
                    self.parameters.push(Parameter::clone(p));
                }
            }
            joint.model = with;
        }
        self.included.push((None, id.to_owned()));
        Ok(())
    }
}
