//! An independent integrator of an actuator between two links, as the truth of tests: classical Runge-Kutta at
//! a fine step in the absolute positions of the masses, with dry friction as located events.
//!
//! It shares nothing with the product: no code, no coordinates, no scheme. Positions are absolute: sprung mass
//! `p`, screw's end `s`, link 1, link 2, wobbling mass `u`; the screw's extension is `s - p`.

mod friction;
mod sensor;

use sensor::Chain;
pub use sensor::SensorErrors;

/// What an end of the actuator is attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The world.
    Held,
    /// A free mass, kg.
    Mass(f64),
    /// A point mass (kg) at a distance (m) that a lever (m) turns, in gravity.
    Pendulum {
        /// kg.
        mass_kg: f64,
        /// Distance of the mass from the joint, m.
        length_m: f64,
        /// m.
        arm_m: f64,
    },
}

/// Gravitational acceleration, m/s^2.
const G: f64 = 9.81;

/// An actuator with everything that may act in it; what is zero or `None` is absent. SI, at the screw or, for
/// a rotary actuator, at the output.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Reflected rotor inertia.
    pub rotor: f64,
    /// Sprung mass.
    pub sprung: f64,
    /// Viscous damping of the rotor.
    pub damping: f64,
    /// Spring stiffness.
    pub stiffness: f64,
    /// Screw travel per rotor angle.
    pub travel_per_rad: f64,
    /// Motor force per command.
    pub force_per_command: f64,
    /// Spring side.
    pub link_1: End,
    /// Screw side.
    pub link_2: End,
    /// Coulomb friction of the rotor: force.
    pub coulomb: f64,
    /// Elastic presliding friction: force, stiffness.
    pub presliding: Option<[f64; 2]>,
    /// Stribeck friction: Coulomb and static level, velocity.
    pub stribeck: Option<[f64; 3]>,
    /// Load-dependent friction: coefficient.
    pub load_friction: f64,
    /// Direction-dependent friction: force, asymmetry.
    pub directed: Option<[f64; 2]>,
    /// Quadratic drag: coefficient.
    pub drag: f64,
    /// Torque ripple: amplitude, cycles per turn, phase.
    pub ripple: [f64; 3],
    /// Limit of the command.
    pub command_limit: f64,
    /// Voltage saturation: bus, resistance.
    pub voltage: Option<[f64; 2]>,
    /// Lateness of the command, s.
    pub command_delay_s: f64,
    /// Command quantisation: count, rounding (0 truncates, 1 rounds).
    pub count: Option<[f64; 2]>,
    /// Cubic stiffness.
    pub cubic: f64,
    /// Damping parallel to the spring.
    pub spring_damping: f64,
    /// Slipping element beside the spring: stiffness, force.
    pub spring_slip: Option<[f64; 2]>,
    /// Width of the dead zone.
    pub gap: f64,
    /// Spring between screw and link 2.
    pub series: Option<f64>,
    /// Dry friction at the output, referred to the axis.
    pub output_friction: f64,
    /// Wobbling mass: mass, radius, frequency in Hz, damping ratio.
    pub wobbling: Option<[f64; 4]>,
    /// Errors of the sensors.
    pub sensors: SensorErrors,
}

/// Signals at the time stamps of the command.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// Force on link 1.
    pub force_1: Vec<f64>,
    /// Force on link 2.
    pub force_2: Vec<f64>,
    /// Extension of the screw.
    pub extension: Vec<f64>,
    /// Deflection of the spring.
    pub deflection: Vec<f64>,
    /// Position of link 2 along the axis.
    pub link_2: Vec<f64>,
}

const MOST: usize = 5;
type Row = [f64; MOST];
const P: usize = 0;

#[derive(Clone, Copy)]
struct State {
    x: Row,
    v: Row,
    /// Forces of the presliding element and of the slipping element beside the spring.
    slip: [f64; 2],
}

/// What is fixed during a step: the command's force and how the dry contacts move.
#[derive(Clone, Copy)]
struct Frame {
    commanded: f64,
    mode: [friction::Mode; 2],
}

struct Machine<'a> {
    of: &'a Reference,
    count: usize,
    inverse_mass: [Row; MOST],
    /// Rows of extension and of link 2.
    extension: Row,
    link_2: Row,
    link_1: Option<usize>,
    screw_end: Option<usize>,
    wobbling: Option<usize>,
}

