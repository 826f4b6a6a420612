//! The signature of an effect: its law over its own argument, evaluated from the law that the integrator calls.
//!
//! An effect is put into a plant, and the places of the plant where it left something are evaluated: friction over the
//! speed or the load, a spring's force over its deflection, what is left of a command over the command. A new effect has
//! its picture unasked.

use super::setting::{ActuatorKind, Setting};
use crate::plant::{DeadZone, Link, Plant, Slip, SpringPath, Transmission};
use serde::Serialize;
use std::f64::consts::TAU;

/// Points of a curve.
const POINTS: usize = 400;

/// A change of a spring's force below this share of the force itself is drawn alone.
const SMALL: f64 = 0.2;

/// Between two points of a friction over the place it changes by less than this share of its range, or less of the way is
/// drawn: some six waves.
const WAVE: f64 = 0.05;

/// Most halvings of the way over which a friction is drawn.
const MOST_HALVINGS: usize = 40;

/// One axis of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GraphAxis {
    /// What it shows.
    pub name: String,
    /// In which SI unit; empty for a ratio.
    pub unit: String,
}

/// One curve of a [`Graph`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// What it is, where there are several.
    pub label: String,
    /// Its points in drawing order, in the axes' units.
    pub points: Vec<(f64, f64)>,
}

/// Curves over one argument, in SI units: a picture before it is drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Graph {
    /// What is shown.
    pub title: String,
    /// The argument.
    pub x: GraphAxis,
    /// The value.
    pub y: GraphAxis,
    /// The curves.
    pub curves: Vec<Curve>,
}

impl Graph {
    /// A graph without curves.
    #[must_use]
    pub fn new(title: &str, x: (&str, &str), y: (&str, &str)) -> Self {
        let axis = |(name, unit): (&str, &str)| GraphAxis { name: name.to_owned(), unit: unit.to_owned() };
        Self { title: title.to_owned(), x: axis(x), y: axis(y), curves: Vec::new() }
    }

    /// The graph with one more curve.
    #[must_use]
    pub fn curve(mut self, label: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.curves.push(Curve { label: label.to_owned(), points: points.into_iter().collect() });
        self
    }

    /// The graph with a curve of `y(x)` at evenly spaced `x`.
    #[must_use]
    pub fn sweep(self, label: &str, (from, to): (f64, f64), y: impl Fn(f64) -> f64) -> Self {
        self.curve(label, sweep(from, to).map(|x| (x, y(x))))
    }
}

/// Evenly spaced values. None of them is the middle, where laws of dry friction change their sign.
fn sweep(from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..POINTS).map(move |i| from + (to - from) * i as f64 / (POINTS - 1) as f64)
}

/// A plant before and after an effect was put into it.
struct Pair<'a> {
    without: &'a Plant,
    with: &'a Plant,
    setting: &'a Setting,
}

/// The law of the effect by which the plants differ, over its own argument; `None` if it left nothing.
pub(crate) fn law(without: &Plant, with: &Plant, setting: &Setting) -> Option<Graph> {
    let pair = Pair { without, with, setting };
    pair.command()
        .or_else(|| pair.strength())
        .or_else(|| pair.drive())
        .or_else(|| pair.friction())
        .or_else(|| pair.presliding())
        .or_else(|| pair.on_rotor())
        .or_else(|| pair.spring())
        .or_else(|| pair.series())
        .or_else(|| pair.transmission())
        .or_else(|| pair.mounting())
        .or_else(|| pair.sensor())
        .or_else(|| pair.on_output())
        .or_else(|| pair.output_friction())
        .or_else(|| pair.wobbling())
        .or_else(|| pair.load())
        .or_else(|| pair.feedback())
}

/// What a list has beyond another one.
fn new<'a, T: ?Sized>(without: &[Box<T>], with: &'a [Box<T>]) -> Option<&'a [Box<T>]> {
    with.get(without.len()..).filter(|new| !new.is_empty())
}

