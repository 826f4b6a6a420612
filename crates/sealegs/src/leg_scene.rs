//! A leg's run as a recording: its scene before time begins, and a frame for every sample.

use crate::Result;
use sealegs_leg::robot::{Geometry, Shape};
use sealegs_leg::scenario::Scenario;
use sealegs_leg::simulation::{Event, EventLevel, LegDescription, Observer, Sample, Simulation};
use sealegs_leg::{LegError, RunResult};
use sealegs_recorder::recording as rec;
use sealegs_recorder::recording::{Color, RecordingWriter};

/// Force as drawn, m/N: 5 kN of ground force are as long as a shank.
const ARROW_M_PER_N: f64 = 1e-4;

/// Name, title, unit and tab of the series with one member for each actuator, and its name's ending.
const PER_ACTUATOR: [(&str, &str, &str, &str, &str); 7] = [
    ("force_1", "Force on link 1, spring side", "N", "Forces", "force_1_n"),
    ("force_2", "Force on link 2, screw side", "N", "Forces", "force_2_n"),
    ("deflection", "Spring deflection", "mm", "Springs", "deflection_mm"),
    ("stress", "Bending stress of the beams", "MPa", "Springs", "stress_mpa"),
    ("current", "Motor current", "A", "Motors", "current_a"),
    ("rotor_speed", "Rotor speed", "rad/s", "Motors", "rotor_speed_rad_s"),
    ("length", "Actuator length", "mm", "Motors", "length_mm"),
];

/// The scene of a leg; `document` is the scenario as it was run.
#[must_use]
pub fn scene(leg: &LegDescription, document: &str) -> rec::Scene {
    let color = |shape: &Shape| {
        let [r, g, b, _] = shape.color.unwrap_or([0.77, 0.78, 0.81, 1.0]);
        let byte = |v: f64| (255.0 * v).round().clamp(0.0, 255.0) as u8;
        Color::new(byte(r), byte(g), byte(b))
    };
    let bodies = leg.robot.links.iter().map(|link| rec::Body {
        name: link.name.clone(),
        shapes: (if link.visuals.is_empty() { &link.collisions } else { &link.visuals })
            .iter()
            .map(|shape| {
                let (t, q) = (shape.origin.translation, shape.origin.rotation.coords);
                rec::Shape::new(geometry(&shape.geometry), color(shape))
                    .at([t.x, t.y, t.z], [q.x, q.y, q.z, q.w])
            })
            .collect(),
    });
    let rods = leg.actuators.iter().map(|a| rec::Rod {
        name: a.name.clone(),
        radius_m: 0.012,
        full_scale_n: a.limits.rated_force.unwrap_or(2000.0),
    });
    let arrow = |name: String, color: Color| rec::Arrow { name, color, length_m_per_n: ARROW_M_PER_N };
    let arrows = leg
        .actuators
        .iter()
        .flat_map(|a| {
            [
                arrow(format!("{}_force_1", a.name), Color::BLUE),
                arrow(format!("{}_force_2", a.name), Color::ORANGE),
            ]
        })
        .chain([arrow("ground_force".to_owned(), Color::GREEN)]);
    let group = |name: &str, title: &str, unit: &str, tab: &str, members: Vec<String>| rec::SeriesGroup {
        name: name.to_owned(),
        title: title.to_owned(),
        unit: unit.to_owned(),
        tab: tab.to_owned(),
        members,
    };
    let joints = |ending: &str| leg.joints.iter().map(|j| format!("{j}_{ending}")).collect();
    let actuators = |ending: &str| leg.actuators.iter().map(|a| format!("{}_{ending}", a.name)).collect();
    let mut series = vec![
        group("ground", "Ground, normal force", "N", "Motion", vec!["foot_normal_force_n".to_owned()]),
        group("base", "Height of the base", "m", "Motion", vec!["base_height_m".to_owned()]),
        group("joint_angle", "Joint angles", "rad", "Motion", joints("angle_rad")),
        group("joint_speed", "Joint speeds", "rad/s", "Motion", joints("speed_rad_s")),
    ];
    series.extend(
        PER_ACTUATOR.map(|(name, title, unit, tab, ending)| group(name, title, unit, tab, actuators(ending))),
    );
    let energy = ["kinetic_j", "potential_change_j", "spring_j", "motor_work_j", "losses_j", "residual_j"];
    series.push(group("energy", "Energy and work", "J", "Energy", energy.map(str::to_owned).to_vec()));
    if !leg.drives.is_empty() {
        let members = leg.drives.iter().map(|d| format!("{d}_torque_nm")).collect();
        series.push(group("drive_torque", "Torque of position drives", "N m", "Motors", members));
    }
    rec::Scene {
        name: leg.scenario.clone(),
        bodies: bodies.collect(),
        rods: rods.collect(),
        arrows: arrows.collect(),
        ground: leg.ground.map(|g| rec::Ground {
            point_m: [0.0, 0.0, g.height_m],
            normal: g.normal(),
            size_m: 1.0,
        }),
        series,
        documents: vec![rec::Document {
            name: "Scenario".to_owned(),
            text: format!("```toml\n{document}\n```"),
            markdown: true,
        }],
    }
}

