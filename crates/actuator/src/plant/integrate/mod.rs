//! Integration in time: the linear part exactly by its exponential, the rest by its mean over the predicted
//! step, dry friction by projection.
//!
//! A linear plant under a command that is held is integrated exactly at any step. Smooth nonlinear forces are
//! taken at the mean position and speed of the step, predicted with what they did in the step before: the scheme
//! is of second order and needs each of them once. Friction switches within the step (see [`super::Sliding`]). The
//! step's matrices are constant, so that a step is two small matrix products.

mod rub;
mod state;

use super::laws::SpringStep;
use super::linear::{LinearPart, MOST, Propagator, Row};
use super::servo::{Loop, Past};
use super::{Feed, GRAVITY_M_S2, Grid, Link, MOST_PRESLIDING, Observer, Plant, Trace, WobblingMass};
use rub::Friction;
use sealegs_model::ModelError;
pub(super) use state::{Motion, State};

pub(super) fn simulate(
    plant: &Plant,
    grid: Grid,
    feed: Feed,
    observer: Option<&Observer>,
) -> Result<Trace, ModelError> {
    let linear = LinearPart::of(plant);
    match linear.coordinates.count {
        1 => Stepper::<1>::new(plant, &linear, grid)?.observed(observer).trace(feed),
        2 => Stepper::<2>::new(plant, &linear, grid)?.observed(observer).trace(feed),
        3 => Stepper::<3>::new(plant, &linear, grid)?.observed(observer).trace(feed),
        4 => Stepper::<4>::new(plant, &linear, grid)?.observed(observer).trace(feed),
        _ => Stepper::<MOST>::new(plant, &linear, grid)?.observed(observer).trace(feed),
    }
}

/// A plant with all that its steps on a grid have in common.
pub(super) struct Stepper<'a, const N: usize> {
    plant: &'a Plant,
    grid: Grid,
    propagator: Propagator<N>,
    /// One over the step, 1/s.
    per_step: f64,
    deflection: [f64; N],
    link_1: Option<usize>,
    link_2: Option<usize>,
    screw_end: Option<usize>,
    /// The coordinate on which forces on the output act: link 2's, or the only one of a drive without a spring.
    output: Option<usize>,
    gravity: Option<Gravity>,
    /// Accelerations per position, velocity and force, and the part of them that the sprung mass has.
    acceleration: Acceleration<N>,
    sprung: Sprung<N>,
    spring_is_linear: bool,
    /// Whether there is any force beside the linear part, the held command and friction; and whether any of them
    /// needs the mean motion of the step.
    has_forces: bool,
    needs_mean: bool,
    has_friction: bool,
    has_rotor_friction: bool,
    /// Whether the bound of the rotor's friction changes with speed, and with load.
    bound_feels: (bool, bool),
    /// What pulls the motion to a measured one.
    observer: Option<&'a Observer>,
}

struct Acceleration<const N: usize> {
    by_position: [[f64; N]; N],
    by_velocity: [[f64; N]; N],
    by_force: [[f64; N]; N],
}

struct Sprung<const N: usize> {
    row: [f64; N],
    by_position: [f64; N],
    by_velocity: [f64; N],
    by_force: [f64; N],
}

/// Gravity at link 2 beyond its linear stiffness.
struct Gravity {
    coordinate: usize,
    /// All weights times their distance from the joint over the lever's arm, N.
    force: f64,
    /// One over the lever's arm, 1/m.
    per_arm: f64,
    wobbling: Option<(usize, WobblingMass)>,
}

const THIRD: f64 = 1.0 / 3.0;

#[inline(always)]
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

/// `angle - sin(angle)` without cancellation.
#[inline]
fn sine_deficit(angle: f64) -> f64 {
    let square = angle * angle;
    if square > 0.1 {
        return angle - angle.sin();
    }
    // Five terms: the sixth is below the rounding of the first.
    const PARTS: [f64; 5] = [1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0];
    angle * PARTS.iter().rev().fold(0.0, |next, part| square * part * (1.0 - next))
}

