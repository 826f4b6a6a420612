//! Rigs beside the series elastic ones through the program: a carriage that begins in motion, a servo with its own loop and
//! pendulums of different weight, a robot with torque drives; every log made here by another integrator.

mod program;

use program::{json, normal, sealegs};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// Steps within a row of a log.
const FINE: usize = 200;

fn well(arguments: &[&str]) {
    let done = sealegs(2, arguments);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{arguments:?}: {error}");
}

fn parameter(side: &Value, name: &str) -> f64 {
    let all = side["parameters"].as_array().expect("parameters");
    let found = all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("no {name} in {all:?}"));
    found["value"].as_f64().expect("a number")
}

/// One coordinate with dry friction: position by row, from a force by time, position and speed and a bound by force and
/// position.
fn move_one(
    rows: usize,
    h: f64,
    start: (f64, f64),
    inertia: f64,
    force: impl Fn(usize, f64, f64) -> f64,
    bound: f64,
) -> Vec<f64> {
    let (mut x, mut v) = start;
    let mut out = Vec::with_capacity(rows);
    let step = h / FINE as f64;
    for n in 0..rows {
        out.push(x);
        for _ in 0..FINE {
            let free = v + step * force(n, x, v) / inertia;
            let most = step * bound / inertia;
            v = if free.abs() <= most { 0.0 } else { free - most * free.signum() };
            x += step * v;
        }
    }
    out
}

/// A robot of one joint about -y, whose mass hangs so far below it.
fn arm(joint: &str, mass: f64, below: f64) -> String {
    format!(
        "<robot name=\"arm\"><link name=\"base\"/><link name=\"arm\"><inertial><origin xyz=\"0 0 {}\"/>\
         <mass value=\"{mass}\"/><inertia ixx=\"1e-7\" iyy=\"1e-7\" izz=\"1e-7\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
         </inertial></link><joint name=\"{joint}\" type=\"continuous\"><parent link=\"base\"/><child link=\"arm\"/>\
         <axis xyz=\"0 -1 0\"/></joint></robot>",
        -below
    )
}

/// Friction and an offset of a carriage whose run begins in motion, anywhere.
fn carriage(folder: &Path) {
    let mut seed = 7;
    for (name, phase, start) in [("fit.csv", 0.0, (0.31, -0.12)), ("check.csv", 1.0, (-0.2, 0.05))] {
        let push = |n: usize| {
            let t = n as f64 * 2e-3;
            70.0 * (2.1 * t + phase).sin() + 40.0 * (5.3 * t).sin()
        };
        let force = |n: usize, _x: f64, v: f64| push(n) - 200.0 * v - 3.5;
        let x = move_one(4000, 2e-3, start, 95.0, force, 20.0);
        let mut text = "time_s,motor_force_n,position_m\n".to_owned();
        for (n, x) in x.iter().enumerate() {
            let noisy = x + 1e-5 * normal(&mut seed);
            let _ = writeln!(text, "{:.3},{:.6},{noisy:.7}", n as f64 * 2e-3, push(n));
        }
        std::fs::write(folder.join(name), text).expect("written");
    }
    let text = "name = \"carriage\"\nbench = \"free\"\nactuator = \"rigid-linear\"\n\n[noise_std]\nposition_m = 1e-5\n\n\
                [[run]]\nfile = \"fit.csv\"\nrole = \"fit\"\n\n[[run]]\nfile = \"check.csv\"\nrole = \"holdout\"\n";
    std::fs::write(folder.join("campaign.toml"), text).expect("written");
}

#[test]
fn a_carriage_that_begins_in_motion_gets_its_friction_and_offset_back() {
    let folder = tempfile::tempdir().expect("a folder");
    carriage(folder.path());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (campaign, better, result) = (path("."), path("better.toml"), path("added.json"));
    // To the model that the campaign names, as no other is given.
    well(&[
        "add",
        "coulomb-friction+output-offset",
        "--campaign",
        &campaign,
        "-o",
        &better,
        "--json",
        &result,
    ]);
    let added = json(Path::new(&result));
    let after = &added["after"];
    for (name, truth, tolerance) in [
        ("reflected_inertia", 95.0, 2.0),
        ("damping", 200.0, 4.0),
        ("coulomb-friction.force_n", 20.0, 0.5),
        ("output-offset.force_n", -3.5, 0.2),
    ] {
        let got = parameter(after, name);
        assert!((got - truth).abs() < tolerance, "{name} = {got}, not {truth}");
    }
    // Eleven rows with 10 um of noise tell the first speed to sqrt(192 / 11) 10 um / 20 ms = 2 mm/s, which in the 0.5 s
    // until it is forgotten is a millimetre, 100 times the noise.
    assert!(after["holdout_error"].as_f64().expect("a number") < 200.0, "{after}");
    assert!(added["base"]["holdout_error"].as_f64().expect("a number") > 600.0);
}