impl Pair<'_> {
    fn linear(&self) -> bool {
        self.setting.kind == ActuatorKind::Linear
    }

    fn force_unit(&self) -> &'static str {
        if self.linear() { "N" } else { "N m" }
    }

    fn length_unit(&self) -> &'static str {
        if self.linear() { "m" } else { "rad" }
    }

    fn speed_unit(&self) -> &'static str {
        if self.linear() { "m/s" } else { "rad/s" }
    }

    /// The lever of the output, m.
    fn arm(&self) -> Option<f64> {
        match self.with.rigid.unwrap_or(self.with.link_2) {
            Link::Pendulum { arm_m, .. } => Some(arm_m),
            _ => None,
        }
    }

    fn transmission(&self) -> Option<Graph> {
        let Transmission { stiffness, gap, .. } = self.with.transmission;
        if self.with.transmission == self.without.transmission {
            return None;
        }
        let play = DeadZone { half_gap: 0.5 * gap };
        let most = play.half_gap + 1.3 * self.setting.force() / stiffness;
        let force = |ahead: f64| stiffness * play.left(ahead);
        let across = ("rotor ahead of load", self.length_unit());
        let graph = Graph::new("Force in the transmission", across, ("force", self.force_unit()));
        Some(graph.sweep("", (-most, most), force))
    }

    fn command(&self) -> Option<Graph> {
        let stages = new(&self.without.laws.command_stages, &self.with.laws.command_stages)?;
        let most = 1.3 * self.setting.command();
        let given: Vec<f64> = sweep(-most, most).collect();
        let (mut time_s, mut values) = (vec![0.0; POINTS], given.clone());
        stages.iter().for_each(|stage| stage.apply(&mut time_s, &mut values));
        if values != given {
            let graph = Graph::new("What is left of a command", ("command", ""), ("acts", ""));
            return Some(graph.curve("", given.into_iter().zip(values)));
        }
        let delay_s = time_s[0];
        let given: Vec<f64> = sweep(-delay_s, 3.0 * delay_s).collect();
        let step = |t: &f64| f64::from(u8::from(*t >= 0.0));
        let (mut time_s, mut values) = (given.clone(), given.iter().map(step).collect::<Vec<f64>>());
        stages.iter().for_each(|stage| stage.apply(&mut time_s, &mut values));
        let graph = Graph::new("A step of the command", ("time", "s"), ("command over its step", ""));
        let graph = graph.curve("given", given.iter().map(|t| (*t, step(t))));
        Some(graph.curve("acts", time_s.into_iter().zip(values)))
    }

    /// What the motor gives of a force or torque that it is told.
    fn strength(&self) -> Option<Graph> {
        let (before, after) = (self.without.force_per_command, self.with.force_per_command);
        if after == before {
            return None;
        }
        let (most, unit) = (self.setting.command(), self.force_unit());
        let graph = Graph::new("What the motor gives", ("command", unit), ("force", unit));
        let graph = graph.sweep("as it is told", (-most, most), |u| before * u);
        Some(graph.sweep("with the effect", (-most, most), |u| after * u))
    }

    fn drive(&self) -> Option<Graph> {
        let limits = new(&self.without.laws.drive_limits, &self.with.laws.drive_limits)?;
        let (force, speed) = (self.setting.force(), self.setting.speed());
        let left = |asked: f64, y_dot: f64| limits.iter().fold(asked, |f, limit| limit.limit(f, y_dot));
        // A dead zone is small beside the greatest force: look where the change is.
        let most =
            if (left(0.1 * force, 0.0) - 0.1 * force).abs() > 0.02 * force { 0.3 } else { 1.3 } * force;
        let (unit, range) = (self.force_unit(), (-most, most));
        let graph = Graph::new("What is left of the motor's force", ("asked for", unit), ("left", unit));
        let graph = graph.sweep("at standstill", range, |f| left(f, 0.0));
        let depends = sweep(-most, most).any(|f| left(f, speed) != left(f, 0.0));
        if !depends {
            return Some(graph);
        }
        Some(graph.sweep(&format!("at {speed:.2} {}", self.speed_unit()), range, |f| left(f, speed)))
    }

    fn friction(&self) -> Option<Graph> {
        let laws = new(&self.without.laws.rotor_friction, &self.with.laws.rotor_friction)?;
        let bound = |slip: Slip| laws.iter().map(|law| law.bound(&slip)).sum::<f64>();
        let (force, speed, unit) = (self.setting.force(), self.setting.speed(), self.force_unit());
        let moving = Slip { speed: 0.5 * speed, direction: 1.0, load: 0.5 * force, ..Slip::default() };
        let heat = 4.0 * force * self.setting.length();
        if bound(moving) != bound(Slip { heat, ..moving }) {
            let graph = Graph::new("Friction while its heat grows", ("heat", "J"), ("friction", unit));
            return Some(graph.sweep("", (0.0, heat), |heat| bound(Slip { heat, ..moving })));
        }
        if bound(moving) != bound(Slip { warmer_k: 20.0, ..moving }) {
            let graph = Graph::new("Friction while the drive warms", ("above 25 C", "K"), ("friction", unit));
            return Some(graph.sweep("", (-20.0, 60.0), |warmer_k| bound(Slip { warmer_k, ..moving })));
        }
        let placed = |position: f64| bound(Slip { position, ..moving });
        if let Some(range) = self.range_of(placed) {
            let x = ("screw's extension", self.length_unit());
            let graph = Graph::new("Friction over the screw's place", x, ("friction", unit));
            return Some(graph.sweep("", (-range, range), placed));
        }
        if bound(moving) != bound(Slip { load: 0.9 * force, ..moving }) {
            let graph =
                Graph::new("Friction over the load", ("force in the screw", unit), ("friction", unit));
            let of = |direction: f64| move |load| direction * bound(Slip { direction, load, ..moving });
            let graph = graph.sweep("lengthening", (-force, force), of(1.0));
            return Some(graph.sweep("shortening", (-force, force), of(-1.0)));
        }
        let graph = Graph::new("Friction over speed", ("speed", self.speed_unit()), ("friction", unit));
        let at = |v: f64| v.signum() * bound(Slip { speed: v, direction: v.signum(), ..moving });
        Some(graph.sweep("", (-speed, speed), at))
    }

    /// How far to either side a friction is drawn over the place: the travel, or as much of it as shows single waves; `None`
    /// where the place does not matter.
    fn range_of(&self, placed: impl Fn(f64) -> f64) -> Option<f64> {
        let mut range = self.setting.travel();
        for _ in 0..MOST_HALVINGS {
            let values: Vec<f64> = sweep(-range, range).map(&placed).collect();
            let (low, high) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
            if low == high {
                return None;
            }
            let jump = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            if jump < WAVE * (high - low) {
                break;
            }
            range *= 0.5;
        }
        Some(range)
    }

    fn presliding(&self) -> Option<Graph> {
        let element = self.with.laws.rotor_presliding.get(self.without.laws.rotor_presliding.len())?;
        let (mut f, mut before) = (0.0, 0.0);
        let amplitude = 2.5 * element.bound / element.stiffness;
        let loops = (0..5 * POINTS / 4).map(|i| {
            let y = amplitude * (TAU * i as f64 / POINTS as f64).sin();
            f = element.advance(f, y - before);
            before = y;
            (y, f)
        });
        let (x, y) = (("screw's extension", self.length_unit()), ("friction", self.force_unit()));
        Some(Graph::new("Friction to and fro, from rest", x, y).curve("", loops))
    }

    fn on_rotor(&self) -> Option<Graph> {
        let forces = new(&self.without.laws.rotor_forces, &self.with.laws.rotor_forces)?;
        let of = |y: f64, v: f64, load: f64| forces.iter().map(|f| f.force(y, v, load, 0.0)).sum::<f64>();
        let (force, speed, unit) = (self.setting.force(), self.setting.speed(), self.force_unit());
        if of(0.0, speed, 0.5 * force) != of(0.0, 0.0, 0.5 * force) {
            let graph =
                Graph::new("Resistance over speed", ("speed", self.speed_unit()), ("resistance", unit));
            return Some(graph.sweep("", (-speed, speed), |v| -of(0.0, v, 0.5 * force)));
        }
        let turn = 0.5 * TAU;
        let graph = Graph::new("Force over one turn of the rotor", ("rotor angle", "rad"), ("force", unit));
        Some(graph.sweep("", (-turn, turn), |theta| of(theta * self.with.travel_per_rad, 0.0, 0.5 * force)))
    }

    /// What changes a spring's force, around a loop of the deflection.
    fn spring(&self) -> Option<Graph> {
        let (laws, old) = (&self.with.laws, &self.without.laws);
        let played = laws.spring_path.len() > old.spring_path.len();
        let slip = laws.spring_slip.filter(|_| old.spring_slip.is_none());
        let damped = laws.spring_damping != old.spring_damping;
        if !played && slip.is_none() && !damped && laws.spring_forces.len() == old.spring_forces.len() {
            return None;
        }
        let length = self.setting.length();
        // Around play the amplitude is four times the half of the gap.
        let gap = (1..2000).map(|i| length * 1e-3 * f64::from(i)).find(|d| self.left(*d) > 0.0);
        let amplitude = if played { 4.0 * gap.unwrap_or(length) } else { length };
        let rate = self.setting.speed() / length;
        let (mut f, mut before) = (0.0, 0.0);
        let (mut whole, mut plain) = (Vec::new(), Vec::new());
        for i in 0..=2 * POINTS {
            let (sin, cos) = (TAU * i as f64 / POINTS as f64).sin_cos();
            let (delta, delta_dot) = (amplitude * sin, amplitude * rate * cos);
            if let Some(element) = slip {
                f = element.advance(f, delta - before);
                before = delta;
            }
            // The second time around: the loop is closed.
            if i >= POINTS {
                whole.push((delta, self.with.spring_force(delta, delta_dot, 0.0) + f));
                plain.push((delta, self.without.spring_force(delta, delta_dot, 0.0)));
            }
        }
        let x = ("deflection", self.length_unit());
        let change: Vec<(f64, f64)> = whole.iter().zip(&plain).map(|(w, p)| (w.0, w.1 - p.1)).collect();
        let peak = |points: &[(f64, f64)]| points.iter().fold(0.0_f64, |m, p| m.max(p.1.abs()));
        if peak(&change) < SMALL * peak(&plain) && !played {
            let y = ("force beside the linear spring", self.force_unit());
            return Some(Graph::new("Force beside the linear spring", x, y).curve("", change));
        }
        let graph = Graph::new("Force over deflection", x, ("force", self.force_unit()));
        Some(graph.curve("linear spring", plain).curve("with the effect", whole))
    }

    /// What play leaves of a deflection, m.
    fn left(&self, deflection: f64) -> f64 {
        self.with.laws.spring_path.iter().fold(deflection, |d, path| path.left(d))
    }

    fn series(&self) -> Option<Graph> {
        let series = self.with.series.filter(|_| self.without.series.is_none())?;
        let (k, force) = (self.with.stiffness, self.setting.force());
        let x = ("spring and what lies behind it", self.length_unit());
        let graph = Graph::new("Force over the whole deflection", x, ("force", self.force_unit()));
        let forces = || sweep(-force, force);
        let graph = graph.curve("spring alone", forces().map(|f| (f / k, f)));
        Some(graph.curve("with the effect", forces().map(|f| (f / k + f / series.stiffness, f))))
    }

    /// How far a mounting moves per force that oscillates, over its frequency.
    fn mounting(&self) -> Option<Graph> {
        let Link::Mounted { mass_kg, stiffness_n_m, damping_n_s_m } = self.with.link_1 else { return None };
        if self.without.link_1 == self.with.link_1 {
            return None;
        }
        let own_hz = (stiffness_n_m / mass_kg).sqrt() / TAU;
        let moved = |hz: f64| {
            let w = TAU * hz;
            1.0 / (stiffness_n_m - mass_kg * w * w).hypot(damping_n_s_m * w)
        };
        let unit = if self.linear() { "m/N" } else { "rad/(N m)" };
        let graph = Graph::new("How far the mounting moves per force", ("frequency", "Hz"), ("motion", unit));
        Some(graph.sweep("", (0.0, 3.0 * own_hz), moved))
    }

    /// What a sensor shows of a step.
    fn sensor(&self) -> Option<Graph> {
        let stages = new(&self.without.laws.sensor_stages, &self.with.laws.sensor_stages)?;
        // A tenth of the time lies before the step.
        let shown = |span_s: f64| -> Vec<(f64, f64)> {
            let h = span_s / POINTS as f64;
            let time = |i: usize| h * (i as f64 - 0.1 * POINTS as f64);
            let mut values: Vec<f64> = (0..POINTS).map(|i| f64::from(u8::from(time(i) >= 0.0))).collect();
            stages.iter().for_each(|stage| stage.apply(&mut values, h));
            values.into_iter().enumerate().map(|(i, v)| (time(i), v)).collect()
        };
        // As long as the step is not yet shown to 2 %.
        let period = self.setting.seen.sample_period_s.max(1e-4);
        let settled = (0..12)
            .map(|i| period * 2.0_f64.powi(i))
            .find(|span| shown(*span).iter().skip(POINTS * 6 / 10).all(|(_, v)| (v - 1.0).abs() < 0.02));
        let graph = Graph::new("A step as the sensor shows it", ("time", "s"), ("shown over true", ""));
        Some(graph.curve("", shown(settled.unwrap_or(100.0 * period))))
    }

    fn on_output(&self) -> Option<Graph> {
        let forces = new(&self.without.output_forces, &self.with.output_forces)?;
        let of = |y: f64, v: f64| forces.iter().map(|f| f.force(y, v, 0.0, 0.0)).sum::<f64>();
        let (arm, speed, travel) = (self.arm(), self.setting.speed(), self.setting.travel());
        let lever = arm.unwrap_or(1.0);
        let turns = arm.is_some() || !self.linear();
        let y = if turns { ("torque on the output", "N m") } else { ("force on the output", "N") };
        if of(0.0, speed) != of(0.0, 0.0) {
            let x = ("output's speed", if turns { "rad/s" } else { "m/s" });
            let range = (-speed / lever, speed / lever);
            return Some(
                Graph::new("On the output over its speed", x, y)
                    .sweep("", range, |v| lever * of(0.0, v * lever)),
            );
        }
        let x = if turns { ("output's angle", "rad") } else { ("output's position", "m") };
        let range = (-travel / lever, travel / lever);
        Some(
            Graph::new("On the output over its position", x, y)
                .sweep("", range, |q| lever * of(q * lever, 0.0)),
        )
    }

    fn output_friction(&self) -> Option<Graph> {
        let bound = self.with.output_friction - self.without.output_friction;
        if bound == 0.0 {
            return None;
        }
        let (lever, speed) = (self.arm().unwrap_or(1.0), self.setting.speed());
        let graph =
            Graph::new("Friction over the joint's speed", ("joint speed", "rad/s"), ("friction", "N m"));
        Some(graph.sweep("", (-speed / lever, speed / lever), |v| v.signum() * bound * lever))
    }

    /// Apparent mass of `m w'' + 2 zeta w0 m w' + m w0^2 w = -m a` over the frequency of a shaken link.
    fn wobbling(&self) -> Option<Graph> {
        let mass = self.with.wobbling.filter(|_| self.without.wobbling.is_none())?;
        let (own_hz, zeta) = (mass.angular_frequency / TAU, mass.damping_ratio);
        let apparent = |hz: f64| {
            let r = hz / own_hz;
            // m (1 + r^2/(1 - r^2 + 2 i zeta r)): what the link feels over its acceleration.
            let (re, im) = (1.0 - r * r, 2.0 * zeta * r);
            let over = r * r / (re * re + im * im);
            mass.mass * (1.0 + over * re).hypot(over * im)
        };
        let graph =
            Graph::new("Apparent mass of an accelerated link", ("frequency", "Hz"), ("apparent mass", "kg"));
        Some(graph.sweep("", (0.0, 3.0 * own_hz), apparent))
    }

    /// The torque of gravity on a pendulum's load.
    fn load(&self) -> Option<Graph> {
        let weight = |plant: &Plant| match plant.rigid.unwrap_or(plant.link_2) {
            Link::Pendulum { gravity_torque_nm, .. } => Some(gravity_torque_nm),
            _ => None,
        };
        let (stated, with) = (weight(self.without)?, weight(self.with)?);
        if stated == with {
            return None;
        }
        let axes = (("joint angle", "rad"), ("torque of gravity", "N m"));
        let graph = Graph::new("Torque of gravity over the joint's angle", axes.0, axes.1);
        let range = (-TAU / 2.0, TAU / 2.0);
        let graph = graph.sweep("as stated", range, |q| -stated * q.sin());
        Some(graph.sweep("with the effect", range, |q| -with * q.sin()))
    }

    /// The position that a servo's loop sees.
    fn feedback(&self) -> Option<Graph> {
        let (with, without) = (self.with.servo?, self.without.servo?);
        let delay_s = with.feedback_delay_s - without.feedback_delay_s;
        if delay_s == 0.0 {
            return None;
        }
        let graph = Graph::new("A step as the servo's loop sees it", ("time", "s"), ("seen over true", ""));
        let step = |t: f64| f64::from(u8::from(t >= 0.0));
        let range = (-delay_s, 3.0 * delay_s);
        Some(graph.sweep("true", range, step).sweep("seen", range, |t| step(t - delay_s)))
    }
}
