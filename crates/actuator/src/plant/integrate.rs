//! Integration in time: the linear part exactly by its exponential, the rest at the predicted midpoint,
//! dry friction by projection.
//!
//! A linear plant under a command that is held is integrated exactly at any step; smooth nonlinear forces
//! make the scheme second order; friction switches within the step (see `Sliding`). The step's matrices
//! are constant, so that a step is two small matrix products.

use super::linear::{LinearPart, MOST, Propagator, Row};
use super::{Grid, Link, Plant, Sliding, Trace};
use sealegs_model::ModelError;

pub(super) fn simulate(plant: &Plant, grid: Grid, commands: &[f64]) -> Result<Trace, ModelError> {
    let linear = LinearPart::of(plant);
    match linear.coordinates.count {
        1 => Stepper::<1>::new(plant, &linear, grid)?.run(commands),
        2 => Stepper::<2>::new(plant, &linear, grid)?.run(commands),
        3 => Stepper::<3>::new(plant, &linear, grid)?.run(commands),
        4 => Stepper::<4>::new(plant, &linear, grid)?.run(commands),
        _ => Stepper::<MOST>::new(plant, &linear, grid)?.run(commands),
    }
}

struct Stepper<'a, const N: usize> {
    plant: &'a Plant,
    grid: Grid,
    propagator: Propagator<N>,
    deflection: [f64; N],
    sprung: [f64; N],
    /// Change of position and of velocity over a step per newton in the spring beyond its linear law.
    by_spring: ([f64; N], [f64; N]),
    link_1: Option<usize>,
    link_2: Option<usize>,
    screw_end: Option<usize>,
    /// Coordinate, weight force and arm of a pendulum.
    gravity: Option<(usize, f64, f64)>,
    has_rotor_friction: bool,
}

/// Position and velocity at the end of a step.
#[derive(Clone, Copy)]
struct Motion<const N: usize> {
    position: [f64; N],
    velocity: [f64; N],
}

#[derive(Clone, Copy)]
struct State<const N: usize> {
    position: [f64; N],
    velocity: [f64; N],
    /// Acceleration of the sprung mass over the last step, m/s^2.
    sprung_acceleration: f64,
    /// Force of the elastic presliding element, N, positive after motion in the positive direction.
    presliding: f64,
    /// Force of the slipping element beside the spring, N, positive in compression.
    spring_slip: f64,
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

fn times<const N: usize>(a: &[[f64; N]; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| dot(&a[i], b))
}

impl<'a, const N: usize> Stepper<'a, N> {
    fn new(plant: &'a Plant, linear: &LinearPart, grid: Grid) -> Result<Self, ModelError> {
        let propagator = linear.propagator::<N>(grid.step_s).ok_or(ModelError::BadParameter {
            name: "reflected_inertia".to_owned(),
            value: plant.reflected_inertia,
            admitted: "positive and finite",
        })?;
        let cut = |row: &Row| -> [f64; N] { std::array::from_fn(|i| row[i]) };
        let deflection = cut(&linear.deflection);
        let at = linear.coordinates;
        let gravity = match (plant.link_2, at.link_2) {
            (Link::Pendulum { gravity_torque_nm, arm_m, .. }, Some(i)) => {
                let wobbling = plant.wobbling.map_or(0.0, |w| w.mass * super::GRAVITY_M_S2 * w.radius);
                Some((i, (gravity_torque_nm + wobbling) / arm_m, arm_m))
            }
            _ => None,
        };
        Ok(Self {
            plant,
            grid,
            by_spring: (
                times(&propagator.by_force.0, &deflection),
                times(&propagator.by_force.1, &deflection),
            ),
            propagator,
            deflection,
            sprung: cut(&linear.sprung),
            link_1: at.link_1,
            link_2: at.link_2,
            screw_end: at.screw_end,
            gravity,
            has_rotor_friction: !plant.rotor_friction.is_empty(),
        })
    }

