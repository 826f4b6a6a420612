//! The plant linearised about an equilibrium under a constant command.

use super::linear::{LinearPart, MOST, Row};
use super::{GRAVITY_M_S2, Link, Plant};
use sealegs_model::ModelError;

/// `q'' = by_position q + by_velocity v + by_command u` for small departures from an equilibrium, with the rows
/// that give forces, over the first `count` generalised coordinates (the screw's extension first).
#[derive(Debug, Clone)]
pub struct Linearised {
    /// Number of coordinates.
    pub count: usize,
    /// Coordinate of link 2, where it moves.
    pub link_2: Option<usize>,
    /// Acceleration per position, 1/s^2.
    pub by_position: Vec<Vec<f64>>,
    /// Acceleration per velocity, 1/s.
    pub by_velocity: Vec<Vec<f64>>,
    /// Acceleration per unit of command.
    pub by_command: Vec<f64>,
    /// Force on link 1 per position and per velocity.
    pub force_1: (Vec<f64>, Vec<f64>),
    /// Force on link 2 per position, per velocity and per command.
    pub force_2: (Vec<f64>, Vec<f64>, f64),
    /// Deflection of the spring per position.
    pub deflection: Vec<f64>,
    /// The equilibrium's positions.
    pub at: Vec<f64>,
}

/// Relative accuracy of an equilibrium, and most steps towards it.
const SETTLED: f64 = 1e-13;
const MOST_STEPS: usize = 100;

impl Plant {
    /// The plant linearised about its equilibrium under a constant `command` (in its unit).
    ///
    /// The linear part is taken as it is, everything smooth beside it (gravity, spring, rotor, drive, output) by
    /// central differences. Dry friction, presliding and slip, and what happens to command and sensors, are left
    /// out: they have no slope.
    ///
    /// # Errors
    ///
    /// [`ModelError::BadParameter`] if there is no mass, or no equilibrium (a free mass that is pushed).
    pub fn linearised(&self, command: f64) -> Result<Linearised, ModelError> {
        let mut linear = LinearPart::of(self);
        let count = linear.coordinates.count;
        for i in count..MOST {
            // Coordinates that do not exist: any mass and stiffness keeps the matrices regular.
            (linear.mass[i][i], linear.stiffness[i][i]) = (1.0, 1.0);
        }
        let no_mass = || ModelError::BadParameter {
            name: "reflected_inertia".to_owned(),
            value: self.reflected_inertia,
            admitted: "positive and finite",
        };
        let inverse_mass = linear.inverse_mass::<MOST>().ok_or_else(no_mass)?;
        let at = self.equilibrium(&linear, command)?;
        let (stiffness, damping) = self.slopes(&linear, &at, command);
        let through = |matrix: &[Row; MOST], add: &[Row; MOST]| -> Vec<Vec<f64>> {
            let cell = |i: usize, j: usize| {
                (0..count).map(|k| inverse_mass[i][k] * (add[k][j] - matrix[k][j])).sum::<f64>()
            };
            (0..count).map(|i| (0..count).map(|j| cell(i, j)).collect()).collect()
        };
        let by_position = through(&linear.stiffness, &stiffness);
        let by_velocity = through(&linear.damping, &damping);
        let by_command: Vec<f64> = (0..count).map(|i| inverse_mass[i][0] * self.force_per_command).collect();

        // The spring's own slopes: the linear law and what departs from it.
        let delta = product(&linear.deflection, &at);
        let size = 1e-6 * delta.abs().max(1e-3);
        let k = self.stiffness
            + (self.departure(delta + size, 0.0) - self.departure(delta - size, 0.0)) / (2.0 * size);
        let c = self.laws.spring_damping
            + (self.departure(delta, size) - self.departure(delta, -size)) / (2.0 * size);
        let scaled =
            |factor: f64| -> Vec<f64> { linear.deflection[..count].iter().map(|d| factor * d).collect() };
        let force_1 = (scaled(k), scaled(c));
        let force_2 = match (self.series, linear.coordinates.screw_end) {
            (Some(series), Some(s)) => {
                let mut row = vec![0.0; count];
                row[s] = series.stiffness;
                if let Some(i) = linear.coordinates.link_2 {
                    row[i] -= series.stiffness;
                }
                (row, vec![0.0; count], 0.0)
            }
            _ => {
                let less = |force: &[f64], matrix: &[Vec<f64>]| -> Vec<f64> {
                    let moved = |j: usize| (0..count).map(|i| linear.sprung[i] * matrix[i][j]).sum::<f64>();
                    (0..count).map(|j| force[j] - self.sprung_mass * moved(j)).collect()
                };
                let pushed: f64 = (0..count).map(|i| linear.sprung[i] * by_command[i]).sum();
                (less(&force_1.0, &by_position), less(&force_1.1, &by_velocity), -self.sprung_mass * pushed)
            }
        };
        Ok(Linearised {
            count,
            link_2: linear.coordinates.link_2,
            by_position,
            by_velocity,
            by_command,
            force_1,
            force_2,
            deflection: scaled(1.0),
            at: at[..count].to_vec(),
        })
    }