#[test]
fn a_servo_with_weights_of_its_own_per_run_gets_its_values_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut seed = 3;
    let (kt, resistance, armature, viscous, dry) = (0.3, 2.4, 0.0015, 0.008, 0.03);
    let mut campaign = "bench = \"pendulum\"\nactuator = \"servo.toml\"\nlength_m = 0.1\n\n[noise_std]\n\
                        joint_angle_rad = 5e-4\n\n"
        .to_owned();
    for (i, (mass, gain)) in [(0.5, 400.0), (0.3, 100.0), (0.4, 200.0)].into_iter().enumerate() {
        let goal = |n: usize| {
            let t = n as f64 * 5e-3;
            0.9 * (2.3 * t + i as f64).sin() + if t > 2.0 { 0.6 } else { 0.0 }
        };
        let on = |n: usize| if n > 600 { 0.0 } else { 1.0 };
        let inertia = armature + mass * 0.01;
        let force = |n: usize, x: f64, v: f64| {
            let volts = 7.4 * (gain * 0.00288 * (goal(n) - x)).clamp(-1.0, 1.0);
            on(n) * kt * (volts - kt * v) / resistance - mass * 9.81 * 0.1 * x.sin() - viscous * v
        };
        let x = move_one(800, 5e-3, (0.2, 0.0), inertia, force, dry);
        let mut text = "time_s,position_rad,enable,joint_angle_rad\n".to_owned();
        for (n, x) in x.iter().enumerate() {
            let noisy = x + 5e-4 * normal(&mut seed);
            let _ = writeln!(text, "{:.3},{:.6},{},{noisy:.6}", n as f64 * 5e-3, goal(n), on(n));
        }
        std::fs::write(folder.path().join(format!("run{i}.csv")), text).expect("written");
        let role = if i == 2 { "holdout" } else { "fit" };
        let _ = write!(
            campaign,
            "[[run]]\nfile = \"run{i}.csv\"\nrole = \"{role}\"\nmass_kg = {mass}\nservo_gain = {gain}\n\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), campaign).expect("written");
    let servo = "id = \"servo\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.35\n\
                 rotor_inertia_kg_m2 = 0.001\nrotor_damping_nm_s = 0.005\nwinding_resistance_ohm = 3.0\nsupply_v = 7.4\n\
                 [transmission]\ntype = \"direct\"\n[servo]\nproportional_per_rad = 0.00288\n\
                 [parameters.reflected_inertia]\nscale = \"logarithmic\"\n[parameters.damping]\nscale = \"logarithmic\"\n";
    std::fs::write(folder.path().join("servo.toml"), servo).expect("written");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (campaign, better, result) = (path("campaign.toml"), path("better.toml"), path("added.json"));
    well(&[
        "add",
        "coulomb-friction",
        "--to",
        &path("servo.toml"),
        "--campaign",
        &campaign,
        "-o",
        &better,
        "--json",
        &result,
    ]);
    let added = json(Path::new(&result));
    let after = &added["after"];
    assert!(after["holdout_error"].as_f64().expect("a number") < 2.0, "{after}");
    for (name, truth, share) in [
        ("force_constant", kt, 0.05),
        ("winding_resistance", resistance, 0.05),
        ("reflected_inertia", armature, 0.1),
        ("coulomb-friction.force_nm", dry, 0.05),
    ] {
        let got = parameter(after, name);
        assert!((got / truth - 1.0).abs() < share, "{name} = {got}, not {truth}");
    }
    // The better file is one to go on with.
    well(&["compare", &campaign, "--model", &better, "--as-is"]);
}

#[test]
fn a_servo_at_a_robots_joint_is_diagnosed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (kt, resistance, armature, viscous, dry, gain) = (0.35, 3.0, 0.002, 0.005, 0.06, 2.0);
    let (mass, length) = (0.4, 0.1);
    let mut seed = 77;
    let mut campaign = "bench = \"robot\"\nrobot = \"arm.urdf\"\nactuator = \"servo.toml\"\n\n".to_owned();
    for (i, pace) in [2.1_f64, 3.7, 2.9].into_iter().enumerate() {
        let goal = |n: usize| {
            let t = n as f64 * 1e-2;
            0.7 * (pace * t).sin() + 0.3 * (2.3 * pace * t).cos()
        };
        let force = |n: usize, x: f64, v: f64| {
            let volts = 7.4 * (gain * (goal(n) - x)).clamp(-1.0, 1.0);
            kt * (volts - kt * v) / resistance - mass * 9.81 * length * x.sin() - viscous * v
        };
        let x = move_one(800, 1e-2, (0.2, 0.0), armature + mass * length * length, force, dry);
        let mut text = "time_s,pivot.position_rad,pivot.angle_rad\n".to_owned();
        for (n, x) in x.iter().enumerate() {
            let _ =
                writeln!(text, "{:.3},{:.6},{:.6}", n as f64 * 1e-2, goal(n), x + 5e-4 * normal(&mut seed));
        }
        std::fs::write(folder.path().join(format!("run{i}.csv")), text).expect("written");
        let role = if i == 2 { "holdout" } else { "fit" };
        let _ = write!(campaign, "[[run]]\nfile = \"run{i}.csv\"\nrole = \"{role}\"\n\n");
    }
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("campaign.toml", &campaign);
    write("arm.urdf", &arm("pivot", mass, length));
    let servo = "id = \"servo\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.35\n\
                 rotor_inertia_kg_m2 = 0.002\nrotor_damping_nm_s = 0.005\nwinding_resistance_ohm = 3.0\nsupply_v = 7.4\n\
                 [transmission]\ntype = \"direct\"\n[servo]\nproportional_per_rad = 2.0\n";
    write("servo.toml", servo);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (result, better) = (path("result.json"), path("better.toml"));
    well(&["diagnose", &path("campaign.toml"), "--json", &result, "--better", &better]);
    let found = json(Path::new(&result));
    let effects = found["effects"].as_array().expect("a list");
    assert_eq!(effects.len(), 1, "{}", found["sentence"]);
    assert_eq!(effects[0], "pivot/coulomb-friction");
    let got = parameter(&found["after"], "pivot/coulomb-friction.force_nm");
    assert!((got / dry - 1.0).abs() < 0.1, "{got}");
    well(&["compare", &path("campaign.toml"), "--model", &better, "--as-is"]);
}