impl<'a, const N: usize> Stepper<'a, N> {
    pub fn new(plant: &'a Plant, linear: &LinearPart, grid: Grid) -> Result<Self, ModelError> {
        let singular = || ModelError::BadParameter {
            name: "reflected_inertia".to_owned(),
            value: plant.reflected_inertia,
            admitted: "positive and finite",
        };
        let propagator = linear.propagator::<N>(grid.step_s).ok_or_else(singular)?;
        let inverse_mass = linear.inverse_mass::<N>().ok_or_else(singular)?;
        let cut = |row: &Row| -> [f64; N] { std::array::from_fn(|i| row[i]) };
        let at = linear.coordinates;
        let row = cut(&linear.sprung);
        let through = |matrix: &[Row; MOST]| -> [[f64; N]; N] {
            let cell = |i: usize, j: usize| -(0..N).map(|k| inverse_mass[i][k] * matrix[k][j]).sum::<f64>();
            std::array::from_fn(|i| std::array::from_fn(|j| cell(i, j)))
        };
        let acceleration = Acceleration {
            by_position: through(&linear.stiffness),
            by_velocity: through(&linear.damping),
            by_force: inverse_mass,
        };
        let of_sprung = |matrix: &[[f64; N]; N]| -> [f64; N] {
            std::array::from_fn(|j| (0..N).map(|i| row[i] * matrix[i][j]).sum())
        };
        let output = at.link_2.or(plant.rigid.map(|_| 0));
        let gravity = match (plant.rigid.unwrap_or(plant.link_2), output) {
            (Link::Pendulum { gravity_torque_nm, arm_m, .. }, Some(coordinate)) => {
                let wobbling = at.wobbling.zip(plant.wobbling);
                let more = wobbling.map_or(0.0, |(_, w)| w.mass * GRAVITY_M_S2 * w.radius);
                Some(Gravity {
                    coordinate,
                    force: (gravity_torque_nm + more) / arm_m,
                    per_arm: 1.0 / arm_m,
                    wobbling,
                })
            }
            _ => None,
        };
        let spring_is_linear = plant.laws.spring_is_linear();
        let needs_mean = !plant.laws.rotor_forces.is_empty()
            || !plant.output_forces.is_empty()
            || !plant.laws.drive_limits.is_empty()
            || !spring_is_linear
            || at.wobbling.is_some();
        let has_rotor_friction = !plant.laws.rotor_friction.is_empty();
        Ok(Self {
            plant,
            grid,
            propagator,
            per_step: 1.0 / grid.step_s,
            deflection: cut(&linear.deflection),
            link_1: at.link_1,
            link_2: at.link_2,
            screw_end: at.screw_end,
            output,
            sprung: Sprung {
                by_position: of_sprung(&acceleration.by_position),
                by_velocity: of_sprung(&acceleration.by_velocity),
                by_force: of_sprung(&acceleration.by_force),
                row,
            },
            acceleration,
            spring_is_linear,
            has_forces: needs_mean || gravity.is_some(),
            needs_mean,
            gravity,
            has_friction: has_rotor_friction
                || !plant.laws.rotor_presliding.is_empty()
                || (plant.output_friction > 0.0 && at.link_2.is_some()),
            has_rotor_friction,
            bound_feels: (
                plant.laws.rotor_friction.iter().any(|f| f.feels_speed()),
                plant.laws.rotor_friction.iter().any(|f| f.feels_load()),
            ),
            observer: None,
        })
    }

    /// The same with an observer that pulls the motion to a measured one.
    fn observed(self, observer: Option<&'a Observer>) -> Self {
        Self { observer, ..self }
    }

