//! The inverted Hoekens linkage, solved as a four-bar by geometry.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::ActuatorError;

/// A Hoekens four-bar whose tracer is driven along its straight line and whose crank turns the joint: an almost
/// constant moment arm over 160 degrees (section 2-3-3).
///
/// The crank turns about the origin, the rocker about a ground pivot on the x axis; the coupler from crank to
/// rocker is prolonged beyond the rocker to the tracer. The joint angle is zero in the middle of the straight
/// part, where the crank points away from the ground pivot, and positive where the actuator gets longer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hoekens {
    /// Crank length, m: it scales the whole linkage.
    pub crank_m: f64,
    /// Distance of the ground pivots, in cranks.
    #[serde(default = "symmetric_ground")]
    pub ground: f64,
    /// Coupler from crank to rocker, in cranks.
    #[serde(default = "symmetric_coupler")]
    pub coupler: f64,
    /// Rocker, in cranks.
    #[serde(default = "symmetric_coupler")]
    pub rocker: f64,
    /// From the crank's end along the coupler to the tracer, in cranks.
    #[serde(default = "symmetric_tracer")]
    pub tracer: f64,
}

fn symmetric_ground() -> f64 {
    1.591
}
fn symmetric_coupler() -> f64 {
    1.979
}
fn symmetric_tracer() -> f64 {
    3.957
}

/// Tracer position and its derivative by the crank angle, in cranks.
struct Solution {
    position: [f64; 2],
    derivative: [f64; 2],
}

impl Hoekens {
    /// Half of the joint range over which the moment arm is almost constant: 80 degrees, rad.
    pub const HALF_RANGE_RAD: f64 = 80.0 * PI / 180.0;

    /// The symmetric linkage (coupler = rocker = half the tracer's arm) of the given crank, whose moment arm
    /// varies by 5.5 % over 160 degrees.
    #[must_use]
    pub fn symmetric(crank_m: f64) -> Self {
        Self {
            crank_m,
            ground: symmetric_ground(),
            coupler: symmetric_coupler(),
            rocker: symmetric_coupler(),
            tracer: symmetric_tracer(),
        }
    }

    /// The linkage of the given crank whose mean moment arm over the range is `arm_m`.
    #[must_use]
    pub fn with_mean_arm(arm_m: f64) -> Self {
        let unit = Self::symmetric(1.0);
        let reach = |angle| unit.travel_m(angle).unwrap_or(f64::NAN);
        let mean =
            (reach(Self::HALF_RANGE_RAD) - reach(-Self::HALF_RANGE_RAD)) / (2.0 * Self::HALF_RANGE_RAD);
        Self::symmetric(arm_m / mean)
    }

    fn solve(&self, angle_rad: f64) -> Result<Solution, ActuatorError> {
        // On the straight part the tracer moves towards -x as the crank angle grows: travel is counted along -x.
        let crank_angle = PI + angle_rad;
        let (sin, cos) = crank_angle.sin_cos();
        let to_ground = [self.ground - cos, -sin];
        let distance = to_ground[0].hypot(to_ground[1]);
        // The coupler's end lies where the circles about crank end and ground pivot meet.
        let along = (self.coupler.powi(2) - self.rocker.powi(2) + distance.powi(2)) / (2.0 * distance);
        let square = self.coupler.powi(2) - along.powi(2);
        if !(distance > 0.0 && square > 0.0) {
            return Err(ActuatorError::LinkageOpen { angle_rad });
        }
        let across = square.sqrt();
        let u = [to_ground[0] / distance, to_ground[1] / distance];
        let coupler = [along * u[0] - across * u[1], along * u[1] + across * u[0]];
        let joint = [cos + coupler[0], sin + coupler[1]];
        let rocker = [joint[0] - self.ground, joint[1]];
        // Velocity of the coupler's end per crank angle: perpendicular to the rocker, and equal to the crank
        // end's along the coupler.
        let crank_rate = [-sin, cos];
        let determinant = rocker[0] * coupler[1] - rocker[1] * coupler[0];
        let along_coupler = coupler[0] * crank_rate[0] + coupler[1] * crank_rate[1];
        let joint_rate = [-rocker[1] * along_coupler / determinant, rocker[0] * along_coupler / determinant];
        let reach = self.tracer / self.coupler;
        Ok(Solution {
            position: [cos + coupler[0] * reach, sin + coupler[1] * reach],
            derivative: [
                crank_rate[0] + (joint_rate[0] - crank_rate[0]) * reach,
                crank_rate[1] + (joint_rate[1] - crank_rate[1]) * reach,
            ],
        })
    }

    /// Position of the tracer in the frame of crank pivot (origin) and rocker pivot (on +x), m.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] where the bars do not reach.
    pub fn tracer_m(&self, angle_rad: f64) -> Result<[f64; 2], ActuatorError> {
        let [x, y] = self.solve(angle_rad)?.position;
        Ok([self.crank_m * x, self.crank_m * y])
    }

    /// How much longer the actuator is than in the middle of the range, m: the tracer's travel along its line.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] where the bars do not reach.
    pub fn travel_m(&self, angle_rad: f64) -> Result<f64, ActuatorError> {
        Ok(self.crank_m * (self.solve(0.0)?.position[0] - self.solve(angle_rad)?.position[0]))
    }