#[test]
fn an_arm_that_falls_in_open_loop_is_diagnosed_in_pieces_of_its_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mass, length, armature, viscous, dry) = (1.2, 0.5, 0.05, 0.15, 0.6);
    let mut seed = 5;
    let mut campaign = "bench = \"robot\"\nrobot = \"arm.urdf\"\nactuator = \"hip.toml\"\n\n[noise_std]\n\
                        \"hip.angle_rad\" = 1e-4\n\n"
        .to_owned();
    for (i, pace) in [2.1_f64, 3.7].into_iter().enumerate() {
        let goal = |n: usize| {
            let t = n as f64 * 1e-2;
            0.3 * (pace * t).sin() + 0.15 * (2.3 * pace * t).cos()
        };
        // A feedback that is not in the log keeps the arm upright; its torque is held over each row.
        let held = std::cell::RefCell::new(Vec::new());
        let force = |n: usize, x: f64, v: f64| {
            let mut held = held.borrow_mut();
            if held.len() == n {
                held.push(40.0 * (goal(n) - x) - 4.0 * v);
            }
            held[n] + mass * 9.81 * length * x.sin() - viscous * v
        };
        let x = move_one(500, 1e-2, (0.0, 0.0), armature + mass * length * length, force, dry);
        let mut text = "time_s,hip.torque_nm,hip.angle_rad\n".to_owned();
        for (n, (x, torque)) in x.iter().zip(held.into_inner()).enumerate() {
            let _ = writeln!(text, "{:.3},{torque:.6},{:.6}", n as f64 * 1e-2, x + 1e-4 * normal(&mut seed));
        }
        std::fs::write(folder.path().join(format!("run{i}.csv")), text).expect("written");
        let role = if i == 1 { "holdout" } else { "fit" };
        let _ = write!(campaign, "[[run]]\nfile = \"run{i}.csv\"\nrole = \"{role}\"\n\n");
    }
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("campaign.toml", &campaign);
    write("arm.urdf", &arm("hip", mass, -length));
    let hip = "id = \"hip\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
               rotor_inertia_kg_m2 = 0.04\nrotor_damping_nm_s = 0.2\n[transmission]\ntype = \"direct\"\n";
    write("hip.toml", hip);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let result = path("result.json");
    well(&["diagnose", &path("campaign.toml"), "--json", &result]);
    let found = json(Path::new(&result));
    let said = found["confidence"]["reasons"].to_string();
    assert!(said.contains("cut into pieces of 0.5 s"), "{said}");
    assert_eq!(found["effects"], serde_json::json!(["hip/coulomb-friction"]), "{}", found["sentence"]);
    let got = parameter(&found["after"], "hip/coulomb-friction.force_nm");
    assert!((got / dry - 1.0).abs() < 0.05, "{got}");
}