    fn run(&self, commands: &[f64]) -> Result<Trace, ModelError> {
        let mut trace = Trace::with_room(self.plant, self.grid);
        let mut state = State {
            position: [0.0; N],
            velocity: [0.0; N],
            sprung_acceleration: 0.0,
            presliding: 0.0,
            spring_slip: 0.0,
        };
        self.note(&state, 0.0, &mut trace);
        for n in 0..self.grid.steps {
            let command = commands.get(n).copied().unwrap_or(0.0);
            let motor = self.plant.motor_force(command, state.velocity[0]);
            state = self.step(&state, motor, trace.force_1[n], n);
            self.note(&state, motor, &mut trace);
            if n % 1024 == 0 {
                self.check(&state, n)?;
            }
        }
        self.check(&state, self.grid.steps)?;
        Ok(trace)
    }

    fn check(&self, state: &State<N>, n: usize) -> Result<(), ModelError> {
        const NAMES: [&str; 2] = ["the screw's extension", "a link's position"];
        for i in 0..N {
            if !(state.position[i].is_finite() && state.velocity[i].is_finite()) {
                return Err(ModelError::NotFinite {
                    time_s: self.grid.time(n),
                    what: NAMES[i.min(1)].to_owned(),
                });
            }
        }
        Ok(())
    }

    /// One step; `force_1` is the spring's force at its start.
    #[inline(always)]
    fn step(&self, from: &State<N>, motor: f64, force_1: f64, n: usize) -> State<N> {
        let (h, plant) = (self.grid.step_s, self.plant);
        let (q, v) = (&from.position, &from.velocity);
        let load = force_1 - plant.sprung_mass * from.sprung_acceleration;

        let y_mid = q[0] + 0.5 * h * v[0];
        let t_mid = self.grid.time(n) + 0.5 * h;
        let mut on_rotor = motor;
        for force in &plant.rotor_forces {
            on_rotor += force.force(y_mid, v[0], load, t_mid);
        }

        let p = &self.propagator;
        let mut after = Motion { position: [0.0; N], velocity: [0.0; N] };
        for i in 0..N {
            after.position[i] = dot(&p.position_from.0[i], q) + dot(&p.position_from.1[i], v);
            after.velocity[i] = dot(&p.velocity_from.0[i], q) + dot(&p.velocity_from.1[i], v);
        }
        self.push(&mut after, 0, on_rotor);
        if let Some((i, weight_force, arm)) = self.gravity {
            // What linear stiffness leaves out of the pendulum's gravity.
            let angle = (q[i] + 0.5 * h * v[i]) / arm;
            self.push(&mut after, i, weight_force * (angle - angle.sin()));
        }

        if plant.spring_is_linear() {
            return self.finish(from, after, load);
        }
        // The spring's departure from its linear law at the predicted midpoint, then once more at the
        // midpoint that follows from it.
        let delta = dot(&self.deflection, q);
        let mut rate = dot(&self.deflection, v);
        let mut next = *from;
        for _ in 0..2 {
            let mid = delta + 0.5 * h * rate;
            let linear = plant.stiffness * mid + plant.spring_damping * rate;
            let mut departure = plant.spring_force(mid, rate) - linear;
            if let Some(element) = plant.spring_slip {
                departure += element.advance(from.spring_slip, 0.5 * h * rate);
            }
            let mut with_spring = after;
            for i in 0..N {
                with_spring.position[i] -= self.by_spring.0[i] * departure;
                with_spring.velocity[i] -= self.by_spring.1[i] * departure;
            }
            next = self.finish(from, with_spring, load);
            rate = (dot(&self.deflection, &next.position) - delta) / h;
        }
        if let Some(element) = plant.spring_slip {
            next.spring_slip = element.advance(from.spring_slip, h * rate);
        }
        next
    }

    /// Adds what a force on one coordinate does over a step, N.
    #[inline(always)]
    fn push(&self, after: &mut Motion<N>, coordinate: usize, force: f64) {
        for j in 0..N {
            after.position[j] += self.propagator.by_force.0[j][coordinate] * force;
            after.velocity[j] += self.propagator.by_force.1[j][coordinate] * force;
        }
    }

