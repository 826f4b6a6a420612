//! Writes a recording of a leg that only pretends to walk, to look at how recordings open.
//!
//! `cargo run --release -p sealegs-recorder --example synthetic_leg -- leg.rrd [seconds]`
//!
//! Nothing here is physics: joints follow sines, forces are made up.

use sealegs_recorder::recording::{
    Arrow, ArrowState, Body, Color, Document, Frame, Geometry, Ground, Level, Output, Pose, Poses,
    RecordingWriter, Rod, RodState, Scene, SeriesGroup, Shape,
};

const JOINTS: [&str; 6] = ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"];
const ACTUATORS: [&str; 8] = [
    "hip_yaw_roll_left",
    "hip_yaw_roll_right",
    "hip_pitch_left",
    "hip_pitch_right",
    "knee_left",
    "knee_right",
    "ankle_left",
    "ankle_right",
];
const RATED_N: f64 = 2225.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "synthetic-leg.rrd".into());
    let seconds: f64 = arguments.next().map_or(Ok(10.0), |s| s.parse())?;
    let output = if file == "viewer" { Output::Viewer } else { Output::File(file.clone().into()) };
    let scene = scene();
    let begin = std::time::Instant::now();
    let mut writer = RecordingWriter::create(&output, &scene)?;
    let mut on_ground = false;
    for step in 0..=(seconds * 1e4) as usize {
        let time_s = step as f64 * 1e-4;
        let due = writer.due(time_s);
        if due.nothing() {
            continue;
        }
        let (poses, ground_n) = poses(time_s);
        if (ground_n > 0.0) != on_ground {
            on_ground = ground_n > 0.0;
            writer.event(
                time_s,
                Level::Info,
                if on_ground { "foot touches down" } else { "foot lifts off" },
            )?;
        }
        if step % 25_000 == 12_000 {
            writer.event(time_s, Level::Warning, "knee_left: current at its limit of 10 A")?;
        }
        if step == 33_000 {
            writer.event(time_s, Level::Error, "knee_right: 2310 N exceeds the rated 2225 N")?;
        }
        let scalars = if due.scalars { scalars(&scene, time_s, ground_n) } else { Vec::new() };
        writer.frame(&Frame { time_s, scalars, poses: due.poses.then_some(poses) })?;
    }
    writer.finish()?;
    println!("{file}: {:.2} s to write", begin.elapsed().as_secs_f64());
    if let Ok(data) = std::fs::metadata(&file) {
        println!("{:.2} MB for {seconds} s", data.len() as f64 / 1e6);
    }
    Ok(())
}

fn scene() -> Scene {
    let limb = |name: &str, length_m: f64, radius_m: f64| Body {
        name: name.into(),
        shapes: vec![
            Shape::new(Geometry::Capsule { length_m, radius_m }, Color::LIGHT_GREY)
                .at([0.0, 0.0, -0.5 * length_m], [0.0, 0.0, 0.0, 1.0]),
            Shape::new(Geometry::Sphere { radius_m: 1.35 * radius_m }, Color::GREY),
        ],
    };
    let wedge = Geometry::Mesh {
        vertices_m: vec![
            [0.14, -0.05, -0.02],
            [0.14, 0.05, -0.02],
            [0.18, -0.05, -0.04],
            [0.18, 0.05, -0.04],
            [0.14, -0.05, -0.04],
            [0.14, 0.05, -0.04],
        ],
        triangles: vec![[0, 2, 3], [0, 3, 1], [0, 4, 2], [1, 3, 5], [2, 4, 5], [2, 5, 3]],
    };
    let group = |tab: &str, name: &str, title: &str, unit: &str, suffix: &str, of: &[&str]| SeriesGroup {
        name: name.into(),
        title: title.into(),
        unit: unit.into(),
        tab: tab.into(),
        members: of.iter().map(|m| format!("{m}{suffix}")).collect(),
    };
    let six = &ACTUATORS[2..8];
    Scene {
        name: "synthetic leg".into(),
        bodies: vec![
            Body {
                name: "pelvis".into(),
                shapes: vec![Shape::new(Geometry::Box { size_m: [0.16, 0.22, 0.10] }, Color::GREY)],
            },
            limb("thigh", 0.40, 0.035),
            limb("shank", 0.40, 0.030),
            Body {
                name: "foot".into(),
                shapes: vec![
                    Shape::new(Geometry::Box { size_m: [0.22, 0.10, 0.03] }, Color::LIGHT_GREY)
                        .at([0.03, 0.0, -0.025], [0.0, 0.0, 0.0, 1.0]),
                    Shape::new(wedge, Color::GREY),
                    Shape::new(Geometry::Cylinder { length_m: 0.09, radius_m: 0.03 }, Color::GREY).at(
                        [0.0; 3],
                        [std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2],
                    ),
                ],
            },
        ],
        rods: ACTUATORS
            .iter()
            .map(|a| Rod { name: (*a).into(), radius_m: 0.011, full_scale_n: RATED_N })
            .collect(),
        arrows: [
            ("knee_force_1", Color::SKY_BLUE),
            ("knee_force_2", Color::YELLOW),
            ("ground_force", Color::GREEN),
        ]
        .into_iter()
        .map(|(name, color)| Arrow { name: name.into(), color, length_m_per_n: 0.0002 })
        .collect(),
        ground: Some(Ground { point_m: [0.0; 3], normal: [-0.05, 0.0, 1.0], size_m: 2.0 }),
        series: vec![
            group("Joints", "joints/angle", "Joint angle", "rad", "_angle_rad", &JOINTS),
            group("Joints", "joints/speed", "Joint speed", "rad/s", "_speed_rad_s", &JOINTS),
            group("Joints", "joints/torque", "Joint torque", "N m", "_torque_nm", &JOINTS),
            group("Forces", "forces/link_1", "Force on link 1, F1", "N", "_force_1_n", six),
            group("Forces", "forces/link_2", "Force on link 2, F2", "N", "_force_2_n", six),
            group("Springs", "deflection", "Spring deflection", "m", "_deflection_m", six),
            group("Springs", "beam_stress", "Bending stress of the beam", "MPa", "_stress_mpa", six),
            group("Motors", "currents", "Motor current", "A", "_current_a", six),
            group("Motors", "rotor_speed", "Rotor speed", "rad/s", "_rotor_speed_rad_s", six),
            group(
                "Energy",
                "energy",
                "Energy since the start",
                "J",
                "_j",
                &["kinetic", "potential", "spring", "motor_work", "dissipated", "balance_error"],
            ),
        ],
        documents: vec![Document {
            name: "Scenario".into(),
            text: "robot = \"synthetic\"\n\n[drop]\nheight_m = 0.05\nbody_mass_kg = 20.0   # an estimate\n"
                .into(),
            markdown: false,
        }],
    }
}

