//! Parts of a robot that do not move one another, as the legs on a base that stands: each is simulated by itself, and one with the
//! values of the latest whole run not again. A derivative by a parameter of one leg then costs one leg.

use super::RobotModel;
use super::observed::Pulls;
use super::simulate::{Course, JointTrace, Machine};
use crate::dynamics::equations::MovingBodies;
use sealegs_actuator::bench::Fed;
use sealegs_actuator::plant::{Feed, Grid, Plant};
use sealegs_model::{ModelError, Record};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, PoisonError};

/// Numbers of traces that are kept, 128 MB of them: the latest runs of a campaign of minutes.
const MOST_KEPT: usize = 16_000_000;

/// A run that is to be simulated.
pub(super) struct Asked<'a> {
    pub record: &'a Record,
    pub values: &'a [f64],
    /// Position and speed by joint.
    pub start: &'a [(f64, f64)],
    pub pulls: Option<&'a Pulls>,
    pub grid: Grid,
    /// What a joint's drive is told.
    pub told: &'a dyn Fn(usize, &Plant) -> Result<Fed, ModelError>,
}

/// The parts of a robot, by joints, with the latest runs of more than one; a copy begins without these.
#[derive(Debug)]
pub(super) struct Parts {
    joints: Vec<Vec<usize>>,
    latest: Mutex<Vec<Run>>,
}

impl Clone for Parts {
    fn clone(&self) -> Self {
        Self { joints: self.joints.clone(), latest: Mutex::default() }
    }
}

/// What tells a run from others of the same model: the record's name, a hash of its time and commands, and bits of the grid.
type Of = (String, [u64; 4]);

/// Of the time stamps and commands of a record: an experiment that is planned has one name with many commands.
fn hash(record: &Record) -> u64 {
    let mut hasher = DefaultHasher::new();
    let bits = |values: &[f64], hasher: &mut DefaultHasher| {
        values.iter().for_each(|v| hasher.write_u64(v.to_bits()))
    };
    bits(&record.time_s, &mut hasher);
    for input in &record.inputs {
        input.channel.hash(&mut hasher);
        bits(&input.values, &mut hasher);
    }
    hasher.finish()
}

/// A whole run.
#[derive(Debug)]
struct Run {
    of: Of,
    /// Part by part, what it depends on, in bits, and its joints' traces.
    parts: Vec<(Vec<u64>, Traces)>,
}

type Traces = Vec<Arc<JointTrace>>;

