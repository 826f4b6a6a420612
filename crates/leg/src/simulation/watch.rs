//! Watching every step: greatest values, and events when something begins.

use super::sample::{Event, EventKind, LegDescription};
use crate::dynamics::contact::GroundInstant;
use crate::dynamics::coupling::ActuatorInstant;
use serde::Serialize;

/// A greatest magnitude with its sign and time.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Peak {
    /// The value with its sign.
    pub value: f64,
    /// When, s.
    pub time_s: f64,
}

impl Peak {
    fn look(&mut self, time_s: f64, value: f64) {
        if value.abs() > self.value.abs() {
            *self = Self { value, time_s };
        }
    }
}

/// Greatest values of one actuator.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ActuatorPeaks {
    /// Its name.
    pub name: String,
    /// Force on link 1, N.
    pub force_1_n: Peak,
    /// Force on link 2, N.
    pub force_2_n: Peak,
    /// Spring deflection, m.
    pub deflection_m: Peak,
    /// Bending stress of the beam, Pa; 0 for a spring without one.
    pub stress_pa: Peak,
    /// Current, A.
    pub current_a: Peak,
    /// Rotor speed, rad/s.
    pub rotor_speed_rad_s: Peak,
}

/// Greatest values of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Peaks {
    /// Normal force of the ground, N.
    pub ground_force_n: Peak,
    /// The actuators.
    pub actuators: Vec<ActuatorPeaks>,
}

/// A limit that is passed again sooner than this after it ended is the same event, s.
const QUIET_S: f64 = 0.05;

/// Whether something is going on, or was a moment ago.
#[derive(Debug, Clone, Copy, Default)]
struct Going {
    since: bool,
    last_s: f64,
}

impl Going {
    /// Whether something begins now.
    fn begins(&mut self, time_s: f64, now: bool) -> bool {
        if now {
            let begins = !self.since;
            *self = Self { since: true, last_s: time_s };
            return begins;
        }
        self.since &= time_s - self.last_s < QUIET_S;
        false
    }
}

/// What is going on now, per actuator.
#[derive(Debug, Clone, Copy, Default)]
struct ActuatorGoing {
    saturated: Going,
    rated: Going,
    yielded: Going,
    stroke: Going,
}

/// Looks at every step.
#[derive(Debug)]
pub(super) struct Watch {
    peaks: Peaks,
    going: Vec<ActuatorGoing>,
    stopped: Vec<Going>,
    touching: bool,
    begun: bool,
}

impl Watch {
    pub fn new(leg: &LegDescription) -> Self {
        let peaks =
            leg.actuators.iter().map(|a| ActuatorPeaks { name: a.name.clone(), ..Default::default() });
        Self {
            peaks: Peaks { ground_force_n: Peak::default(), actuators: peaks.collect() },
            going: vec![ActuatorGoing::default(); leg.actuators.len()],
            stopped: vec![Going::default(); leg.joints.len()],
            touching: false,
            begun: false,
        }
    }

    pub fn peaks(&self) -> &Peaks {
        &self.peaks
    }

    /// Looks at one instant; an event is reported when it begins, and again only after some quiet.
    #[allow(clippy::too_many_arguments)]
    pub fn look(
        &mut self,
        time_s: f64,
        leg: &LegDescription,
        instants: &[ActuatorInstant],
        saturated: &[bool],
        ground: &GroundInstant,
        stopped: impl Iterator<Item = usize>,
        events: &mut Vec<Event>,
    ) {
        let mut say = |kind: EventKind, subject: &str, text: String| {
            events.push(Event { time_s, kind, subject: subject.to_owned(), text });
        };
        if !self.begun {
            self.begun = true;
            for model in &leg.actuators {
                if let Some(finding) = &model.limits.static_finding {
                    say(EventKind::BeamRange, &model.name, finding.to_string());
                }
            }
        }
        self.peaks.ground_force_n.look(time_s, ground.normal_force_n);
        let touching = ground.touching > 0;
        if touching != self.touching {
            let (kind, text) = if touching {
                (EventKind::TouchDown, "the foot touches the ground")
            } else {
                (EventKind::LiftOff, "the foot leaves the ground")
            };
            say(kind, "", text.to_owned());
            self.touching = touching;
        }
        for (i, instant) in instants.iter().enumerate() {
            let model = &leg.actuators[i];
            let peak = &mut self.peaks.actuators[i];
            let stress = model.limits.stress_pa(instant.spring_force_n);
            peak.force_1_n.look(time_s, instant.force_1_n);
            peak.force_2_n.look(time_s, instant.force_2_n);
            peak.deflection_m.look(time_s, instant.deflection_m);
            peak.stress_pa.look(time_s, stress);
            peak.current_a.look(time_s, instant.current_a);
            peak.rotor_speed_rad_s.look(time_s, instant.rotor_speed_rad_s);
            let limits = &model.limits;
            let force = instant.force_1_n.abs().max(instant.force_2_n.abs());
            let going = &mut self.going[i];
            let name = &model.name;
            if going.saturated.begins(time_s, saturated[i]) {
                let text = format!("current at its limit: {:.2} A", instant.current_a);
                say(EventKind::Saturation, name, text);
            }
            let rated = limits.rated_force.unwrap_or(f64::INFINITY);
            if going.rated.begins(time_s, force > rated) {
                say(
                    EventKind::RatedForce,
                    name,
                    format!("past the rated force: {force:.0} N, rated {rated:.0} N"),
                );
            }
            let yielded = limits.yield_force.is_some_and(|l| instant.spring_force_n.abs() > l);
            if going.yielded.begins(time_s, yielded) {
                let (stress, limit) = (stress * 1e-6, limits.yield_stress_pa.unwrap_or(0.0) * 1e-6);
                say(
                    EventKind::Yield,
                    name,
                    format!("beam past yield: {stress:.0} MPa, strength {limit:.0} MPa"),
                );
            }
            if going.stroke.begins(time_s, !model.length.contains(instant.length_m)) {
                let (l, r) = (1e3 * instant.length_m, model.length);
                let (min, max) = (1e3 * r.min_m, 1e3 * r.max_m);
                let text = format!("out of stroke: {l:.1} mm long, from {min:.1} to {max:.1} mm allowed");
                say(EventKind::Stroke, name, text);
            }
        }
        let now: Vec<usize> = stopped.collect();
        for dof in 0..self.stopped.len() {
            if self.stopped[dof].begins(time_s, now.contains(&dof)) {
                say(EventKind::JointStop, &leg.joints[dof], "the joint is at its stop".to_owned());
            }
        }
    }
}
