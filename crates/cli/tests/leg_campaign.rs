//! The loop on a leg as a user types it, on a leg of one joint whose truth comes from another integrator:
//! semi-implicit Euler at a hundredth of the program's step, with a stick test.

mod program;

use program::{json, normal, sealegs};
use std::path::{Path, PathBuf};

/// Stiffness N/m, reflected inertia kg, damping N s/m, force per current N/A.
const ACTUATOR: [f64; 4] = [4.0e5, 280.0, 1.1e4, 238.0];
/// Mass kg, distance of its centre m, inertia about it kg m^2.
const SHANK: [f64; 3] = [4.0, 0.2, 0.05];
/// Lever at the joint, and height of the attachment at the base, m.
const LEVER_M: f64 = 0.06;
const ABOVE_M: f64 = 0.25;
const STEP_S: f64 = 2e-6;
const SAMPLE_S: f64 = 1e-3;
const NOISE_RAD: f64 = 1e-4;
const NOISE_N: f64 = 1.0;
const FRICTION_N: f64 = 90.0;

/// Length of the actuator and its moment arm at a joint angle.
fn reach(q: f64) -> (f64, f64) {
    let (x, z) = (-LEVER_M * q.cos() + LEVER_M, LEVER_M * q.sin() - ABOVE_M);
    let length = x.hypot(z);
    (length, (x * LEVER_M * q.sin() + z * LEVER_M * q.cos()) / length)
}

/// One run as CSV under a sine of current.
fn table(amplitude_a: f64, frequency_hz: f64, seed: u64) -> String {
    let [k, inertia, damping, constant] = ACTUATOR;
    let [m, arm_m, about] = SHANK;
    let (mut q, mut q_dot, mut y, mut y_dot) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let rest = reach(0.0).0;
    let mut state = seed;
    let mut text = "time_s,knee.angle_rad,knee.force_1_n,knee.note_m\n".to_owned();
    let per_sample = (SAMPLE_S / STEP_S).round() as usize;
    for sample in 0..500 {
        let t = sample as f64 * SAMPLE_S;
        let current = amplitude_a * (std::f64::consts::TAU * frequency_hz * t).sin();
        let spring = |q: f64, y: f64| k * (y - (reach(q).0 - rest));
        let (angle, force) =
            (q + NOISE_RAD * normal(&mut state), spring(q, y) + NOISE_N * normal(&mut state));
        text.push_str(&format!("{t:.3},{angle},{force},0.0\n"));
        for _ in 0..per_sample {
            let push = spring(q, y);
            let free = y_dot + STEP_S * (constant * current - damping * y_dot - push) / inertia;
            let most = STEP_S * FRICTION_N / inertia;
            y_dot = if free.abs() <= most { 0.0 } else { free - most.copysign(free) };
            let torque = push * reach(q).1 - m * 9.81 * arm_m * q.sin();
            q_dot += STEP_S * torque / (about + m * arm_m * arm_m);
            y += STEP_S * y_dot;
            q += STEP_S * q_dot;
        }
    }
    text
}

const URDF: &str = r#"<robot name="one"><link name="base"/>
<link name="shank"><inertial><origin xyz="0 0 -0.2"/><mass value="4.0"/>
<inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="base"/><child link="shank"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="200" velocity="10"/></joint></robot>"#;

const PLACEMENT: &str = "[[actuator]]\nname = \"knee\"\nkind = \"linear\"\nactuator = \"thor-linear\"\n\
    spring = \"compliant\"\nlink_1 = \"base\"\npoint_1_m = [-0.06, 0.0, 0.25]\nlink_2 = \"shank\"\n\
    point_2_m = [-0.06, 0.0, 0.0]\n";

fn scenario(amplitude_a: f64, frequency_hz: f64) -> String {
    let [k, inertia, damping, constant] = ACTUATOR;
    format!(
        "description = \"swing\"\nrobot = \"one.urdf\"\nduration_s = 0.5\n[base]\nkind = \"fixed\"\nheight_m = 1.0\n\
         [actuator.knee]\nparameters = {{ stiffness = {}, reflected_inertia = {inertia:?}, damping = {damping:?}, \
         force_constant = {constant:?}, sprung_mass = 0.0 }}\n[controller]\nkind = \"free\"\n\
         [current.knee]\nshape = \"sine\"\namplitude = {amplitude_a:?}\nfrequency_hz = {frequency_hz:?}\n\
         phase_rad = 0.0\n",
        1.02 * k
    )
}