fn about_y(angle_rad: f64) -> [f64; 4] {
    [0.0, (0.5 * angle_rad).sin(), 0.0, (0.5 * angle_rad).cos()]
}

/// A point of a body's frame in the world, for rotations about y.
fn at(pose: &Pose, p: [f64; 3]) -> [f64; 3] {
    let [_, y, _, w] = pose.orientation;
    let (s, c) = (2.0 * y * w, w * w - y * y);
    let o = pose.position_m;
    [o[0] + c * p[0] + s * p[2], o[1] + p[1], o[2] - s * p[0] + c * p[2]]
}

fn poses(t: f64) -> (Poses, f64) {
    let phase = std::f64::consts::TAU * 0.5 * t;
    let (hip, knee) = (-0.35 - 0.35 * phase.sin(), 0.7 + 0.45 * (phase + 0.9).sin());
    let ankle = -(hip + knee);
    let pelvis = Pose { position_m: [0.0, 0.0, 0.86 + 0.02 * (2.0 * phase).cos()], ..Pose::default() };
    let thigh = Pose { position_m: at(&pelvis, [0.0, 0.0, -0.05]), orientation: about_y(hip) };
    let shank = Pose { position_m: at(&thigh, [0.0, 0.0, -0.40]), orientation: about_y(hip + knee) };
    let foot = Pose { position_m: at(&shank, [0.0, 0.0, -0.40]), orientation: about_y(hip + knee + ankle) };
    let ground_n = (900.0 * (0.12 - (foot.position_m[2] - 0.04)) / 0.05).clamp(0.0, 900.0);
    let rod = |from: &Pose, a: [f64; 3], to: &Pose, b: [f64; 3], i: usize| RodState {
        from_m: at(from, a),
        to_m: at(to, b),
        force_n: force(i, t, ground_n),
    };
    let side = |i: usize| if i.is_multiple_of(2) { 0.06 } else { -0.06 };
    let rods = (0..8)
        .map(|i| match i / 2 {
            0 => rod(&pelvis, [-0.07, 1.5 * side(i), 0.04], &thigh, [-0.03, side(i), -0.08], i),
            1 => rod(&pelvis, [0.07, side(i), 0.0], &thigh, [0.05, side(i), -0.22], i),
            2 => rod(&thigh, [-0.05, side(i), -0.10], &shank, [-0.06, side(i), -0.03], i),
            _ => rod(&shank, [-0.05, side(i), -0.12], &foot, [-0.07, side(i), -0.01], i),
        })
        .collect::<Vec<_>>();
    let arrows = vec![
        ArrowState { origin_m: rods[4].from_m, force_n: axial(&rods[4], 1.0) },
        ArrowState { origin_m: rods[4].to_m, force_n: axial(&rods[4], -1.0) },
        ArrowState { origin_m: at(&foot, [0.03, 0.0, -0.04]), force_n: [0.08 * ground_n, 0.0, ground_n] },
    ];
    (Poses { bodies: vec![pelvis, thigh, shank, foot], rods, arrows }, ground_n)
}

fn axial(rod: &RodState, sign: f64) -> [f64; 3] {
    let d: [f64; 3] = std::array::from_fn(|i| rod.from_m[i] - rod.to_m[i]);
    let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
    d.map(|x| sign * rod.force_n * x / length)
}

fn force(i: usize, t: f64, ground_n: f64) -> f64 {
    let w = 3.1 + 0.3 * i as f64;
    900.0 * (w * t).sin() + 1.4 * ground_n * (0.5 + 0.1 * i as f64) + 40.0 * (87.0 * t + i as f64).sin()
}

fn scalars(scene: &Scene, t: f64, ground_n: f64) -> Vec<f64> {
    let mut values = Vec::with_capacity(scene.scalar_count());
    for (g, group) in scene.series.iter().enumerate() {
        let size = [0.8, 4.0, 60.0, 1.0, 1.05, 0.0015, 300.0, 8.0, 400.0, 120.0][g];
        for m in 0..group.members.len() {
            let value = match group.unit.as_str() {
                "N" => size * force(m + 2, t, ground_n),
                _ => {
                    size * ((3.1 + 0.2 * m as f64) * t + 0.7 * m as f64).sin()
                        + 0.01 * size * (200.0 * t).sin()
                }
            };
            values.push(value);
        }
    }
    values
}