    /// At rest with all springs relaxed; a drive without a spring where its run begins, its load held there.
    pub fn rest(&self) -> State<N> {
        let still = Motion { position: [0.0; N], velocity: [0.0; N] };
        let mut motion = still;
        let parted_load = self.link_2.filter(|_| self.plant.is_parted());
        if self.plant.rigid.is_some() || parted_load.is_some() {
            (motion.position[0], motion.velocity[0]) = self.plant.start;
        }
        if let Some(load) = parted_load {
            (motion.position[load], motion.velocity[load]) = self.plant.start;
            motion.position[0] += self.plant.ahead_at_rest(motion.position[load]);
        }
        State {
            motion,
            beside: still,
            sprung_acceleration: 0.0,
            force_1: 0.0,
            motor: 0.0,
            limited: 0.0,
            dry: 0.0,
            presliding: [0.0; MOST_PRESLIDING],
            spring_slip: 0.0,
            pull: (0.0, 0.0),
            heat: 0.0,
            time_s: self.grid.start_s,
            warmer_k: 0.0,
            released: false,
        }
    }

    fn trace(&self, feed: Feed) -> Result<Trace, ModelError> {
        let mut trace = Trace::with_room(self.plant, self.grid);
        let mut state = self.rest();
        let mut servo = self.plant.servo.map(|servo| (servo, Loop::default()));
        self.note(&state, &mut trace);
        for n in 0..self.grid.steps {
            let mut command = feed.command(n);
            if let Some((servo, of)) = &mut servo {
                let (position, speed) = match servo.sees_rotor {
                    true => (&trace.screw_position[..], &trace.screw_speed[..]),
                    false => trace.output(),
                };
                let past = Past { position, speed, step_s: self.grid.step_s };
                command = servo.command(&feed.told(n), past, of);
            }
            state.released = feed.released(n);
            state.warmer_k = feed.warmer_k(n);
            state = self.step(&state, command, n);
            self.note(&state, &mut trace);
            if n % 1024 == 0 {
                self.check(&state, n)?;
            }
        }
        self.check(&state, self.grid.steps)?;
        Ok(trace)
    }

    pub fn check(&self, state: &State<N>, n: usize) -> Result<(), ModelError> {
        const NAMES: [&str; 2] = ["the screw's extension", "a link's position"];
        for i in 0..N {
            if !(state.motion.position[i].is_finite() && state.motion.velocity[i].is_finite()) {
                return Err(ModelError::NotFinite {
                    time_s: self.grid.time(n),
                    what: NAMES[i.min(1)].to_owned(),
                });
            }
        }
        Ok(())
    }

    /// The step from point `n` of the grid under a command, in its unit.
    #[inline(always)]
    pub fn step(&self, from: &State<N>, command: f64, n: usize) -> State<N> {
        let p = &self.propagator;
        let (q, v) = (&from.motion.position, &from.motion.velocity);
        let commanded = if from.released { 0.0 } else { self.plant.commanded_force(command) };
        // What the linear part and the unlimited motor make of the state.
        let mut plain = from.motion;
        for i in 0..N {
            plain.position[i] = dot(&p.position_from.0[i], q)
                + dot(&p.position_from.1[i], v)
                + p.by_force.0[i][0] * commanded;
            plain.velocity[i] = dot(&p.velocity_from.0[i], q)
                + dot(&p.velocity_from.1[i], v)
                + p.by_force.1[i][0] * commanded;
        }
        let mut next = State { motor: commanded, time_s: self.grid.time(n + 1), ..*from };
        if let Some(observer) = self.observer {
            let at_output = self.link_2.map_or((0.0, 0.0), |i| (q[i], v[i]));
            next.pull = observer.pull(n, (q[0], v[0]), at_output);
            self.push(&mut plain, 0, next.pull.0);
            if let Some(i) = self.link_2 {
                self.push(&mut plain, i, next.pull.1);
            }
        }
        let mut forces = [0.0; N];
        let mut departure = 0.0;
        let mut free = plain;
        if self.has_forces {
            (forces, departure) = self.forces(from, &plain, n, &mut next);
            for i in 0..N {
                free.position[i] += dot(&p.by_force.0[i], &forces);
                free.velocity[i] += dot(&p.by_force.1[i], &forces);
            }
        }
        next.motion = free;
        let mut friction = Friction::default();
        if self.has_friction {
            friction = self.rub(from, &free, &plain);
            self.apply(from, &friction, &mut next);
        }
        if self.needs_mean || self.bound_feels.1 {
            for i in 0..N {
                next.beside.position[i] = next.motion.position[i] - plain.position[i];
                next.beside.velocity[i] = next.motion.velocity[i] - plain.velocity[i];
            }
        }
        let delta = dot(&self.deflection, &next.motion.position);
        let rate = dot(&self.deflection, &next.motion.velocity);
        next.force_1 = self.plant.stiffness * delta + self.plant.laws.spring_damping * rate;
        if !self.spring_is_linear {
            if let Some(element) = self.plant.laws.spring_slip {
                next.spring_slip = element.advance(from.spring_slip, delta - dot(&self.deflection, q));
            }
            let force = self.plant.spring_force(delta, rate, next.time_s) + next.spring_slip;
            for i in 0..N {
                forces[i] -= self.deflection[i] * (force - next.force_1 - departure);
            }
            next.force_1 = force;
        }
        if self.screw_end.is_none() {
            forces[0] += commanded + next.pull.0;
            if let Some(i) = self.link_2 {
                forces[i] += next.pull.1;
            }
            if self.has_friction {
                self.rub_at_end(from, &next, &friction, &mut forces);
            }
            next.sprung_acceleration = dot(&self.sprung.by_position, &next.motion.position)
                + dot(&self.sprung.by_velocity, &next.motion.velocity)
                + dot(&self.sprung.by_force, &forces);
        }
        next
    }

