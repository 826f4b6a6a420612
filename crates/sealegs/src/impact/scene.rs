//! All drops of a sweep in one recording: the legs stand side by side and fall at once, and each quantity has one plot
//! with a line for every drop.

use super::Survival;
use crate::Result;
use crate::leg_scene;
use sealegs_leg::LegError;
use sealegs_leg::impact::{ImpactRow, ImpactTable};
use sealegs_leg::simulation::{Event, LegDescription, Observer, Sample};
use sealegs_recorder::recording as rec;
use sealegs_recorder::recording::{Cadence, RecordingWriter};

/// Distance from leg to leg, m: a leg of a human's size does not touch its neighbour.
const SPACING_M: f64 = 0.7;

/// Name, title and unit of what is plotted of each actuator.
const PER_ACTUATOR: [(&str, &str, &str); 4] = [
    ("force_1", "force on link 1, spring side", "N"),
    ("force_2", "force on link 2, screw side", "N"),
    ("deflection", "spring deflection", "mm"),
    ("stress", "bending stress of the beam", "MPa"),
];

/// Keeps a drop's motion, forces and events for [`record`].
#[derive(Debug, Default)]
pub struct DropRecorder {
    leg: Option<LegDescription>,
    cadence: Cadence,
    frames: Vec<rec::Frame>,
    events: Vec<(f64, rec::Level, String)>,
}

impl Observer for DropRecorder {
    fn start(&mut self, leg: &LegDescription) -> std::result::Result<(), LegError> {
        self.leg = Some(leg.clone());
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), LegError> {
        let due = self.cadence.due(sample.time_s);
        if due.nothing() {
            return Ok(());
        }
        self.cadence.took(sample.time_s, due);
        self.frames.push(rec::Frame {
            time_s: sample.time_s,
            scalars: if due.scalars { scalars(sample) } else { Vec::new() },
            poses: due.poses.then(|| leg_scene::poses(sample)),
        });
        Ok(())
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), LegError> {
        let (level, text) = leg_scene::line(event);
        self.events.push((event.time_s, level, text));
        Ok(())
    }
}

/// What is plotted of a sample: the ground's force, the base's height, then each actuator by [`PER_ACTUATOR`].
fn scalars(sample: &Sample) -> Vec<f64> {
    let mut out = vec![sample.ground.normal_force_n, sample.world_from_link[0].translation.z];
    for (a, stress) in sample.actuators.iter().zip(&sample.stresses_pa) {
        out.extend([a.force_1_n, a.force_2_n, 1e3 * a.deflection_m, 1e-6 * stress]);
    }
    out
}

/// Writes the drops of a table, each with its recorder, into one recording. `document` is the scenario.
///
/// # Errors
///
/// What the disk or the viewer does not take.
pub fn record(
    table: &ImpactTable,
    drops: &[DropRecorder],
    max_force_n: Option<f64>,
    document: &str,
    output: &rec::Output,
) -> Result<()> {
    let survival = Survival::of(table, max_force_n);
    let placed: Vec<Placed> =
        table.rows.iter().zip(drops).filter_map(|(row, drop)| Placed::new(row, drop, &survival)).collect();
    let mut writer = RecordingWriter::create(output, &scene(table, &placed, &survival, document))?;
    let mut events: Vec<_> = placed
        .iter()
        .flat_map(|p| {
            p.drop.events.iter().map(|(t, level, text)| (*t, *level, format!("{}: {text}", p.name)))
        })
        .collect();
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (time_s, level, text) in events {
        writer.event(time_s, level, text)?;
    }
    // All drops have one step and one duration: their frames are of the same times, unless a run stopped.
    let longest = placed.iter().map(|p| &p.drop.frames).max_by_key(|frames| frames.len());
    let members = placed.first().map_or(0, |p| p.drop.frames.first().map_or(0, |f| f.scalars.len()));
    let mut last: Vec<rec::Poses> = vec![rec::Poses::default(); placed.len()];
    for (i, at) in longest.into_iter().flatten().enumerate() {
        let own = |p: &Placed<'_>| p.drop.frames.get(i).map_or(&[][..], |f| f.scalars.as_slice()).to_vec();
        let of_drops: Vec<Vec<f64>> = placed.iter().map(own).collect();
        let scalar = |s: usize| of_drops.iter().map(move |d| d.get(s).copied().unwrap_or(f64::NAN));
        let scalars =
            if at.scalars.is_empty() { Vec::new() } else { (0..members).flat_map(scalar).collect() };
        let poses = at.poses.is_some().then(|| {
            let mut all = rec::Poses::default();
            for (p, last) in placed.iter().zip(&mut last) {
                if let Some(poses) = p.drop.frames.get(i).and_then(|f| f.poses.as_ref()) {
                    *last = p.moved(poses);
                }
                all.bodies.extend(&last.bodies);
                all.rods.extend(&last.rods);
                all.arrows.extend(&last.arrows);
            }
            all
        });
        writer.frame(&rec::Frame { time_s: at.time_s, scalars, poses })?;
    }
    Ok(writer.finish()?)
}