fn geometry(geometry: &Geometry) -> rec::Geometry {
    match geometry {
        Geometry::Box { half } => rec::Geometry::Box { size_m: half.map(|h| 2.0 * h) },
        Geometry::Cylinder { radius_m, length_m } => {
            rec::Geometry::Cylinder { length_m: *length_m, radius_m: *radius_m }
        }
        Geometry::Capsule { radius_m, length_m } => {
            rec::Geometry::Capsule { length_m: *length_m, radius_m: *radius_m }
        }
        Geometry::Sphere { radius_m } => rec::Geometry::Sphere { radius_m: *radius_m },
        Geometry::Mesh(mesh) => {
            rec::Geometry::Mesh { vertices_m: mesh.vertices.clone(), triangles: mesh.triangles.clone() }
        }
    }
}

/// The scalars of a sample, in the order of [`scene`]'s series.
fn scalars(sample: &Sample, potential_at_start_j: f64) -> Vec<f64> {
    let mut out = vec![sample.ground.normal_force_n, sample.world_from_link[0].translation.z];
    out.extend(&sample.joint_angles_rad);
    out.extend(&sample.joint_speeds_rad_s);
    let actuators = &sample.actuators;
    out.extend(actuators.iter().map(|a| a.force_1_n));
    out.extend(actuators.iter().map(|a| a.force_2_n));
    out.extend(actuators.iter().map(|a| 1e3 * a.deflection_m));
    out.extend(sample.stresses_pa.iter().map(|s| 1e-6 * s));
    out.extend(actuators.iter().map(|a| a.current_a));
    out.extend(actuators.iter().map(|a| a.rotor_speed_rad_s));
    out.extend(actuators.iter().map(|a| 1e3 * a.length_m));
    let e = &sample.energy;
    let losses = e.work_j() - e.motor_work_j;
    let change = e.potential_j - potential_at_start_j;
    out.extend([e.kinetic_j, change, e.spring_j, e.motor_work_j, losses, e.residual_j]);
    out.extend(&sample.drive_torques_nm);
    out
}

/// Where links, actuators and forces are in a sample, in the order of [`scene`].
pub(crate) fn poses(sample: &Sample) -> rec::Poses {
    let mut arrows = Vec::new();
    for a in &sample.actuators {
        let (from, to) = (a.end_1_m, a.end_2_m);
        let between: [f64; 3] = std::array::from_fn(|i| to[i] - from[i]);
        let length = between.iter().map(|d| d * d).sum::<f64>().sqrt();
        let unit = between.map(|d| d / length);
        // What the actuator does to the links: a compressed one pushes them apart.
        arrows.push(rec::ArrowState { origin_m: from, force_n: unit.map(|u| -u * a.force_1_n) });
        arrows.push(rec::ArrowState { origin_m: to, force_n: unit.map(|u| u * a.force_2_n) });
    }
    arrows.push(rec::ArrowState { origin_m: sample.ground.center_m, force_n: sample.ground.force_n });
    rec::Poses {
        bodies: sample
            .world_from_link
            .iter()
            .map(|p| {
                let (t, q) = (p.translation, p.rotation.coords);
                rec::Pose { position_m: [t.x, t.y, t.z], orientation: [q.x, q.y, q.z, q.w] }
            })
            .collect(),
        rods: sample
            .actuators
            .iter()
            .map(|a| rec::RodState { from_m: a.end_1_m, to_m: a.end_2_m, force_n: a.spring_force_n })
            .collect(),
        arrows,
    }
}

