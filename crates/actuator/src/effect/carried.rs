//! Whether an effect stays within the actuator, so that an actuator of a leg, or of a robot's joint, can carry it as a bench's
//! does.

use super::{Effect, Setting};
use crate::plant::{Link, Plant, Servo, Winding};

/// Whether all that an effect changes is the actuator's own: its laws, and what yields behind its screw. What changes
/// anything else (links, load, mounting, a servo's loop), or is fed with what a bench has logged, belongs to a bench,
/// and a leg refuses it.
#[must_use]
pub fn is_of_actuator(effect: &dyn Effect) -> bool {
    let (before, after) = (bench(), with(effect));
    // Every part is named, so that a new one has to be decided on.
    let Plant {
        reflected_inertia,
        sprung_mass,
        damping,
        stiffness,
        travel_per_rad,
        link_1,
        link_2,
        rigid,
        transmission: _,
        start,
        winding,
        servo,
        series: _,
        wobbling,
        force_per_command,
        command_offset,
        output_forces,
        output_friction,
        laws,
    } = &after;
    !laws.rotor_friction.iter().any(|law| law.feels_temperature())
        && *reflected_inertia == before.reflected_inertia
        && *sprung_mass == before.sprung_mass
        && *damping == before.damping
        && *stiffness == before.stiffness
        && *travel_per_rad == before.travel_per_rad
        && *link_1 == before.link_1
        && *link_2 == before.link_2
        && *rigid == before.rigid
        && *start == before.start
        && *winding == before.winding
        && *servo == before.servo
        && *wobbling == before.wobbling
        && *force_per_command == before.force_per_command
        && *command_offset == before.command_offset
        && output_forces.len() == before.output_forces.len()
        && *output_friction == before.output_friction
}

/// Whether a drive with a spring at a robot's joint can carry an effect. What needs a coordinate of its own does not: a rig
/// that yields, a compliance behind the screw, and a mass on the link are the robot's to have.
#[must_use]
pub fn is_of_joint(effect: &dyn Effect) -> bool {
    let (before, after) = (bench(), with(effect));
    let same_links = (after.link_1, after.link_2) == (before.link_1, before.link_2);
    same_links && after.series == before.series && after.wobbling == before.wobbling
}

/// That bench with an effect at its guesses.
fn with(effect: &dyn Effect) -> Plant {
    let values: Vec<f64> = effect.card(&Setting::unknown()).parameters.iter().map(|p| p.value).collect();
    let mut plant = bench();
    effect.install(&values, None, &mut plant);
    plant
}

/// A bench with everything that an effect may act on: a pendulum, a winding and a servo's loop. It is never run.
fn bench() -> Plant {
    let mut plant = Plant::new(1.0, 1.0, 1.0, 1.0);
    plant.link_2 = Link::Pendulum { inertia_kg_m2: 1.0, gravity_torque_nm: 1.0, arm_m: 1.0 };
    plant.drive_by(Winding { force_per_current: 1.0, resistance_ohm: 1.0, supply_v: 1.0 });
    plant.servo = Some(Servo {
        proportional: 1.0,
        derivative: 0.0,
        integral: 0.0,
        limit: 1.0,
        dead_band: 0.0,
        feedback_delay_s: 0.0,
        sees_rotor: false,
        period_s: None,
        goal_offset: 0.0,
        supply_v: Some(1.0),
    });
    plant
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{CATALOGUE, OwnEffect};

    #[test]
    fn what_acts_on_a_benchs_parts_is_told_from_what_acts_in_the_actuator() {
        let of = |id: &str| {
            let effect = CATALOGUE.iter().find(|e| e.card(&Setting::unknown()).id == id).expect("known");
            is_of_actuator(*effect)
        };
        for id in ["coulomb-friction", "presliding-friction", "backlash", "series-compliance", "sensor-lag"] {
            assert!(of(id), "{id}");
        }
        for id in [
            "output-friction",
            "output-offset",
            "cable-stiffness",
            "load-mismatch",
            "wobbling-mass",
            "feedback-delay",
            "base-motion",
        ] {
            assert!(!of(id), "{id}");
        }
        let own = |acts_on: &str| {
            let text = format!(
                "id = \"mine\"\nacts-on = \"{acts_on}\"\nlaw = \"c*t\"\nparameters = {{ c = {{ guess = 1.0, min = 0.0, max = 2.0 }} }}"
            );
            let text = if acts_on == "spring" { text.replace("c*t", "c*delta") } else { text };
            OwnEffect::from_definition(&toml::from_str(&text).expect("TOML"), "mine").expect("good")
        };
        assert!(is_of_actuator(&own("rotor")) && is_of_actuator(&own("spring")));
        assert!(!is_of_actuator(&own("output")));
        assert!(is_of_joint(&own("output")) && is_of_joint(&own("spring")));
        for effect in CATALOGUE {
            let id = effect.card(&Setting::unknown()).id;
            let beyond = ["base-motion", "series-compliance", "wobbling-mass", "load-mismatch"];
            assert_eq!(is_of_joint(*effect), !beyond.contains(&id.as_str()), "{id}");
        }
    }
}