#[test]
fn joints_without_columns_stand_still_and_each_joint_that_has_some_gets_a_drive_of_its_kind() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/><inertia ixx=\"0.01\" \
             iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"0.2\" upper=\"1\" effort=\"9\" velocity=\"9\"/></joint>"
        )
    };
    write(
        "hand.urdf",
        &format!(
            "<robot name=\"hand\"><link name=\"base\"/>{}{}{}{}{}{}</robot>",
            link("a"),
            link("b"),
            link("c"),
            joint("lift", "prismatic", "base", "a"),
            joint("wrist", "revolute", "a", "b"),
            joint("finger", "revolute", "b", "c"),
        ),
    );
    let mut rows = "time_s,lift.force_n,lift.position_m,wrist.torque_nm,wrist.angle_rad\n".to_owned();
    for n in 0..60 {
        let t = 0.01 * f64::from(n);
        let _ = writeln!(rows, "{t:.2},29.5,{:.5},0.1,{:.5}", 0.5 + 0.01 * t, 0.5 + 0.02 * t);
    }
    write("log.csv", &rows);
    write(
        "campaign.toml",
        "bench = \"robot\"\nrobot = \"hand.urdf\"\nactuator = \"rigid-rotary\"\n[[run]]\nfile = \"log.csv\"\nrole = \"fit\"\n",
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let done = sealegs(1, &["compare", &path("campaign.toml"), "--as-is"]);
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{said}");
    assert!(said.contains("1 of 3 joints stand still") && said.contains("finger"), "{said}");
    assert!(said.contains("'lift' slides: its drive is 'rigid-linear'"), "{said}");
    // The model with an effect holds them, too.
    well(&[
        "add",
        "wrist/coulomb-friction",
        "--campaign",
        &path("campaign.toml"),
        "-o",
        &path("better.toml"),
    ]);
    let better = std::fs::read_to_string(path("better.toml")).expect("the model file");
    assert!(better.contains("[hold]") && better.contains("finger = 0.2"), "{better}");
    // A joint whose columns stand still in every run is held where they say; one number from end to end may be a dead sensor's.
    for (jitter, is_held) in [(1e-6, true), (0.0, false)] {
        let mut lines = rows.lines();
        let mut logged = format!("{},finger.torque_nm,finger.angle_rad\n", lines.next().expect("a header"));
        for (n, line) in lines.enumerate() {
            let _ = writeln!(logged, "{line},0.05,{:.7}", 0.3 + if n % 2 == 0 { jitter } else { 0.0 });
        }
        write("log.csv", &logged);
        let done = sealegs(1, &["compare", &path("campaign.toml"), "--as-is"]);
        let said = String::from_utf8_lossy(&done.stderr);
        assert_eq!(said.contains("1 of 3 joints stand still, where their columns say"), is_held, "{said}");
        assert_eq!(said.contains("2 columns of joints that stand still are left out"), is_held, "{said}");
    }
}

