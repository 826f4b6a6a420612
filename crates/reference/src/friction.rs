//! Dry friction: contacts that slip one way or stick, switched at located events.

use crate::effect::Rubbing;
use crate::machine::{Frame, MOST, Machine, P, Row, State, add, dot};

/// How a dry contact moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// There is no friction here.
    Free,
    /// At rest.
    Stick,
    /// In motion in this direction, +1 or -1.
    Slip(f64),
}

/// More events than this within one step would be chattering: the contact is then taken as sticking.
pub(crate) const MOST_EVENTS: usize = 12;

/// The first of the slipping contacts whose speed reverses in a step, with the fraction of the step that it takes, by
/// the contacts' speeds before and after.
pub(crate) fn first_reversal(modes: &[Mode], speeds: impl Fn(usize) -> (f64, f64)) -> Option<(usize, f64)> {
    let mut first: Option<(usize, f64)> = None;
    for (contact, mode) in modes.iter().enumerate() {
        let Mode::Slip(direction) = mode else { continue };
        let (before, after) = speeds(contact);
        if after * direction < 0.0 {
            let fraction = before / (before - after);
            if first.is_none_or(|(_, f)| fraction < f) {
                first = Some((contact, fraction));
            }
        }
    }
    first
}

impl Machine<'_> {
    fn row(&self, contact: usize) -> &Row {
        if contact == 0 { &self.extension } else { &self.link_2 }
    }

    fn has_friction(&self, contact: usize) -> bool {
        if contact == 0 { self.of.has_rotor_friction() } else { self.of.output_friction > 0.0 }
    }

    fn bound(&self, s: &State, contact: usize, speed: f64, direction: f64, load: f64) -> f64 {
        if contact == 1 {
            return self.of.output_friction;
        }
        let (y, warmer_k) = (dot(&self.extension, &s.x), self.warmer_k);
        self.of.rotor_bound(&Rubbing { y, speed, direction, load, warmer_k })
    }

    /// Acceleration under smooth forces `q` and contact forces `f`.
    fn under(&self, q: &Row, f: [f64; 2]) -> Row {
        let q = add(&add(q, f[0], &self.extension), f[1], &self.link_2);
        std::array::from_fn(|i| if i < self.count { dot(&self.inverse_mass[i], &q) } else { 0.0 })
    }

    /// Contact forces and acceleration. Contacts at rest either stick or, where `may_break`, are held within
    /// their bound.
    fn resolve(&self, s: &State, frame: &Frame, may_break: bool) -> ([f64; 2], Row) {
        let q = self.forces(s, frame.commanded);
        let mut f = [0.0; 2];
        let mut a = self.under(&q, f);
        if frame.mode == [Mode::Free; 2] {
            return (f, a);
        }
        let spring = self.spring(s) + s.slip[1];
        for _ in 0..400 {
            let before = f;
            for contact in 0..2 {
                let row = self.row(contact);
                let speed = dot(row, &s.v);
                let load = spring - self.of.sprung * a[P];
                match frame.mode[contact] {
                    Mode::Free => continue,
                    Mode::Slip(direction) => {
                        f[contact] = -direction * self.bound(s, contact, speed, direction, load);
                    }
                    Mode::Stick => {
                        let mobility: f64 =
                            (0..self.count).map(|i| row[i] * dot(&self.inverse_mass[i], row)).sum();
                        f[contact] -= dot(row, &a) / mobility;
                        if may_break {
                            let against = self.bound(s, contact, 0.0, -f[contact].signum(), load);
                            f[contact] = f[contact].clamp(-against, against);
                        }
                    }
                }
                a = self.under(&q, f);
            }
            if (f[0] - before[0]).abs() + (f[1] - before[1]).abs() <= 1e-13 * (f[0].abs() + f[1].abs()) {
                break;
            }
        }
        (f, a)
    }

    pub(crate) fn accelerate(&self, s: &State, frame: &Frame) -> Row {
        self.resolve(s, frame, false).1
    }

    /// How each contact moves from here on.
    fn modes(&self, s: &State, commanded: f64) -> [Mode; 2] {
        let mut mode = [0, 1].map(|contact| {
            let speed = dot(self.row(contact), &s.v);
            match self.has_friction(contact) {
                false => Mode::Free,
                true if speed == 0.0 => Mode::Stick,
                true => Mode::Slip(speed.signum()),
            }
        });
        if mode.contains(&Mode::Stick) {
            let (f, a) = self.resolve(s, &Frame { commanded, mode }, true);
            for contact in 0..2 {
                // What still accelerates at its bound breaks away.
                let pushed = dot(self.row(contact), &a);
                let moving = pushed.abs() > 1e-9 * (f[contact].abs() * self.inverse_mass[0][0] + 1e-9);
                if mode[contact] == Mode::Stick && moving {
                    mode[contact] = Mode::Slip(pushed.signum());
                }
            }
        }
        mode
    }

    /// Makes a contact's speed exactly zero.
    fn stop(&self, s: &mut State, contact: usize) {
        let row = *self.row(contact);
        let direction: Row =
            std::array::from_fn(|i| if i < self.count { dot(&self.inverse_mass[i], &row) } else { 0.0 });
        for _ in 0..3 {
            s.v = add(&s.v, -dot(&row, &s.v) / dot(&row, &direction), &direction);
        }
        // What rounding leaves goes where it is seen as zero.
        let i = (0..MOST).rev().find(|i| row[*i] != 0.0).unwrap_or(0);
        s.v[i] -= dot(&row, &s.v) / row[i];
    }

    /// Advances the state by `step` through all events within it; the acceleration at the end.
    pub(crate) fn advance(&self, state: &mut State, commanded: f64, step: f64) -> Row {
        let mut frame = Frame { commanded, mode: self.modes(state, commanded) };
        let mut left = step;
        let mut events = 0;
        loop {
            let next = self.runge_kutta(state, &frame, left);
            let speeds = |i| (dot(self.row(i), &state.v), dot(self.row(i), &next.v));
            let reversal = (events < MOST_EVENTS).then(|| first_reversal(&frame.mode, speeds)).flatten();
            let Some((contact, fraction)) = reversal else {
                *state = next;
                break;
            };
            events += 1;
            if fraction > 0.0 {
                *state = self.runge_kutta(state, &frame, fraction * left);
                left *= 1.0 - fraction;
            }
            self.stop(state, contact);
            let was = frame.mode[contact];
            frame.mode = self.modes(state, commanded);
            if fraction == 0.0 && frame.mode[contact] == was {
                frame.mode[contact] = Mode::Stick;
            }
        }
        for contact in 0..2 {
            if frame.mode[contact] == Mode::Stick {
                self.stop(state, contact);
            }
        }
        self.accelerate(state, &frame)
    }
}