fn dot(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(a: &Row, factor: f64, b: &Row) -> Row {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

impl Reference {
    /// An actuator without effects between held ends, command in force.
    pub fn new(rotor: f64, sprung: f64, damping: f64, stiffness: f64) -> Self {
        Self {
            rotor,
            sprung,
            damping,
            stiffness,
            travel_per_rad: 1.0,
            force_per_command: 1.0,
            link_1: End::Held,
            link_2: End::Held,
            coulomb: 0.0,
            presliding: None,
            stribeck: None,
            load_friction: 0.0,
            directed: None,
            drag: 0.0,
            ripple: [0.0; 3],
            command_limit: f64::INFINITY,
            voltage: None,
            command_delay_s: 0.0,
            count: None,
            cubic: 0.0,
            spring_damping: 0.0,
            spring_slip: None,
            gap: 0.0,
            series: None,
            output_friction: 0.0,
            wobbling: None,
            sensors: SensorErrors::default(),
        }
    }

    /// The same with an effect of the catalogue, by its id and its values in the order of its card.
    ///
    /// # Panics
    ///
    /// For an id that it does not know.
    pub fn with(mut self, id: &str, values: &[f64]) -> Self {
        let (id, channel) = id.split_once('@').map_or((id, None), |(id, c)| (id, Some(c.to_owned())));
        match id {
            "coulomb-friction" => self.coulomb = values[0],
            "presliding-friction" => self.presliding = Some([values[0], values[1]]),
            "stribeck-friction" => self.stribeck = Some([values[0], values[1], values[2]]),
            "load-dependent-friction" => self.load_friction = values[0],
            "direction-dependent-friction" => self.directed = Some([values[0], values[1]]),
            "quadratic-drag" => self.drag = values[0],
            "torque-ripple" => self.ripple = [values[0], values[1], values[2]],
            "current-saturation" => self.command_limit = values[0],
            "voltage-saturation" => self.voltage = Some([values[0], values[1]]),
            "transport-delay" => self.command_delay_s = values[0],
            "command-quantisation" => self.count = Some([values[0], values[1]]),
            "hardening-spring" => self.cubic = values[0],
            "spring-damping" => self.spring_damping = values[0],
            "spring-hysteresis" => self.spring_slip = Some([values[0], values[1]]),
            "backlash" => self.gap = values[0],
            "series-compliance" => self.series = Some(values[0]),
            "structural-mode" => self.sensors.mode = Some([values[0], values[1], values[2]]),
            "sensor-lag" => self.sensors.lag = Some((channel, values[0])),
            "sensor-delay" => self.sensors.delay = Some((channel, values[0])),
            "output-friction" => {
                let arm = if let End::Pendulum { arm_m, .. } = self.link_2 { arm_m } else { 1.0 };
                self.output_friction = values[0] / arm;
            }
            "wobbling-mass" => self.wobbling = Some([values[0], values[1], values[2], values[3]]),
            other => panic!("the reference integrator does not know '{other}'"),
        }
        self
    }

    /// The signals at the times `n * period_s` under a command that is held from each sample to the next, with
    /// `substeps` steps of the integrator in a period. A sample shows the state just before its command acts.
    pub fn run(&self, period_s: f64, command: &[f64], substeps: usize) -> Outputs {
        let machine = Machine::new(self);
        let step = period_s / substeps as f64;
        let mut state = State { x: [0.0; MOST], v: [0.0; MOST], slip: [0.0; 2] };
        let mut chain = Chain::new(&self.sensors, step);
        let mut out = Outputs::default();
        for n in 0..command.len() {
            if n > 0 {
                for sub in 0..substeps {
                    let middle = (n as f64 - 1.0 + (sub as f64 + 0.5) / substeps as f64) * period_s;
                    let at = ((middle - self.command_delay_s) / period_s).floor().max(0.0) as usize;
                    let commanded = self.force_per_command * self.drive(command[at]);
                    let acceleration = machine.advance(&mut state, commanded, step);
                    chain.pass(machine.measure(&state, &acceleration));
                }
            } else {
                chain.begin();
            }
            let [force_1, force_2, extension, deflection, link_2] = chain.show();
            out.force_1.push(force_1);
            out.force_2.push(force_2);
            out.extension.push(extension);
            out.deflection.push(deflection);
            out.link_2.push(link_2);
        }
        out
    }

    /// What the drive makes of a command.
    fn drive(&self, command: f64) -> f64 {
        let limited = command.clamp(-self.command_limit, self.command_limit);
        match self.count {
            // As in the product, a whole number of counts is one whatever its last digit's rounding.
            Some([count, rounding]) => {
                limited.signum() * count * (limited.abs() / count + 0.5 * rounding + 1e-9).floor()
            }
            None => limited,
        }
    }
}

impl<'a> Machine<'a> {
    fn new(of: &'a Reference) -> Self {
        let mut count = 1;
        let mut next = |moves: bool| {
            moves.then(|| {
                count += 1;
                count - 1
            })
        };
        let screw_end = next(of.series.is_some() || of.link_2 != End::Held);
        let link_1 = next(of.link_1 != End::Held);
        let beyond = next(of.series.is_some() && of.link_2 != End::Held);
        let wobbling = next(of.wobbling.is_some_and(|w| w[0] > 0.0));
        let unit =
            |i: Option<usize>| -> Row { std::array::from_fn(|j| if i == Some(j) { 1.0 } else { 0.0 }) };
        let link_2 = if of.series.is_some() { unit(beyond) } else { unit(screw_end) };
        let extension = add(&unit(screw_end), -1.0, &unit(Some(P)));
        let mut mass = [[0.0; MOST]; MOST];
        let mut put = |m: f64, row: &Row| {
            for i in 0..MOST {
                for j in 0..MOST {
                    mass[i][j] += m * row[i] * row[j];
                }
            }
        };
        put(of.rotor, &extension);
        put(of.sprung, &unit(Some(P)));
        for (end, row) in [(of.link_1, unit(link_1)), (of.link_2, link_2)] {
            match end {
                End::Held => {}
                End::Mass(m) => put(m, &row),
                End::Pendulum { mass_kg, length_m, arm_m } => put(mass_kg * (length_m / arm_m).powi(2), &row),
            }
        }
        if of.series.is_some() {
            // The nut's share of the moving mass that the catalogue's card states.
            put(0.15 / 294.9 * (of.rotor + of.sprung), &unit(screw_end));
        }
        if let Some(w) = of.wobbling {
            put(w[0], &unit(wobbling));
        }
        Self { of, count, inverse_mass: invert(mass, count), extension, link_2, link_1, screw_end, wobbling }
    }

    /// The spring's force without its slipping element.
    fn spring(&self, state: &State) -> f64 {
        let of = self.of;
        let deflection = self.link_1.map_or(0.0, |i| state.x[i]) - state.x[P];
        let rate = self.link_1.map_or(0.0, |i| state.v[i]) - state.v[P];
        let left = if deflection > 0.5 * of.gap {
            deflection - 0.5 * of.gap
        } else if deflection < -0.5 * of.gap {
            deflection + 0.5 * of.gap
        } else {
            return 0.0;
        };
        of.stiffness * left + of.cubic * left.powi(3) + of.spring_damping * rate
    }

    /// Generalised forces without dry friction.
    fn forces(&self, state: &State, commanded: f64) -> Row {
        let of = self.of;
        let (x, v) = (&state.x, &state.v);
        let (y, y_dot) = (dot(&self.extension, x), dot(&self.extension, v));
        let mut motor = commanded;
        if let Some([bus, resistance]) = of.voltage {
            let k = of.force_per_command;
            let (low, high) = ((-bus - k * y_dot) / resistance, (bus - k * y_dot) / resistance);
            motor = k * (commanded / k).clamp(low, high);
        }
        let on_screw = motor - of.damping * y_dot - of.drag * y_dot.abs() * y_dot
            + of.ripple[0] * (of.ripple[1] * y / of.travel_per_rad + of.ripple[2]).sin()
            - state.slip[0];
        let mut q = [0.0; MOST];
        for i in 0..self.count {
            q[i] = on_screw * self.extension[i];
        }
        let spring = self.spring(state) + state.slip[1];
        q[P] += spring;
        if let Some(i) = self.link_1 {
            q[i] -= spring;
        }
        let x_2 = dot(&self.link_2, x);
        if let (Some(k), Some(s)) = (of.series, self.screw_end) {
            let force = k * (x[s] - x_2);
            q[s] -= force;
            q = add(&q, force, &self.link_2);
        }
        if let End::Pendulum { mass_kg, length_m, arm_m } = of.link_2 {
            let angle = x_2 / arm_m;
            let mut torque = -mass_kg * G * length_m * angle.sin();
            if let (Some([m, radius, hz, ratio]), Some(u)) = (of.wobbling, self.wobbling) {
                let w0 = std::f64::consts::TAU * hz;
                let w = x[u] - radius * angle;
                let w_dot = v[u] - radius * dot(&self.link_2, v) / arm_m;
                let held = m * w0 * (w0 * w + 2.0 * ratio * w_dot);
                // V = m g (radius (1 - cos) + w sin) with w = u - radius * angle.
                q[u] -= held + m * G * angle.sin();
                torque += radius * held - m * G * w * angle.cos();
            }
            q = add(&q, torque / arm_m, &self.link_2);
        }
        q
    }

    /// Rates of the two elastic elements: they creep no further once they slip.
    fn slip_rates(&self, state: &State) -> [f64; 2] {
        let held = |parameters: Option<[f64; 2]>, stiffness: usize, f: f64, speed: f64| match parameters {
            Some(p) if !(f.abs() >= p[1 - stiffness] && f * speed > 0.0) => p[stiffness] * speed,
            _ => 0.0,
        };
        let y_dot = dot(&self.extension, &state.v);
        let rate = self.link_1.map_or(0.0, |i| state.v[i]) - state.v[P];
        [held(self.of.presliding, 1, state.slip[0], y_dot), held(self.of.spring_slip, 0, state.slip[1], rate)]
    }

    /// Force 1, force 2, extension, deflection, position of link 2.
    fn measure(&self, state: &State, acceleration: &Row) -> [f64; 5] {
        let force_1 = self.spring(state) + state.slip[1];
        let x_2 = dot(&self.link_2, &state.x);
        let force_2 = match (self.of.series, self.screw_end) {
            (Some(k), Some(s)) => k * (state.x[s] - x_2),
            _ => force_1 - self.of.sprung * acceleration[P],
        };
        let deflection = self.link_1.map_or(0.0, |i| state.x[i]) - state.x[P];
        [force_1, force_2, dot(&self.extension, &state.x), deflection, x_2]
    }

    /// One Runge-Kutta step with everything in its mode.
    fn runge_kutta(&self, from: &State, frame: &Frame, h: f64) -> State {
        let slope = |s: &State| (s.v, self.accelerate(s, frame), self.slip_rates(s));
        let moved = |k: &(Row, Row, [f64; 2]), h: f64| State {
            x: add(&from.x, h, &k.0),
            v: add(&from.v, h, &k.1),
            slip: [from.slip[0] + h * k.2[0], from.slip[1] + h * k.2[1]],
        };
        let k1 = slope(from);
        let k2 = slope(&moved(&k1, 0.5 * h));
        let k3 = slope(&moved(&k2, 0.5 * h));
        let k4 = slope(&moved(&k3, h));
        let mean = |a: f64, b: f64, c: f64, d: f64| h / 6.0 * (a + 2.0 * (b + c) + d);
        let mut to = *from;
        for i in 0..self.count {
            to.x[i] += mean(k1.0[i], k2.0[i], k3.0[i], k4.0[i]);
            to.v[i] += mean(k1.1[i], k2.1[i], k3.1[i], k4.1[i]);
        }
        for i in 0..2 {
            to.slip[i] += mean(k1.2[i], k2.2[i], k3.2[i], k4.2[i]);
        }
        if let Some([bound, _]) = self.of.presliding {
            to.slip[0] = to.slip[0].clamp(-bound, bound);
        }
        if let Some([_, bound]) = self.of.spring_slip {
            to.slip[1] = to.slip[1].clamp(-bound, bound);
        }
        to
    }
}

/// The inverse of the leading block of a positive definite matrix, by Gauss and Jordan.
fn invert(mut a: [Row; MOST], count: usize) -> [Row; MOST] {
    let mut inverse = [[0.0; MOST]; MOST];
    for i in 0..count {
        inverse[i][i] = 1.0;
    }
    for c in 0..count {
        let pivot = a[c][c];
        assert!(pivot > 0.0, "coordinate {c} has no mass");
        for j in 0..count {
            a[c][j] /= pivot;
            inverse[c][j] /= pivot;
        }
        for i in (0..count).filter(|i| *i != c) {
            let factor = a[i][c];
            for j in 0..count {
                a[i][j] -= factor * a[c][j];
                inverse[i][j] -= factor * inverse[c][j];
            }
        }
    }
    inverse
}