#[test]
fn a_robots_columns_and_files_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    let urdf = "<robot name=\"one\"><link name=\"base\"/><link name=\"arm\"><inertial><origin xyz=\"0 0 -0.2\"/>\
                <mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
                </inertial></link><joint name=\"pivot\" type=\"continuous\"><parent link=\"base\"/>\
                <child link=\"arm\"/><axis xyz=\"0 1 0\"/></joint></robot>";
    write("one.urdf", urdf);
    let rows = |header: &str| {
        let mut text = format!("{header}\n");
        for n in 0..40 {
            let _ = writeln!(text, "{:.2},0.1,{:.4}", f64::from(n) * 0.01, 1e-4 * f64::from(n * n));
        }
        text
    };
    write("good.csv", &rows("time_s,pivot.torque_nm,pivot.angle_rad"));
    write("stray.csv", &rows("time_s,pivt.torque_nm,pivot.angle_rad"));
    write("still.csv", &rows("time_s,pivot.speed_rad_s,pivot.angle_rad"));
    write("elbow.csv", &rows("time_s,pivot.torque_nm,pivt.angle_rad"));
    write(
        "stops.urdf",
        &urdf.replace(
            "continuous\">",
            "revolute\"><limit lower=\"-1\" upper=\"2\" effort=\"9\" velocity=\"9\"/>",
        ),
    );
    let degrees = rows("time_s,pivot.torque_nm,pivot.angle_rad").replace(",0.1,0.", ",0.1,90.");
    write("degrees.csv", &degrees);
    let campaign = |robot: &str, actuator: &str, file: &str| {
        write(
            "campaign.toml",
            &format!("bench = \"robot\"\n{robot}\n{actuator}\n[[run]]\nfile = \"{file}\"\nrole = \"fit\"\n"),
        );
        let path = folder.path().join("campaign.toml").display().to_string();
        let done = sealegs(1, &["compare", &path, "--as-is"]);
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let (robot, drive) = ("robot = \"one.urdf\"", "actuator = \"rigid-rotary\"");
    let (status, error) = campaign(robot, drive, "good.csv");
    assert_eq!(status, Some(0), "{error}");
    for (said, part) in [
        (campaign(robot, drive, "stray.csv"), "did you mean 'pivot.torque_nm'?"),
        (campaign(robot, drive, "still.csv"), "<joint>.torque_nm"),
        (campaign(robot, drive, "elbow.csv"), "did you mean 'pivot.angle_rad'?"),
        (campaign("robot = \"stops.urdf\"", drive, "degrees.csv"), "in degrees? { as = \"pivot.angle_rad\""),
        (campaign(robot, "", "good.csv"), "'actuator' must name the drive"),
        (campaign("", drive, "good.csv"), "robot"),
        (campaign("robot = \"two.urdf\"", drive, "good.csv"), "two.urdf"),
        (campaign(robot, "actuator = \"thor-linear\"", "good.csv"), "must be rotary"),
    ] {
        assert_eq!(said.0, Some(2), "{}", said.1);
        assert!(said.1.contains(part) && said.1.lines().count() == 1, "{part}: {}", said.1);
    }
    // A drive's file where the robot's model belongs.
    campaign(robot, drive, "good.csv");
    write("drive.toml", include_str!("../../../assets/actuators/rigid-rotary.toml"));
    let path = |name: &str| folder.path().join(name).display().to_string();
    let done = sealegs(1, &["compare", &path("campaign.toml"), "--model", &path("drive.toml")]);
    let error = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(2), "{error}");
    assert!(error.contains("drive.toml: a campaign on the robot bench needs a model file"), "{error}");
}

/// A joint that swings an arm, with what is in its campaign file beside the runs.
struct Swing<'a> {
    drive: &'a str,
    said: &'a str,
    columns: &'a str,
}