/// A drop at its place among the others.
struct Placed<'a> {
    name: String,
    drop: &'a DropRecorder,
    leg: &'a LegDescription,
    offset_m: [f64; 3],
}

impl<'a> Placed<'a> {
    fn new(row: &ImpactRow, drop: &'a DropRecorder, survival: &Survival) -> Option<Self> {
        let leg = drop.leg.as_ref()?;
        let height = survival.heights_m.iter().position(|h| *h == row.height_m)?;
        let spring = survival.springs.iter().position(|s| *s == row.spring)?;
        let (x, y) = (SPACING_M * height as f64, -SPACING_M * spring as f64);
        // Along the ground, so that every foot lands on it.
        let z = leg.ground.map_or(0.0, |g| {
            let normal = g.normal();
            -(normal[0] * x + normal[1] * y) / normal[2]
        });
        Some(Self { name: format!("{} {} m", row.spring, row.height_m), drop, leg, offset_m: [x, y, z] })
    }

    fn moved(&self, poses: &rec::Poses) -> rec::Poses {
        let at = |p: [f64; 3]| std::array::from_fn(|i| p[i] + self.offset_m[i]);
        let mut poses = poses.clone();
        poses.bodies.iter_mut().for_each(|b| b.position_m = at(b.position_m));
        poses.arrows.iter_mut().for_each(|a| a.origin_m = at(a.origin_m));
        for rod in &mut poses.rods {
            (rod.from_m, rod.to_m) = (at(rod.from_m), at(rod.to_m));
        }
        poses
    }
}

/// The legs side by side, springs in rows and heights in columns, and a plot for each quantity.
fn scene(table: &ImpactTable, placed: &[Placed<'_>], survival: &Survival, document: &str) -> rec::Scene {
    let mut whole = rec::Scene { name: format!("{}, all drops", table.scenario), ..rec::Scene::default() };
    for p in placed {
        let named = |name: &str| format!("{} {name}", p.name);
        let one = leg_scene::scene(p.leg, "");
        whole.bodies.extend(one.bodies.into_iter().map(|b| rec::Body { name: named(&b.name), ..b }));
        whole.rods.extend(one.rods.into_iter().map(|r| rec::Rod { name: named(&r.name), ..r }));
        whole.arrows.extend(one.arrows.into_iter().map(|a| rec::Arrow { name: named(&a.name), ..a }));
        if whole.ground.is_none() {
            let middle = |n: usize| 0.5 * SPACING_M * (n.max(1) - 1) as f64;
            let (x, y) = (middle(survival.heights_m.len()), -middle(survival.springs.len()));
            whole.ground = one.ground.map(|g| {
                let z = g.point_m[2] - (g.normal[0] * x + g.normal[1] * y) / g.normal[2];
                rec::Ground { point_m: [x, y, z], size_m: g.size_m + 2.0 * x.max(-y), ..g }
            });
        }
    }
    let drops: Vec<String> = placed.iter().map(|p| p.name.clone()).collect();
    let group = |name: String, title: String, unit: &str, tab: &str| rec::SeriesGroup {
        name,
        title,
        unit: unit.to_owned(),
        tab: tab.to_owned(),
        members: drops.clone(),
    };
    whole.series = vec![
        group("ground".to_owned(), "Ground, normal force".to_owned(), "N", "Ground"),
        group("base".to_owned(), "Height of the base".to_owned(), "m", "Ground"),
    ];
    for actuator in placed.first().map_or(&[][..], |p| p.leg.actuators.as_slice()) {
        let name = &actuator.name;
        whole.series.extend(PER_ACTUATOR.map(|(key, title, unit)| {
            group(format!("{name}/{key}"), format!("{name}, {title}"), unit, name)
        }));
    }
    let legs = "Springs stand in rows, the first in front on the left; heights in columns, the lowest first.";
    whole.documents = vec![
        rec::Document {
            name: "Survival".to_owned(),
            text: format!("{}\n{legs}\n", survival.text().trim_start()),
            markdown: false,
        },
        rec::Document {
            name: "Scenario".to_owned(),
            text: format!("```toml\n{document}\n```"),
            markdown: true,
        },
    ];
    whole
}