    /// The spring's force beyond its linear law, damping included.
    fn departure(&self, delta: f64, rate: f64) -> f64 {
        self.spring_force(delta, rate, 0.0) - self.stiffness * delta - self.laws.spring_damping * rate
    }

    /// All smooth forces on the coordinates beside the linear part.
    fn beside(&self, linear: &LinearPart, q: &Row, v: &Row, command: f64) -> Row {
        let mut forces = [0.0; MOST];
        let (delta, rate) = (product(&linear.deflection, q), product(&linear.deflection, v));
        let departure = self.departure(delta, rate);
        for i in 0..MOST {
            forces[i] -= linear.deflection[i] * departure;
        }
        let load = self.spring_force(delta, rate, 0.0);
        forces[0] += self.motor_force(command, v[0]);
        forces[0] += self.laws.rotor_force(q[0], v[0], load, 0.0);
        let output = linear.coordinates.link_2.or(self.rigid.map(|_| 0));
        let Some(i) = output else { return forces };
        forces[i] += self.output_forces.iter().map(|f| f.force(q[i], v[i], load, 0.0)).sum::<f64>();
        if let Link::Pendulum { gravity_torque_nm, arm_m, .. } = self.rigid.unwrap_or(self.link_2) {
            let angle = q[i] / arm_m;
            let beyond = angle - angle.sin();
            forces[i] += gravity_torque_nm * beyond / arm_m;
            if let (Some(wobbling), Some(w)) = (self.wobbling, linear.coordinates.wobbling) {
                let weight = wobbling.mass * GRAVITY_M_S2;
                forces[w] += weight * beyond;
                forces[i] += weight * (wobbling.radius * beyond + q[w] * (1.0 - angle.cos())) / arm_m;
            }
        }
        forces
    }

    /// Slopes of [`Plant::beside`] per position and per velocity by central differences. What is linear leaves
    /// them exactly zero.
    fn slopes(&self, linear: &LinearPart, at: &Row, command: f64) -> ([Row; MOST], [Row; MOST]) {
        let mut slopes = ([[0.0; MOST]; MOST], [[0.0; MOST]; MOST]);
        for j in 0..linear.coordinates.count {
            let size = 1e-6 * at[j].abs().max(1e-3);
            let shifted = |of: &Row, by: f64| {
                let mut row = *of;
                row[j] += by;
                row
            };
            let still = [0.0; MOST];
            let position = |by: f64| self.beside(linear, &shifted(at, by), &still, command);
            let velocity = |by: f64| self.beside(linear, at, &shifted(&still, by), command);
            let (up, down) = (position(size), position(-size));
            let (fast, back) = (velocity(size), velocity(-size));
            for i in 0..MOST {
                slopes.0[i][j] = (up[i] - down[i]) / (2.0 * size);
                slopes.1[i][j] = (fast[i] - back[i]) / (2.0 * size);
            }
        }
        slopes
    }

    /// Where all forces balance under a constant command, by Newton's method from hanging and relaxed.
    fn equilibrium(&self, linear: &LinearPart, command: f64) -> Result<Row, ModelError> {
        let mut q = [0.0; MOST];
        let mut least_change = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let mut excess = self.beside(linear, &q, &[0.0; MOST], command);
            for i in 0..MOST {
                excess[i] -= product(&linear.stiffness[i], &q);
            }
            if excess.iter().all(|e| *e == 0.0) {
                return Ok(q);
            }
            let slopes = self.slopes(linear, &q, command).0;
            let mut tangent = LinearPart { mass: linear.stiffness, ..linear.clone() };
            for i in 0..MOST {
                for j in 0..MOST {
                    tangent.mass[i][j] -= slopes[i][j];
                }
            }
            let Some(inverse) = tangent.inverse_mass::<MOST>() else { break };
            let change: Row = std::array::from_fn(|i| product(&inverse[i], &excess));
            (0..MOST).for_each(|i| q[i] += change[i]);
            let size = |row: &Row| row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if !size(&q).is_finite() || size(&q) > 1e6 {
                break;
            }
            // Rounding ends the progress before the limit where stiffnesses are far apart.
            if size(&change) <= SETTLED * size(&q) || (size(&change) >= least_change && least_change < 1e-9) {
                return Ok(q);
            }
            least_change = size(&change);
        }
        Err(ModelError::BadParameter {
            name: "constant command".to_owned(),
            value: command,
            admitted: "one under which the bench comes to rest",
        })
    }
}

fn product(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