impl Parts {
    pub fn of(tree: &MovingBodies) -> Self {
        Self { joints: tree.parts(), latest: Mutex::default() }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Run>> {
        // A thread that panicked while it held the lock leaves whole entries behind.
        self.latest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The traces of the parts that have these values in the latest run.
    fn known(&self, of: &Of, bits: &[Vec<u64>]) -> Vec<Option<Traces>> {
        let latest = self.lock();
        let run = latest.iter().find(|run| run.of == *of);
        let part = |(i, bits): (usize, &Vec<u64>)| {
            run.filter(|run| run.parts[i].0 == *bits).map(|run| run.parts[i].1.clone())
        };
        bits.iter().enumerate().map(part).collect()
    }

    /// Keeps a whole run in the place of the one before, if there is room.
    fn keep(&self, of: Of, parts: Vec<(Vec<u64>, Traces)>) {
        let size = |run: &Run| -> usize {
            run.parts.iter().flat_map(|(_, traces)| traces).map(|trace| trace.numbers()).sum()
        };
        let run = Run { of, parts };
        let mut latest = self.lock();
        latest.retain(|other| other.of != run.of);
        if latest.iter().map(size).sum::<usize>() + size(&run) <= MOST_KEPT {
            latest.push(run);
        }
    }
}

impl RobotModel {
    /// The motion of all joints under their drives, which come back.
    ///
    /// # Errors
    ///
    /// Those of [`Machine::run`], and of what the drives are told.
    pub(super) fn moved(
        &self,
        asked: &Asked,
        drives: Vec<Plant>,
    ) -> Result<(Vec<Plant>, Traces), ModelError> {
        let tree = self.tree_at(asked.values);
        let parts = &self.parts.joints;
        if let [_] = &parts[..] {
            let all: Vec<usize> = (0..drives.len()).collect();
            return self.part_moved(asked, (&all, tree), drives);
        }
        let grid = asked.grid;
        let bits = [hash(asked.record), grid.start_s.to_bits(), grid.step_s.to_bits(), grid.steps as u64];
        let of = (asked.record.name.clone(), bits);
        let bits: Vec<Vec<u64>> = parts.iter().map(|part| self.bits(part, asked)).collect();
        let known = self.parts.known(&of, &bits);
        let is_new = known.iter().all(Option::is_none);
        let mut drives: Vec<Option<Plant>> = drives.into_iter().map(Some).collect();
        let mut done: Vec<Traces> = Vec::with_capacity(parts.len());
        for (part, known) in parts.iter().zip(known) {
            done.push(match known {
                Some(traces) => traces,
                None => {
                    let own = part.iter().filter_map(|joint| drives[*joint].take()).collect();
                    let (own, traces) = self.part_moved(asked, (part, tree.part(part)), own)?;
                    part.iter().zip(own).for_each(|(joint, drive)| drives[*joint] = Some(drive));
                    traces
                }
            });
        }
        let mut traces: Vec<Option<Arc<JointTrace>>> = vec![None; drives.len()];
        for (part, done) in parts.iter().zip(&done) {
            part.iter().zip(done).for_each(|(joint, trace)| traces[*joint] = Some(trace.clone()));
        }
        if is_new {
            self.parts.keep(of, bits.into_iter().zip(done).collect());
        }
        Ok((drives.into_iter().flatten().collect(), traces.into_iter().flatten().collect()))
    }

    /// The motion of some joints, the bodies that they move alone.
    fn part_moved(
        &self,
        asked: &Asked,
        (joints, tree): (&[usize], MovingBodies),
        drives: Vec<Plant>,
    ) -> Result<(Vec<Plant>, Traces), ModelError> {
        let fed = joints.iter().zip(&drives).map(|(joint, drive)| (asked.told)(*joint, drive));
        let fed = fed.collect::<Result<Vec<Fed>, ModelError>>()?;
        let feeds: Vec<Feed> = fed.iter().map(Fed::feed).collect();
        let start: Vec<(f64, f64)> = joints.iter().map(|joint| asked.start[*joint]).collect();
        let course = Course { joints, start: &start, feeds: &feeds, pulls: asked.pulls, grid: asked.grid };
        let damping = joints.iter().map(|joint| self.joints[*joint].damping).collect();
        let names: Vec<&str> = joints.iter().map(|joint| self.joints[*joint].name.as_str()).collect();
        let machine = Machine::new(tree, drives, damping);
        let traces = machine.run(&course, &names)?;
        Ok((machine.drives, traces.into_iter().map(Arc::new).collect()))
    }

    /// What a part's motion over a run depends on, in bits: start, and values of its drives and links.
    fn bits(&self, joints: &[usize], asked: &Asked) -> Vec<u64> {
        let mut bits = Vec::new();
        for joint in joints {
            let (position, speed) = asked.start[*joint];
            bits.extend([position.to_bits(), speed.to_bits()]);
            bits.extend(self.joints[*joint].at.iter().map(|i| asked.values[*i].to_bits()));
        }
        let links = self.links.iter().filter(|link| joints.contains(&link.body()));
        let loads = self.loads.iter().filter(|load| joints.contains(&load.body()));
        let at = links.flat_map(|link| link.at()).chain(loads.flat_map(|load| load.at()));
        bits.extend(at.map(|i| asked.values[i].to_bits()));
        bits
    }
}
