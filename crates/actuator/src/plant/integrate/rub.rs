//! Dry friction within a step: of the rotor and of the output, rigid and elastic, each found with the others acting.

use super::{Motion, State, Stepper, THIRD, dot};
use crate::plant::friction::Held;
use crate::plant::{MOST_PRESLIDING, Sliding, Slip};

/// Dry friction over one step.
#[derive(Clone, Copy, Default)]
pub(super) struct Friction {
    /// Of the rotor, dry and of the elastic elements, N.
    dry: f64,
    elastic: [f64; MOST_PRESLIDING],
    on_output: f64,
    rotor: Held,
    output: Held,
}

/// Sweeps over several frictions at once; the lumped model on a light link needs the most.
const MOST_SWEEPS: usize = 200;

impl Friction {
    /// Of all elastic elements, N.
    #[inline(always)]
    fn elastic(&self) -> f64 {
        self.elastic.iter().sum()
    }

    fn settled_since(&self, before: &Self) -> bool {
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-13 * (a.abs() + b.abs());
        close(self.dry, before.dry)
            && self.elastic.iter().zip(&before.elastic).all(|(a, b)| close(*a, *b))
            && close(self.on_output, before.on_output)
    }
}

impl<const N: usize> Stepper<'_, N> {
    /// Dry friction over the step, on the motion `free` without it.
    #[inline(always)]
    pub(super) fn rub(&self, from: &State<N>, free: &Motion<N>, plain: &Motion<N>) -> Friction {
        let plant = self.plant;
        let (q, v) = (&from.motion.position, &from.motion.velocity);
        let (to_position, to_velocity) = &self.propagator.by_force;
        let output = self.link_2.filter(|_| plant.output_friction > 0.0);
        let presliding = &plant.laws.rotor_presliding;
        let kinds = usize::from(self.has_rotor_friction) + usize::from(output.is_some()) + presliding.len();
        let mut load = if self.bound_feels.1 { self.load(from, &plain.plus(&from.beside)) } else { 0.0 };
        let mut friction = Friction { dry: from.dry, ..Friction::default() };
        // Each friction shifts the motion that the others see, and the load that a bound feels: they are found
        // in turn. The coupling is weak but for the lumped model.
        let sweeps = if kinds > 1 {
            MOST_SWEEPS
        } else if self.bound_feels.1 {
            3
        } else {
            1
        };
        for sweep in 0..sweeps {
            let before = friction;
            for (k, element) in presliding.iter().enumerate() {
                let others = free.position[0] - q[0]
                    + if sweep > 0 { to_position[0][0] * friction.dry } else { 0.0 }
                    + output.map_or(0.0, |i| to_position[0][i] * friction.on_output)
                    + to_position[0][0] * (friction.elastic() - friction.elastic[k]);
                friction.elastic[k] = -element.mean_force(from.presliding[k], others, to_position[0][0]);
            }
            if self.has_rotor_friction {
                let others = to_velocity[0][0] * friction.elastic()
                    + output.map_or(0.0, |i| to_velocity[0][i] * friction.on_output);
                let sliding = Sliding {
                    before: v[0],
                    after_free: free.velocity[0] + others,
                    mobility: to_velocity[0][0],
                };
                let position = q[0] + 0.5 * self.grid.step_s * v[0];
                let bound = |speed, direction| {
                    plant.laws.rotor_friction_bound(&Slip {
                        position,
                        speed,
                        direction,
                        load,
                        heat: from.heat,
                        warmer_k: from.warmer_k,
                    })
                };
                (friction.dry, friction.rotor) = if self.bound_feels.0 {
                    sliding.resolve(friction.dry.abs(), bound)
                } else {
                    sliding.resolve_constant(bound)
                };
            }
            if let Some(i) = output {
                let sliding = Sliding {
                    before: v[i],
                    after_free: free.velocity[i] + to_velocity[i][0] * (friction.dry + friction.elastic()),
                    mobility: to_velocity[i][i],
                };
                (friction.on_output, friction.output) =
                    sliding.resolve_constant(|_, _| plant.output_friction);
            }
            if sweeps > 1 {
                if self.bound_feels.1 {
                    let mut after = *free;
                    self.push(&mut after, 0, friction.dry + friction.elastic());
                    if let Some(i) = output {
                        self.push(&mut after, i, friction.on_output);
                    }
                    load = self.load(from, &after);
                }
                // The one elastic element has felt the dry frictions as they are.
                let felt = presliding.len() == 1
                    && friction.dry == before.dry
                    && friction.on_output == before.on_output
                    && !self.bound_feels.1;
                if sweep > 0 && (felt || friction.settled_since(&before)) {
                    break;
                }
            }
        }
        friction
    }

    /// Mean force in the screw over a step that ends with the motion `after`, N.
    #[inline(always)]
    fn load(&self, from: &State<N>, after: &Motion<N>) -> f64 {
        let (h, plant) = (self.grid.step_s, self.plant);
        if plant.rigid.is_some() {
            let (q, v) = (from.motion.position[0], from.motion.velocity[0]);
            let gained = (after.velocity[0] - v) * self.per_step;
            return plant.transmitted_force(q + 0.5 * h * v, gained);
        }
        let start = dot(&self.deflection, &from.motion.position);
        let travel = dot(&self.deflection, &after.position) - start;
        let delta = start + THIRD * (travel + 0.5 * h * dot(&self.deflection, &from.motion.velocity));
        let mut spring = plant.spring_force(delta, travel * self.per_step, from.time_s + 0.5 * h);
        if let Some(element) = plant.laws.spring_slip {
            spring += element.advance(from.spring_slip, 0.5 * travel);
        }
        let gained = dot(&self.sprung.row, &after.velocity) - dot(&self.sprung.row, &from.motion.velocity);
        spring - plant.sprung_mass * gained * self.per_step
    }

    /// Puts the friction that was found into the motion. Sticking is exact: what is held has no speed, and has
    /// not moved if it was at rest before.
    #[inline(always)]
    pub(super) fn apply(&self, from: &State<N>, friction: &Friction, next: &mut State<N>) {
        self.push(&mut next.motion, 0, friction.dry + friction.elastic());
        if let Some(i) = self.link_2.filter(|_| self.plant.output_friction > 0.0) {
            self.push(&mut next.motion, i, friction.on_output);
            next.motion.hold(i, friction.output, &from.motion);
        }
        next.motion.hold(0, friction.rotor, &from.motion);
        next.dry = friction.dry;
        next.heat = from.heat - friction.dry * (next.motion.position[0] - from.motion.position[0]);
        let travel = next.motion.position[0] - from.motion.position[0];
        for (k, element) in self.plant.laws.rotor_presliding.iter().enumerate() {
            next.presliding[k] = element.advance(from.presliding[k], travel);
        }
    }

    /// Adds the dry friction at the end of a step, which a measured force shows, to the other forces there.
    #[inline(always)]
    pub(super) fn rub_at_end(
        &self,
        from: &State<N>,
        next: &State<N>,
        friction: &Friction,
        forces: &mut [f64; N],
    ) {
        let (plant, v) = (self.plant, &next.motion.velocity);
        let mut dry = friction.dry;
        if self.has_rotor_friction && v[0] * from.motion.velocity[0] < 0.0 {
            let direction = v[0].signum();
            let load = self.load(from, &next.motion);
            let slip = Slip {
                position: next.motion.position[0],
                speed: v[0],
                direction,
                load,
                heat: from.heat,
                warmer_k: from.warmer_k,
            };
            dry = -direction * plant.laws.rotor_friction_bound(&slip);
        }
        forces[0] += dry - next.presliding.iter().sum::<f64>();
        let output = self.link_2.filter(|_| plant.output_friction > 0.0);
        if let Some(i) = output {
            let reversed = v[i] * from.motion.velocity[i] < 0.0;
            forces[i] += if reversed { -v[i].signum() * plant.output_friction } else { friction.on_output };
        }
        // What is held has no acceleration.
        let mut hold = |i: usize| {
            let a = &self.acceleration;
            let gained = dot(&a.by_position[i], &next.motion.position)
                + dot(&a.by_velocity[i], v)
                + dot(&a.by_force[i], forces);
            forces[i] -= gained / a.by_force[i][i];
        };
        if friction.rotor == Held::Yes {
            hold(0);
        }
        if let Some(i) = output.filter(|_| friction.output == Held::Yes) {
            hold(i);
        }
    }
}