/// Writes the campaign; `edit` changes its file.
fn campaign(folder: &Path, edit: impl Fn(String) -> String) -> PathBuf {
    let folder = folder.join("leg");
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    write("one.urdf", URDF.to_owned());
    write("one.actuators.toml", PLACEMENT.to_owned());
    let mut text = format!(
        "name = \"one-joint\"\nbench = \"leg\"\nscenario = \"a.toml\"\nsample_rate_hz = 1000.0\n[noise_std]\n\
         \"knee.angle_rad\" = {NOISE_RAD}\n\"knee.force_1_n\" = {NOISE_N}\n"
    );
    let runs = [("a", 5.0, 3.0, "fit"), ("b", 3.5, 6.0, "fit"), ("c", 4.5, 4.0, "holdout")];
    for (i, (name, amplitude, frequency, role)) in runs.into_iter().enumerate() {
        write(&format!("{name}.csv"), table(amplitude, frequency, i as u64 + 1));
        write(&format!("{name}.toml"), scenario(amplitude, frequency));
        text += &format!("[[run]]\nfile = \"{name}.csv\"\nrole = \"{role}\"\nscenario = \"{name}.toml\"\n");
    }
    write("campaign.toml", edit(text));
    folder
}

#[test]
fn reference_friction_at_the_knee_is_found_added_and_run() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), |text| text);
    let text = |p: &Path| p.to_str().unwrap().to_owned();
    let path = |name: &str| folder.path().join(name);
    let c = text(&campaign);
    let done = |arguments: &[&str]| {
        let done = sealegs(2, arguments);
        assert_eq!(done.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
        done
    };
    done(&["check", &c, "--json", &text(&path("check.json"))]);
    let (compared, found) = (path("compared.json"), path("found.json"));
    done(&["compare", &c, "--json", &text(&compared), "--report", &text(&path("page.html"))]);
    assert!(json(&compared)["base"]["holdout_error"].as_f64().unwrap() > 2.0);
    done(&["diagnose", &c, "--json", &text(&found)]);
    let found = json(&found);
    let hidden = serde_json::json!(["knee/coulomb-friction"]);
    let tied = found["indistinguishable"].as_array().unwrap();
    assert!(found["effects"] == hidden || tied.contains(&hidden), "{} {tied:?}", found["effects"]);
    assert_eq!(found["verdict"], "missing-effect");
    assert!(found["after"]["holdout_error"].as_f64().unwrap() < 1.1);

    // The better model may lie in another folder than the campaign, and runs.
    let (better, added, again) = (path("better.toml"), path("added.json"), path("again.json"));
    let model = text(&campaign.join("a.toml"));
    let b = text(&better);
    done(&[
        "add",
        "knee/coulomb-friction",
        "--to",
        &model,
        "--campaign",
        &c,
        "-o",
        &b,
        "--json",
        &text(&added),
    ]);
    let parameters = json(&added)["after"]["parameters"].clone();
    let named = |name: &str| {
        parameters.as_array().unwrap().iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap()
    };
    let force = named("knee/coulomb-friction.force_n");
    assert!((force - FRICTION_N).abs() < 2.0, "{force}");
    assert!((named("knee/stiffness") / ACTUATOR[0] - 1.0).abs() < 0.01);
    done(&["compare", &c, "--model", &b, "--as-is", "--json", &text(&again)]);
    let after = json(&added)["after"]["holdout_error"].as_f64().unwrap();
    let loaded = json(&again)["base"]["holdout_error"].as_f64().unwrap();
    assert!((after / loaded - 1.0).abs() < 0.01, "{after} when written, {loaded} when loaded");
    let motion = |scenario: &str| {
        let csv = path("motion.csv");
        done(&["run", scenario, "--csv", &text(&csv)]);
        std::fs::read_to_string(csv).unwrap()
    };
    assert_ne!(motion(&b), motion(&model), "the run has the effect in it");
}

#[test]
fn bad_leg_campaigns_are_refused_with_one_line_and_status_2() {
    let refuse = |edit: &dyn Fn(String) -> String, named: &str| {
        let folder = tempfile::tempdir().unwrap();
        let campaign = campaign(folder.path(), edit);
        let out = folder.path().join("out.json");
        let done = sealegs(2, &["compare", campaign.to_str().unwrap(), "--json", out.to_str().unwrap()]);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(named), "{message}");
        assert!(!out.exists());
    };
    refuse(&|text| text.replace("scenario = \"b.toml\"", "scenario = \"thor-drp\""), "thor-drop");
    refuse(
        &|text| text.replace("bench = \"leg\"", "bench = \"leg\"\ninputs = [\"knee.note_m\"]"),
        "knee.note_m",
    );
    refuse(&|text| text.replace("bench = \"leg\"", "bench = \"leg\"\ninputs = [\"hip.current_a\"]"), "hip");
}
