//! Momentum: on a rail without gravity or ground, nothing outside acts along the rail, whatever the actuators do.

use nalgebra::Point3;
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{LegDescription, Observer, Sample};
use sealegs_leg::{LegError, run};

/// Height of the common centre of mass, and of the foot, at every sample.
#[derive(Default)]
struct Heights {
    robot: Option<Robot>,
    carriage_kg: f64,
    time_s: Vec<f64>,
    common_m: Vec<f64>,
    foot_m: Vec<f64>,
}

impl Observer for Heights {
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        self.robot = Some(leg.robot.clone());
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LegError> {
        let robot = self.robot.as_ref().expect("started");
        let base = sample.world_from_link[0].translation.z;
        let (mut moment, mut mass) = (self.carriage_kg * base, self.carriage_kg);
        for (link, pose) in robot.links.iter().zip(&sample.world_from_link) {
            if let Some(inertial) = &link.inertial {
                moment += inertial.mass_kg * (pose * Point3::from(inertial.com.coords)).z;
                mass += inertial.mass_kg;
            }
        }
        self.time_s.push(sample.time_s);
        self.common_m.push(moment / mass);
        self.foot_m.push(sample.world_from_link.last().expect("links").translation.z);
        Ok(())
    }
}

/// Largest departure from a straight line through the first and last value.
fn bend(time_s: &[f64], values: &[f64]) -> f64 {
    let last = values.len() - 1;
    let slope = (values[last] - values[0]) / (time_s[last] - time_s[0]);
    values
        .iter()
        .zip(time_s)
        .map(|(v, t)| (v - values[0] - slope * (t - time_s[0])).abs())
        .fold(0.0, f64::max)
}

#[test]
fn analytic_actuators_move_the_leg_but_not_its_centre_of_mass() {
    // Without sprung masses, whose own travel would have to be counted in.
    let robot = Robot::load("thor-leg", None).expect("embedded");
    let mut set = vec![
        "gravity_m_s2=0".to_owned(),
        "start.drop_height_m=1.0".to_owned(),
        "duration_s=0.4".to_owned(),
        "start.speed_rad_s={ knee = 4.0, hip_pitch = -2.0 }".to_owned(),
    ];
    set.extend(
        robot.actuators.iter().map(|a| format!("actuator.{}.parameters={{ sprung_mass = 0.0 }}", a.name)),
    );
    let scenario = Scenario::load("thor-drop", &set).expect("good");
    let mut heights = Heights { carriage_kg: 20.0, ..Heights::default() };
    run(&scenario, &mut heights).expect("runs");
    let common = bend(&heights.time_s, &heights.common_m);
    let foot = bend(&heights.time_s, &heights.foot_m);
    println!("centre of mass bends by {common:e} m, the foot by {foot:e} m");
    assert!(foot > 0.01, "the motors stop the swing: {foot}");
    // First order in the step: what is left is a hundred thousandth of what moves.
    assert!(common < 1e-4 * foot, "{common} of {foot}");
}