    /// Adds the dry friction to the motion without it and advances the state.
    #[inline(always)]
    fn finish(&self, from: &State<N>, free: Motion<N>, load: f64) -> State<N> {
        let (h, plant) = (self.grid.step_s, self.plant);
        let (q, v) = (&from.position, &from.velocity);
        let (to_position, to_velocity) = &self.propagator.by_force;
        let output = self.link_2.filter(|_| plant.output_friction > 0.0);
        let presliding = plant.rotor_presliding;
        let frictions = usize::from(self.has_rotor_friction)
            + usize::from(output.is_some())
            + usize::from(presliding.is_some());
        let mut after = free;
        if frictions > 0 {
            let (mut dry, mut elastic, mut on_output) = (0.0, 0.0, 0.0);
            // Each friction shifts the motion that the others see: they are found in turn. Within one
            // step the coupling is weak, so that a few sweeps settle it.
            for _ in 0..(if frictions == 1 { 1 } else { 4 }) {
                if let Some(element) = presliding {
                    // The element's mean force, linear in the travel over the step.
                    let others = free.position[0] - q[0]
                        + to_position[0][0] * dry
                        + output.map_or(0.0, |i| to_position[0][i] * on_output);
                    let half = 0.5 * element.stiffness;
                    elastic = -((from.presliding + half * others) / (1.0 + half * to_position[0][0]))
                        .clamp(-element.bound, element.bound);
                }
                if self.has_rotor_friction {
                    let others =
                        to_velocity[0][0] * elastic + output.map_or(0.0, |i| to_velocity[0][i] * on_output);
                    let sliding = Sliding {
                        before: v[0],
                        after_free: free.velocity[0] + others,
                        mobility: to_velocity[0][0],
                    };
                    dry = sliding
                        .mean_force(|speed, direction| plant.rotor_friction_bound(speed, direction, load));
                }
                if let Some(i) = output {
                    let sliding = Sliding {
                        before: v[i],
                        after_free: free.velocity[i] + to_velocity[i][0] * (dry + elastic),
                        mobility: to_velocity[i][i],
                    };
                    on_output = sliding.mean_force(|_, _| plant.output_friction);
                }
            }
            self.push(&mut after, 0, dry + elastic);
            if let Some(i) = output {
                self.push(&mut after, i, on_output);
            }
        }
        let mut next = *from;
        next.position = after.position;
        next.velocity = after.velocity;
        if self.has_rotor_friction {
            settle(&mut next, from, 0);
        }
        if let Some(i) = output {
            settle(&mut next, from, i);
        }
        if let Some(element) = presliding {
            next.presliding = element.advance(from.presliding, next.position[0] - q[0]);
        }
        next.sprung_acceleration = (dot(&self.sprung, &next.velocity) - dot(&self.sprung, v)) / h;
        next
    }

    /// Writes the state at a point of the grid into the trace.
    #[inline(always)]
    fn note(&self, state: &State<N>, motor: f64, trace: &mut Trace) {
        let (q, v, plant) = (&state.position, &state.velocity, self.plant);
        let delta = dot(&self.deflection, q);
        let rate = dot(&self.deflection, v);
        let force_1 = if plant.spring_is_linear() {
            plant.stiffness * delta + plant.spring_damping * rate
        } else {
            plant.spring_force(delta, rate) + state.spring_slip
        };
        let force_2 = match (plant.series, self.screw_end) {
            (Some(series), Some(i)) => series.stiffness * (q[i] - self.link_2.map_or(0.0, |j| q[j])),
            _ => force_1 - plant.sprung_mass * state.sprung_acceleration,
        };
        trace.screw_position.push(q[0]);
        trace.screw_speed.push(v[0]);
        trace.force_1.push(force_1);
        trace.force_2.push(force_2);
        trace.motor_force.push(motor);
        if N > 1 {
            trace.deflection.push(delta);
        }
        if let Some(i) = self.link_2 {
            trace.link_2_position.push(q[i]);
        }
        if let Some(i) = self.link_1 {
            trace.link_1_position.push(q[i]);
        }
    }
}

/// A velocity that friction has brought to rest up to rounding is rest, and what was at rest and stays so
/// has not moved: sticking is exact.
fn settle<const N: usize>(next: &mut State<N>, from: &State<N>, i: usize) {
    let size = from.velocity[i].abs() + (next.position[i] - from.position[i]).abs();
    if next.velocity[i].abs() <= 1e-12 * size || next.velocity[i].abs() < 1e-18 {
        next.velocity[i] = 0.0;
        if from.velocity[i] == 0.0 {
            next.position[i] = from.position[i];
        }
    }
}