    /// Mean forces over the step on every coordinate, N, without the linear part, the commanded force and dry
    /// friction; and the spring's departure from its linear law in them. The motor force that the drive leaves
    /// goes into `next`.
    #[inline(always)]
    fn forces(&self, from: &State<N>, plain: &Motion<N>, n: usize, next: &mut State<N>) -> ([f64; N], f64) {
        let (h, plant) = (self.grid.step_s, self.plant);
        let q = &from.motion.position;
        let mut forces = [0.0; N];
        if let Some(gravity) = &self.gravity {
            let i = gravity.coordinate;
            let angle = (q[i] + 0.5 * h * from.motion.velocity[i]) * gravity.per_arm;
            forces[i] += gravity.force * sine_deficit(angle);
            if let Some((j, w)) = gravity.wobbling {
                // Of the potential m g w sin(angle), whose linear part m g w angle the matrices have.
                let weight = w.mass * GRAVITY_M_S2;
                let displacement = q[j] + 0.5 * h * from.motion.velocity[j];
                forces[j] += weight * sine_deficit(angle);
                forces[i] += weight * displacement * (1.0 - angle.cos()) * gravity.per_arm;
            }
        }
        if !self.needs_mean {
            return (forces, 0.0);
        }
        let per_step = self.per_step;
        let mut mean = from.motion;
        for i in 0..N {
            let travel = plain.position[i] + from.beside.position[i] - q[i];
            // Of the parabola through position and speed at the start and the position at the end.
            mean.position[i] = q[i] + THIRD * (travel + 0.5 * h * from.motion.velocity[i]);
            mean.velocity[i] = travel * per_step;
        }
        let y_dot = mean.velocity[0];
        if !plant.laws.drive_limits.is_empty() && !from.released {
            next.limited = self.limited(next.motor, y_dot, from.limited) - next.motor;
            forces[0] += next.limited;
            next.motor += next.limited;
        } else {
            next.limited = 0.0;
        }
        let mut departure = 0.0;
        if !self.spring_is_linear {
            departure = self.departure(from, &mean);
            for i in 0..N {
                forces[i] -= self.deflection[i] * departure;
            }
        }
        if !plant.laws.rotor_forces.is_empty() {
            let spring = plant.stiffness * dot(&self.deflection, &mean.position)
                + plant.laws.spring_damping * dot(&self.deflection, &mean.velocity);
            let load = spring + departure - plant.sprung_mass * from.sprung_acceleration
                + plant.transmitted_force(q[0], -from.sprung_acceleration);
            let t = self.grid.time(n) + 0.5 * h;
            // As in a leapfrog: a force that changes fast with the angle neither feeds nor brakes the motion.
            let y = q[0] + 0.5 * h * from.motion.velocity[0];
            forces[0] += plant.laws.rotor_force(y, y_dot, load, t);
        }
        if let Some(i) = self.output.filter(|_| !plant.output_forces.is_empty()) {
            let (x, t) = (q[i] + 0.5 * h * from.motion.velocity[i], self.grid.time(n) + 0.5 * h);
            for force in &plant.output_forces {
                forces[i] += force.force(x, mean.velocity[i], from.force_1, t);
            }
        }
        (forces, departure)
    }

