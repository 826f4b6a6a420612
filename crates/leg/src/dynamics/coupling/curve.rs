//! The length of a linkage drive as a smooth function of its joint's angle.

use sealegs_actuator::ActuatorError;
use sealegs_actuator::linkage::Hoekens;

/// Half the range of crank angles that the table covers where the linkage closes, rad.
const HALF_RANGE_RAD: f64 = 1.7;
/// Intervals of the table; cubic interpolation is then exact to about 1e-12 m.
const INTERVALS: usize = 512;

/// Travel of the tracer over the crank angle, as cubics through exact values and slopes: the moment arm is
/// the derivative of the very curve that gives the length, so that force and travel do the same work.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    from_rad: f64,
    interval_rad: f64,
    /// Travel (m) and moment arm (m/rad) at the nodes.
    nodes: Vec<[f64; 2]>,
}

/// The curve at one angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvePoint {
    /// Travel, m.
    pub travel_m: f64,
    /// Moment arm, m/rad.
    pub arm_m: f64,
    /// Derivative of the moment arm, m/rad^2.
    pub arm_slope_m: f64,
}

impl Curve {
    /// Solves the linkage at the nodes of a table.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::LinkageOpen`] if it does not close in the middle of its range.
    pub fn of(linkage: &Hoekens) -> Result<Self, ActuatorError> {
        let at = |angle: f64| Ok([linkage.travel_m(angle)?, linkage.moment_arm_m(angle)?]);
        let middle = at(0.0)?;
        let interval_rad = 2.0 * HALF_RANGE_RAD / INTERVALS as f64;
        // As far to both sides of the middle as the bars reach.
        let half = INTERVALS / 2;
        let reach = |sign: f64| -> Vec<[f64; 2]> {
            (1..=half).map_while(|i| at(sign * i as f64 * interval_rad).ok()).collect::<Vec<_>>()
        };
        let (down, up) = (reach(-1.0), reach(1.0));
        let from_rad = -(down.len() as f64) * interval_rad;
        let nodes: Vec<[f64; 2]> = down.into_iter().rev().chain([middle]).chain(up).collect();
        if nodes.len() < 2 {
            return Err(ActuatorError::LinkageOpen { angle_rad: interval_rad });
        }
        Ok(Self { from_rad, interval_rad, nodes })
    }

    #[cfg(test)]
    /// The range of crank angles in which the linkage closes, rad.
    pub fn range_rad(&self) -> [f64; 2] {
        [self.from_rad, self.from_rad + (self.nodes.len() - 1) as f64 * self.interval_rad]
    }

    /// The curve at a crank angle; beyond its range a straight line, so that a run past the linkage's end
    /// stays finite (and is reported as past the stroke).
    pub fn at(&self, angle_rad: f64) -> CurvePoint {
        let last = self.nodes.len() - 1;
        let along = (angle_rad - self.from_rad) / self.interval_rad;
        if !(0.0..=last as f64).contains(&along) {
            let [end, node] = if along < 0.0 { [0.0, 0.0] } else { [last as f64, last as f64] };
            let [travel, arm] = self.nodes[node as usize];
            return CurvePoint {
                travel_m: travel + arm * (along - end) * self.interval_rad,
                arm_m: arm,
                arm_slope_m: 0.0,
            };
        }
        let i = (along as usize).min(last - 1);
        let (s, h) = (along - i as f64, self.interval_rad);
        let ([x0, a0], [x1, a1]) = (self.nodes[i], self.nodes[i + 1]);
        // Cubic Hermite in s: x0 + h a0 s + c s^2 + d s^3.
        let (c, d) = (3.0 * (x1 - x0) - h * (2.0 * a0 + a1), 2.0 * (x0 - x1) + h * (a0 + a1));
        CurvePoint {
            travel_m: x0 + s * (h * a0 + s * (c + s * d)),
            arm_m: a0 + s * (2.0 * c + 3.0 * d * s) / h,
            arm_slope_m: (2.0 * c + 6.0 * d * s) / (h * h),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_the_table_is_the_linkage() {
        let linkage = Hoekens::symmetric(0.03);
        let curve = Curve::of(&linkage).expect("closes");
        for i in -70..=70 {
            let angle = f64::from(i) * 0.0199;
            let point = curve.at(angle);
            assert!((point.travel_m - linkage.travel_m(angle).expect("closes")).abs() < 1e-11);
            assert!((point.arm_m - linkage.moment_arm_m(angle).expect("closes")).abs() < 1e-8);
            let h = 1e-5;
            let arm = |a| linkage.moment_arm_m(a).expect("closes");
            let slope = (arm(angle + h) - arm(angle - h)) / (2.0 * h);
            assert!((point.arm_slope_m - slope).abs() < 1e-4, "{} {slope}", point.arm_slope_m);
        }
    }

    #[test]
    fn beyond_its_end_the_curve_goes_on_straight() {
        let curve = Curve::of(&Hoekens::symmetric(0.03)).expect("closes");
        let [from, to] = curve.range_rad();
        for end in [from, to] {
            let (inside, outside) =
                (curve.at(end - 1e-9 * end.signum()), curve.at(end + 1e-9 * end.signum()));
            assert!((inside.travel_m - outside.travel_m).abs() < 1e-9);
            assert!((inside.arm_m - outside.arm_m).abs() < 1e-6);
        }
    }
}
