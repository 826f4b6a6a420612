//! Effects that all joints of a robot have alike: what passes one bus, or is computed by one controller, is late for all.

use sealegs_model::EffectCard;

/// Their ids, which have no joint before them.
const ALIKE: [&str; 2] = ["transport-delay", "feedback-delay"];

pub(super) fn is_alike(id: &str) -> bool {
    ALIKE.contains(&id)
}

/// The cards of those that every joint can have, of a robot of several joints, out of the joints' own.
pub(super) fn cards(by_joint: &[Vec<EffectCard>]) -> Vec<EffectCard> {
    let of = |id: &&str| {
        let at_joints = by_joint.iter().map(|cards| cards.iter().find(|card| card.id == **id));
        let card = at_joints.collect::<Option<Vec<_>>>()?.swap_remove(0).clone();
        Some(EffectCard { summary: format!("{} All joints alike.", card.summary), ..card })
    };
    let ids = if by_joint.len() > 1 { &ALIKE[..] } else { &[] };
    ids.iter().filter_map(of).collect()
}
