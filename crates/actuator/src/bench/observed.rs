//! A bench under an observer: which measured motions it is pulled to, and what is missing at each port.

use super::{Bench, BenchModel};
use crate::plant::{
    Grid, Observer, Plant, Pull, ReferenceMotion, Trace, observer_rate, rigid_observer_rate, sample, smoothed,
};
use sealegs_model::{Record, Signal, internal};
use std::sync::{Arc, Mutex};

/// Smoothed measurements of records, by the records' names.
#[derive(Debug)]
pub(super) struct Observed {
    runs: Vec<(String, Vec<(String, ReferenceMotion)>)>,
    /// The same on the grids of simulations, by record, channel and grid: every simulation asks for them again.
    on_grids: Mutex<Vec<OnGrid>>,
}

type OnGrid = ((String, String, u64, usize), Arc<ReferenceMotion>);

/// Channels that tell of the spring's force, with what divides them to a deflection: the stiffness where they are forces.
const SPRING: [(&str, bool); 5] = [
    ("spring_deflection_m", false),
    ("spring_deflection_rad", false),
    ("force_1_n", true),
    ("output_torque_nm", true),
    ("spring_torque_nm", true),
];

/// Channels that tell where the output of a drive without a spring is.
const OUTPUT: [&str; 3] = ["position_m", "joint_angle_rad", ROTOR];

/// The rotor's own.
const ROTOR: &str = "motor_angle_rad";

impl Observed {
    /// The motions that these records measured; `None` if one measured neither rotor nor spring, or of a drive without a
    /// spring (`rigid`) no position.
    pub fn of(records: &[&Record], rigid: bool) -> Option<Self> {
        let of_spring = |name: &str| SPRING.iter().any(|(s, _)| *s == name);
        let tells = |name: &str| {
            if rigid { OUTPUT.contains(&name) } else { name == ROTOR || of_spring(name) }
        };
        let runs = records
            .iter()
            .map(|record| {
                record.outputs.iter().any(|s| tells(&s.channel)).then_some(())?;
                let motions =
                    record.outputs.iter().map(|s| (s.channel.clone(), smoothed(&record.time_s, &s.values)));
                Some((record.name.clone(), motions.collect()))
            })
            .collect::<Option<Vec<_>>>()?;
        Some(Self { runs, on_grids: Mutex::default() })
    }

    /// A channel's motion on a simulation's grid.
    fn on_grid(&self, record: &Record, channel: &str, grid: &Grid) -> Option<Arc<ReferenceMotion>> {
        let key = (record.name.clone(), channel.to_owned(), grid.step_s.to_bits(), grid.steps);
        let known = |all: &Vec<OnGrid>| all.iter().find(|(k, _)| *k == key).map(|(_, m)| m.clone());
        // A thread that panicked while it held the lock leaves whole entries behind.
        let lock = || self.on_grids.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(motion) = known(&lock()) {
            return Some(motion);
        }
        let motion = Arc::new(self.channel(record, channel)?.curved(grid, &record.time_s));
        lock().push((key, motion.clone()));
        Some(motion)
    }

    fn channel(&self, record: &Record, channel: &str) -> Option<&ReferenceMotion> {
        let (_, motions) = self.runs.iter().find(|(name, _)| *name == record.name)?;
        motions.iter().find(|(name, _)| name == channel).map(|(_, motion)| motion)
    }

    /// The rotor's extension, m, from its encoder, else from the spring and the joint.
    fn rotor(&self, record: &Record, plant: &Plant, arm_m: Option<f64>) -> Option<ReferenceMotion> {
        if let Some(angle) = self.channel(record, ROTOR) {
            return Some(angle.scaled(plant.travel_per_rad));
        }
        let (spring, is_force) =
            SPRING.iter().find_map(|(name, force)| self.channel(record, name).map(|m| (m, *force)))?;
        let deflection = spring.scaled(if is_force { 1.0 / plant.stiffness } else { 1.0 });
        match arm_m {
            None => Some(deflection),
            Some(arm) => Some(deflection.plus(&self.channel(record, "joint_angle_rad")?.scaled(arm))),
        }
    }

    /// The measured output of a drive without a spring: its channel and m per unit of it.
    fn output(&self, record: &Record, plant: &Plant, arm_m: f64) -> Option<(&'static str, f64)> {
        let scales = [1.0, arm_m, plant.travel_per_rad];
        OUTPUT.into_iter().zip(scales).find(|(name, _)| self.channel(record, name).is_some())
    }