/// Writes two runs of an arm of 1.2 kg on 0.5 m under a torque by row number, angle and speed, with 0.05 kg m^2 of rotor, 0.15 N m s/rad
/// and so much dry friction; `told` is what the log says of the command. Its campaign is in the folder.
fn swings(
    folder: &Path,
    swing: &Swing,
    dry: f64,
    torque: impl Fn(usize, usize, f64, f64) -> f64,
    told: impl Fn(usize, usize) -> f64,
) {
    let (mass, length, armature, viscous) = (1.2, 0.5, 0.05, 0.15);
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    let mut seed = 11;
    let mut campaign = format!(
        "bench = \"robot\"\nrobot = \"arm.urdf\"\nactuator = \"hip.toml\"\n{}\n[noise_std]\n\"hip.angle_rad\" = 1e-4\n\n",
        swing.said
    );
    for run in 0..2 {
        let force =
            |n: usize, x: f64, v: f64| torque(run, n, x, v) - mass * 9.81 * length * x.sin() - viscous * v;
        let x = move_one(2000, 2e-3, (0.0, 0.0), armature + mass * length * length, force, dry);
        let mut text = format!("time_s,{},hip.angle_rad\n", swing.columns);
        for (n, x) in x.iter().enumerate() {
            let angle = x + 1e-4 * normal(&mut seed);
            let _ = writeln!(text, "{:.4},{:.6},{angle:.6}", n as f64 * 2e-3, told(run, n));
        }
        write(&format!("run{run}.csv"), &text);
        let role = if run == 1 { "holdout" } else { "fit" };
        let _ = write!(campaign, "[[run]]\nfile = \"run{run}.csv\"\nrole = \"{role}\"\n\n");
    }
    write("campaign.toml", &campaign);
    write("arm.urdf", &arm("hip", mass, length));
    let hip = "id = \"hip\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
               rotor_inertia_kg_m2 = 0.04\nrotor_damping_nm_s = 0.2\n[transmission]\ntype = \"direct\"\n";
    write("hip.toml", &format!("{hip}{}", swing.drive));
}

#[test]
fn a_joint_under_impedance_control_with_hidden_friction_is_diagnosed() {
    let folder = tempfile::tempdir().expect("a folder");
    // Goals as a policy sends them, every 20 ms.
    let goal = |run: usize, n: usize| {
        let (t, pace) = ((n / 10) as f64 * 0.02, [2.3, 3.1][run]);
        0.5 * (pace * t).sin() + 0.25 * (2.7 * pace * t).sin()
    };
    let swing = Swing {
        drive: "[servo]\nproportional_nm_per_rad = 25.0\nderivative_nm_s_per_rad = 0.8\ntorque_limit_nm = 20.0\n",
        said: "",
        columns: "hip.position_rad",
    };
    let torque =
        |run: usize, n: usize, x: f64, v: f64| (25.0 * (goal(run, n) - x) - 0.8 * v).clamp(-20.0, 20.0);
    swings(folder.path(), &swing, 0.6, torque, goal);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let result = path("result.json");
    well(&["diagnose", &path("campaign.toml"), "--json", &result]);
    let found = json(Path::new(&result));
    assert_eq!(found["effects"], serde_json::json!(["hip/coulomb-friction"]), "{}", found["sentence"]);
    let got = parameter(&found["after"], "hip/coulomb-friction.force_nm");
    assert!((got / 0.6 - 1.0).abs() < 0.02, "{got}");
}

#[test]
fn torques_that_a_controller_adds_against_gravity_are_in_the_model() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |run: usize, n: usize| {
        let (t, pace) = (n as f64 * 2e-3, [2.3, 3.1][run]);
        0.6 * (pace * t).cos() - 0.3 * (2.1 * pace * t).sin()
    };
    let weight = |x: f64| 1.2 * 9.81 * 0.5 * x.sin();
    let error = |said: &str| {
        let swing = Swing { drive: "", said, columns: "hip.torque_nm" };
        let torque = |run: usize, n: usize, x: f64, _: f64| told(run, n) + weight(x);
        swings(folder.path(), &swing, 0.0, torque, told);
        let path = |name: &str| folder.path().join(name).display().to_string();
        let result = path("result.json");
        well(&["compare", &path("campaign.toml"), "--json", &result]);
        json(Path::new(&result))["base"]["fit_error"].as_f64().expect("an error")
    };
    assert!(error("") > 100.0);
    let with = error("gravity_compensated = true\n");
    assert!(with < 1.5, "{with}");
}