/// Streams a run into a recording.
pub struct LegRecorder {
    output: rec::Output,
    document: String,
    writer: Option<RecordingWriter>,
    potential_at_start_j: Option<f64>,
}

impl LegRecorder {
    /// A recorder that opens its output when the run starts.
    #[must_use]
    pub fn new(output: rec::Output, document: String) -> Self {
        Self { output, document, writer: None, potential_at_start_j: None }
    }

    /// Ends the recording: whole, or as stopped with the reason.
    ///
    /// # Errors
    ///
    /// If the disk or the viewer did not take it all.
    pub fn end(self, stopped: Option<&str>) -> std::result::Result<(), sealegs_recorder::RecorderError> {
        match (self.writer, stopped) {
            (Some(writer), None) => writer.finish(),
            (Some(writer), Some(reason)) => writer.stop(reason),
            (None, _) => Ok(()),
        }
    }
}

/// Runs a scenario to its end and records it.
///
/// ```no_run
/// use sealegs::recorder::recording::Output;
/// use sealegs::{ScenarioBuilder, leg_scene::record};
///
/// let scenario = ScenarioBuilder::new("thor-drop").build()?;
/// let (leg, result) = record(&scenario, Output::File("drop.rrd".into()))?;
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// What is wrong with the scenario or its robot, or what the disk or the viewer does not take.
pub fn record(scenario: &Scenario, output: rec::Output) -> Result<(LegDescription, RunResult)> {
    let document = toml::to_string_pretty(scenario).unwrap_or_default();
    let mut recorder = LegRecorder::new(output, document);
    let simulation = Simulation::new(scenario)?;
    let leg = simulation.leg().clone();
    let result = sealegs_leg::run_simulation(scenario, simulation, &mut recorder)?;
    recorder.end(result.stopped.as_deref())?;
    Ok((leg, result))
}

/// An event as a line of the text log.
pub(crate) fn line(event: &Event) -> (rec::Level, String) {
    let level = match event.level() {
        EventLevel::Info => rec::Level::Info,
        EventLevel::Warning => rec::Level::Warning,
        EventLevel::Error => rec::Level::Error,
    };
    let text = match event.subject.as_str() {
        "" => event.text.clone(),
        subject => format!("{subject}: {}", event.text),
    };
    (level, text)
}

fn failed(error: sealegs_recorder::RecorderError) -> LegError {
    LegError::Observer(error.to_string())
}

impl Observer for LegRecorder {
    fn start(&mut self, leg: &LegDescription) -> std::result::Result<(), LegError> {
        let scene = scene(leg, &self.document);
        self.writer = Some(RecordingWriter::create(&self.output, &scene).map_err(failed)?);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), LegError> {
        let at_start = *self.potential_at_start_j.get_or_insert(sample.energy.potential_j);
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let due = writer.due(sample.time_s);
        if due.nothing() {
            return Ok(());
        }
        let frame = rec::Frame {
            time_s: sample.time_s,
            scalars: if due.scalars { scalars(sample, at_start) } else { Vec::new() },
            poses: due.poses.then(|| poses(sample)),
        };
        writer.frame(&frame).map_err(failed)
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), LegError> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        let (level, text) = line(event);
        writer.event(event.time_s, level, text).map_err(failed)
    }
}
