//! Dry friction in and at all joints over a step, each found with the others acting: on rotors, in springs that slip, and at
//! the joints themselves.

use super::simulate::{Machine, State};
use sealegs_actuator::plant::{ElastoSlip, Laws, MOST_PRESLIDING, Plant, Sliding, Slip};

/// Sweeps over the frictions; two joints need about ten.
const MOST_SWEEPS: usize = 60;

/// Where a dry force acts: on a coordinate, against another one or the link before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    joint: usize,
    part: Part,
    on: usize,
    against: Option<usize>,
}

/// What of a joint rubs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Rotor,
    Spring,
    Output,
}

impl Place {
    /// All places of some drives, whose rotors have the coordinates `rotor`.
    pub fn of(drives: &[Plant], rotor: &[usize]) -> Vec<Self> {
        let mut places = Vec::new();
        for (joint, (plant, c)) in drives.iter().zip(rotor).enumerate() {
            let laws = &plant.laws;
            let parts = [
                (Part::Rotor, laws.rubs_at_rotor(), *c, None),
                (Part::Spring, laws.spring_slip.is_some() && *c != joint, *c, Some(joint)),
                (Part::Output, plant.output_friction > 0.0, joint, None),
            ];
            let acting = parts.into_iter().filter(|(_, acts, ..)| *acts);
            places.extend(acting.map(|(part, _, on, against)| Self { joint, part, on, against }));
        }
        places
    }

    /// The motion of this place, out of that of all coordinates.
    fn of_all(&self, all: &[f64]) -> f64 {
        all[self.on] - self.against.map_or(0.0, |i| all[i])
    }

    /// Adds a force here to those on all coordinates.
    pub fn push(&self, force: f64, all: &mut [f64]) {
        all[self.on] += force;
        if let Some(i) = self.against {
            all[i] -= force;
        }
    }

    /// Whether a force here holds a coordinate against the link before.
    pub fn holds(&self, coordinate: usize) -> bool {
        self.on == coordinate && self.against.is_none()
    }

    /// The elastic elements here.
    fn elements<'a>(&self, laws: &'a Laws) -> &'a [ElastoSlip] {
        match self.part {
            Part::Rotor => &laws.rotor_presliding,
            Part::Spring => laws.spring_slip.as_slice(),
            Part::Output => &[],
        }
    }
}

/// What friction remembers of a place.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rubbed {
    dry: f64,
    presliding: [f64; MOST_PRESLIDING],
    elastic: [f64; MOST_PRESLIDING],
    heat: f64,
}

impl Rubbed {
    /// Of all elastic elements, N.
    fn elastic(&self) -> f64 {
        self.elastic.iter().sum()
    }

    /// After the place has travelled so far, rad.
    fn advance(&mut self, elements: &[ElastoSlip], travel: f64) {
        for (force, element) in self.presliding.iter_mut().zip(elements) {
            *force = element.advance(*force, travel);
        }
        self.heat -= self.dry * travel;
    }
}

impl Machine {
    /// Finds all frictions over a step, and leaves as `load` what then passes from each drive to the links.
    pub(super) fn rub(&self, now: &mut State, h: f64) {
        now.friction.fill(0.0);
        self.transmit(now);
        for _ in 0..MOST_SWEEPS {
            let mut change = 0.0_f64;
            for n in 0..self.places.len() {
                let before = now.friction[n];
                let after = self.rubbing(now, n, h);
                change = change.max((after - before).abs() / (after.abs() + before.abs()).max(1e-12));
                now.friction[n] = after;
            }
            if change > 0.0 {
                self.transmit(now);
            }
            if change < 1e-12 {
                break;
            }
        }
    }

    /// The friction at a place over a step, N m, with those of the others as they are.
    fn rubbing(&self, now: &mut State, n: usize, h: f64) -> f64 {
        let place = &self.places[n];
        let (i, c) = (place.joint, place.on);
        let plant = &self.drives[i];
        let yielding = |by: usize| place.of_all(now.per_friction(by));
        let (mobility, v) = (h * yielding(n), place.of_all(&now.v));
        let beside = now.friction.iter().enumerate().filter(|(other, _)| *other != n);
        let others: f64 = beside.map(|(other, friction)| yielding(other) * friction).sum();
        let after_free = v + h * (place.of_all(now.free.as_slice()) + others);
        let (position, load, warmer_k) = (now.mid_q[c], now.load[i], now.warmer_k[i]);
        let of = &mut now.rubbed[n];
        for (k, element) in place.elements(&plant.laws).iter().enumerate() {
            let beside = of.dry + of.elastic() - of.elastic[k];
            let travel = 0.5 * h * (v + after_free + mobility * beside);
            of.elastic[k] = -element.mean_force(of.presliding[k], travel, 0.5 * h * mobility);
        }
        let sliding = Sliding { before: v, after_free: after_free + mobility * of.elastic(), mobility };
        let heat = of.heat;
        of.dry = match place.part {
            Part::Rotor if !plant.laws.rotor_friction.is_empty() => sliding.mean_force(|speed, direction| {
                plant.laws.rotor_friction_bound(&Slip { position, speed, direction, load, heat, warmer_k })
            }),
            Part::Output => sliding.mean_force(|_, _| plant.output_friction),
            _ => 0.0,
        };
        of.dry + of.elastic()
    }

    /// Writes the accelerations under the frictions as they are, rad/s^2, and what passes from each drive to the links, N m.
    fn transmit(&self, now: &mut State) {
        let mut accelerated = std::mem::take(&mut now.accelerated);
        accelerated.copy_from_slice(now.free.as_slice());
        for (n, friction) in now.friction.iter().enumerate() {
            accelerated.iter_mut().zip(now.per_friction(n)).for_each(|(a, by)| *a += by * friction);
        }
        now.accelerated = accelerated;
        let (by, mass) = (&now.accelerated, &now.equations.mass);
        for (i, c) in self.rotor.iter().enumerate() {
            now.load[i] = if *c == i {
                now.equations.bias[i] + (0..self.drives.len()).map(|j| mass[(i, j)] * by[j]).sum::<f64>()
            } else {
                now.passed[i].explicit + now.passed[i].implicit * (by[*c] - by[i])
            };
        }
        for (place, friction) in self.places.iter().zip(&now.friction) {
            if place.part == Part::Spring {
                now.load[place.joint] -= friction;
            }
        }
    }

    /// Lets the frictions remember a step in which the coordinates `travelled`.
    pub(super) fn remember(&self, now: &mut State) {
        for (place, rubbed) in self.places.iter().zip(&mut now.rubbed) {
            let elements = place.elements(&self.drives[place.joint].laws);
            rubbed.advance(elements, place.of_all(&now.travelled));
        }
    }
}