    /// What the drive's limits leave of a commanded force, N, at the mean speed that this makes: `y_dot` (m/s) foretells it with
    /// what the limits took in the step before, `before` (N). Where a command jumps into a limit that is far off, and the
    /// back-EMF with it. One secant: between the corners of a limit it is exact.
    #[inline(always)]
    fn limited(&self, commanded: f64, y_dot: f64, before: f64) -> f64 {
        let laws = &self.plant.laws;
        let first = laws.limited_force(commanded, y_dot);
        let off = first - commanded - before;
        if off == 0.0 {
            return first;
        }
        let per_force = self.per_step * self.propagator.by_force.0[0][0];
        let change = laws.limited_force(commanded, y_dot + per_force * off) - first;
        // A limit takes more from a faster drive, so that the slope is not positive.
        first + change / (1.0 - (change / off).min(0.0))
    }

    /// Mean force of the spring over the step beyond its linear law, N, positive in compression.
    #[inline(always)]
    fn departure(&self, from: &State<N>, mean: &Motion<N>) -> f64 {
        let over = SpringStep {
            start: dot(&self.deflection, &from.motion.position),
            mean: dot(&self.deflection, &mean.position),
            rate: dot(&self.deflection, &mean.velocity),
            step_s: self.grid.step_s,
            per_step: self.per_step,
        };
        let mut departure = self.plant.laws.spring_departure(self.plant.stiffness, &over, from.time_s);
        if let Some(element) = self.plant.laws.spring_slip {
            departure += element.advance(from.spring_slip, 0.5 * over.step_s * over.rate);
        }
        departure
    }

    /// Adds what a force on one coordinate does over a step, N.
    #[inline(always)]
    fn push(&self, motion: &mut Motion<N>, coordinate: usize, force: f64) {
        for j in 0..N {
            motion.position[j] += self.propagator.by_force.0[j][coordinate] * force;
            motion.velocity[j] += self.propagator.by_force.1[j][coordinate] * force;
        }
    }

    /// Writes the state at a point of the grid into the trace.
    #[inline(always)]
    fn note(&self, state: &State<N>, trace: &mut Trace) {
        let (q, v, plant) = (&state.motion.position, &state.motion.velocity, self.plant);
        let force_2 = match (plant.series, self.screw_end) {
            (Some(series), Some(i)) => series.stiffness * (q[i] - self.link_2.map_or(0.0, |j| q[j])),
            // Of a drive without a spring the sprung mass is none, and its place -y.
            _ if plant.rigid.is_some() => plant.transmitted_force(q[0], -state.sprung_acceleration),
            _ => state.force_1 - plant.sprung_mass * state.sprung_acceleration,
        };
        trace.screw_position.push(q[0]);
        trace.screw_speed.push(v[0]);
        trace.force_1.push(state.force_1);
        trace.force_2.push(force_2);
        trace.motor_force.push(state.motor);
        if self.observer.is_some() {
            trace.rotor_pull.push(state.pull.0);
            trace.output_pull.push(state.pull.1);
        }
        if N > 1 {
            trace.deflection.push(dot(&self.deflection, q));
        }
        if let Some(i) = self.link_2 {
            trace.link_2_position.push(q[i]);
            if plant.is_parted() {
                trace.link_2_speed.push(v[i]);
            }
        }
        if let Some(i) = self.link_1 {
            trace.link_1_position.push(q[i]);
        }
    }
}