    /// Moment arm `d travel / d angle`, m: joint torque per actuator force, actuator speed per joint speed.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] where the bars do not reach.
    pub fn moment_arm_m(&self, angle_rad: f64) -> Result<f64, ActuatorError> {
        Ok(-self.crank_m * self.solve(angle_rad)?.derivative[0])
    }

    /// The joint angle within the straight part at which the tracer has travelled this far, rad: the inverse of
    /// [`Hoekens::travel_m`]. A travel beyond the range gives the end of the range.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] where the bars do not reach.
    pub fn angle_rad(&self, travel_m: f64) -> Result<f64, ActuatorError> {
        let (mut low, mut high) = (-Self::HALF_RANGE_RAD, Self::HALF_RANGE_RAD);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.travel_m(middle)? < travel_m {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(0.5 * (low + high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range() -> impl Iterator<Item = f64> {
        (-800..=800).map(|tenths| f64::from(tenths) * 0.1_f64.to_radians())
    }

    #[test]
    fn published_mechanical_advantage_within_5_5_percent_over_160_degrees() {
        let linkage = Hoekens::symmetric(1.0);
        let arms: Vec<f64> = range().map(|a| linkage.moment_arm_m(a).expect("closes")).collect();
        let least = arms.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = arms.iter().copied().fold(0.0, f64::max);
        assert!(greatest / least - 1.0 < 0.055, "{least} to {greatest}");
        // Not constant either: the figure of the dissertation shows 5 %.
        assert!(greatest / least - 1.0 > 0.04, "{least} to {greatest}");
    }

    #[test]
    fn published_textbook_proportions_vary_by_18_percent() {
        let textbook = Hoekens { ground: 2.0, coupler: 2.5, rocker: 2.5, tracer: 5.0, crank_m: 1.0 };
        let arms: Vec<f64> = range().map(|a| textbook.moment_arm_m(a).expect("closes")).collect();
        let least = arms.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = arms.iter().copied().fold(0.0, f64::max);
        assert!((greatest / least - 1.18).abs() < 0.02, "{}", greatest / least);
    }

    #[test]
    fn the_tracer_stays_on_a_line() {
        let linkage = Hoekens::symmetric(0.05);
        let points: Vec<[f64; 2]> = range().map(|a| linkage.tracer_m(a).expect("closes")).collect();
        let travel = points[0][0] - points[1600][0];
        let highest = points.iter().map(|p| p[1]).fold(f64::MIN, f64::max);
        let lowest = points.iter().map(|p| p[1]).fold(f64::MAX, f64::min);
        // Total width of the band over the travel.
        assert!((highest - lowest) / travel < 0.0105, "{}", (highest - lowest) / travel);
    }

    #[test]
    fn analytic_arm_is_the_slope_of_the_travel() {
        let linkage = Hoekens { ground: 1.7, coupler: 2.1, rocker: 2.0, tracer: 4.0, crank_m: 0.04 };
        for angle in range().step_by(100) {
            let e = 1e-5;
            let slope = (linkage.travel_m(angle + e).expect("closes")
                - linkage.travel_m(angle - e).expect("closes"))
                / (2.0 * e);
            let arm = linkage.moment_arm_m(angle).expect("closes");
            // Central difference: error of the order e^2 plus rounding over e.
            assert!((arm - slope).abs() < 1e-10, "{angle}: {arm} {slope}");
        }
    }

    #[test]
    fn analytic_bars_keep_their_lengths() {
        let linkage = Hoekens::symmetric(1.0);
        for angle in range().step_by(100) {
            let crank = [(PI + angle).cos(), (PI + angle).sin()];
            let tracer = linkage.tracer_m(angle).expect("closes");
            let arm = (tracer[0] - crank[0]).hypot(tracer[1] - crank[1]);
            let share = linkage.coupler / linkage.tracer;
            let joint =
                [crank[0] + share * (tracer[0] - crank[0]), crank[1] + share * (tracer[1] - crank[1])];
            assert!((arm - linkage.tracer).abs() < 1e-12);
            assert!(((joint[0] - linkage.ground).hypot(joint[1]) - linkage.rocker).abs() < 1e-12);
        }
    }

    #[test]
    fn angle_inverts_travel_and_the_mean_arm_is_what_was_asked() {
        let linkage = Hoekens::with_mean_arm(0.07);
        for angle in range().step_by(160) {
            let found = linkage.angle_rad(linkage.travel_m(angle).expect("closes")).expect("closes");
            assert!((found - angle).abs() < 1e-9);
        }
        let swing = linkage.travel_m(Hoekens::HALF_RANGE_RAD).expect("closes")
            - linkage.travel_m(-Hoekens::HALF_RANGE_RAD).expect("closes");
        assert!((swing / (2.0 * Hoekens::HALF_RANGE_RAD) - 0.07).abs() < 1e-12);
    }

    #[test]
    fn bars_that_do_not_reach_are_an_error() {
        let open = Hoekens { ground: 10.0, ..Hoekens::symmetric(0.05) };
        assert_eq!(open.travel_m(0.3), Err(ActuatorError::LinkageOpen { angle_rad: 0.0 }));
    }
}