    /// The observer of a record's simulation; `None` if it has no motion to follow.
    pub fn observer(
        &self,
        record: &Record,
        plant: &Plant,
        grid: &Grid,
        model: &BenchModel,
    ) -> Option<Observer> {
        let arm_m =
            if let Bench::Pendulum(rig) = model.bench_of(&record.name) { Some(rig.arm_m) } else { None };
        let c = model.spec.coefficients();
        // Gains follow from nominal values: they must not change while a fit moves the parameters.
        let mass = c.total_mass();
        let load = model.bench_of(&record.name).links().1.mass_kg();
        if model.spec.is_rigid() {
            let (channel, scale) = self.output(record, plant, model.bench_of(&record.name).arm_m())?;
            let rate = rigid_observer_rate(grid.step_s, record.mean_period_s());
            let to = self.on_grid(record, channel, grid)?;
            // Where rotor and load move on their own, the one that was measured is pulled.
            return Some(match (plant.is_parted(), channel == ROTOR) {
                (true, true) => Observer { rotor: Some(Pull::on(to, scale, mass, rate)), output: None },
                (true, false) => Observer { rotor: None, output: Some(Pull::on(to, scale, load, rate)) },
                (false, _) => Observer { rotor: Some(Pull::on(to, scale, mass + load, rate)), output: None },
            });
        }
        let rate = |mass: f64| observer_rate(c.stiffness, mass, grid.step_s, record.mean_period_s());
        let rotor = match self.on_grid(record, ROTOR, grid) {
            Some(to) => Some(Pull::on(to, plant.travel_per_rad, mass, rate(mass))),
            None => self.rotor(record, plant, arm_m).map(|to| {
                let to = Arc::new(to.curved(grid, &record.time_s));
                Pull::on(to, 1.0, mass, rate(mass))
            }),
        };
        let output = arm_m.zip(self.on_grid(record, "joint_angle_rad", grid));
        let output = output.map(|(scale, to)| Pull { to, scale, stiffness: 0.0, damping: load * rate(load) });
        rotor.is_some().then_some(Observer { rotor, output })
    }

    /// What is missing at each port, at the record's time stamps.
    ///
    /// At the rotor: the observer's pull, and what the spring and the damper do not yet feel of it because the rotor lags
    /// behind its reference; the measured force in the place of the spring's, where there is one. At the spring: the
    /// measured force beyond that of the modelled spring at the measured deflection. At the output: the pull on it.
    pub fn missing(&self, record: &Record, plant: &Plant, trace: &Trace, arm_m: f64) -> Vec<Signal> {
        if trace.rotor_pull.is_empty() {
            return Vec::new();
        }
        let (grid, time_s) = (&trace.grid, &record.time_s);
        let at = |values: &[f64]| sample(values, grid, time_s, 0.0);
        let signal = |port: &str, values| Signal { channel: format!("{}{port}", internal::MISSING), values };
        if plant.rigid.is_some() || plant.is_parted() {
            let Some((channel, scale)) = self.output(record, plant, arm_m) else { return Vec::new() };
            if plant.is_parted() && channel != ROTOR {
                // The same balance seen from the load: what it lacks the rotor would have to bring.
                return vec![signal("rotor", crate::plant::pull_at(&trace.output_pull, grid, time_s))];
            }
            let speed = self.channel(record, channel).map_or(&[][..], |m| &m.speed);
            let v = at(&trace.screw_speed);
            let pull = crate::plant::pull_at(&trace.rotor_pull, grid, time_s);
            let damped = speed.iter().zip(&v).map(|(to, v)| plant.damping * (scale * to - v));
            return vec![signal("rotor", pull.iter().zip(damped).map(|(p, d)| p + d).collect())];
        }
        let arm = (!trace.link_2_position.is_empty()).then_some(arm_m);
        let Some(reference) = self.rotor(record, plant, arm) else { return Vec::new() };
        let (y, v) = (at(&trace.screw_position), at(&trace.screw_speed));
        let pull = crate::plant::pull_at(&trace.rotor_pull, grid, time_s);
        let force = at(&trace.force_1);
        let measured = ["force_1_n", "output_torque_nm"].iter().find_map(|c| self.channel(record, c));
        let has_encoder = self.channel(record, ROTOR).is_some();
        let (mut rotor, mut spring) = (Vec::with_capacity(y.len()), Vec::with_capacity(y.len()));
        for i in 0..y.len() {
            let lag = plant.stiffness * (reference.position[i] - y[i]);
            let damped = plant.damping * (reference.speed[i] - v[i]);
            let beyond = measured.map_or(lag, |m| m.position[i] - force[i]);
            rotor.push(pull[i] + damped + if has_encoder { beyond } else { lag });
            spring.push(beyond - lag);
        }
        let mut ports = vec![signal("rotor", rotor)];
        if measured.is_some() && has_encoder {
            ports.push(signal("spring", spring));
        }
        if arm.is_some() && self.channel(record, "joint_angle_rad").is_some() {
            let pull = crate::plant::pull_at(&trace.output_pull, grid, time_s);
            ports.push(signal("output", pull.iter().map(|f| f * arm_m).collect()));
        }
        ports
    }
}
