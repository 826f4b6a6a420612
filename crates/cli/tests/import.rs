//! `sealegs import`: what it says of logs of every kind, and that what it writes is a campaign.

mod program;

use program::sealegs;
use sealegs::sysid::{Campaign, Role};
use std::path::{Path, PathBuf};

fn log(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../logs/tests/data").join(name)
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// What the program prints; it must succeed.
fn said(arguments: &[&str]) -> String {
    let done = sealegs(1, arguments);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn what_it_writes_is_a_campaign_that_can_be_read() {
    for name in ["semicolon.csv", "packed.mat", "plain.npz", "columns.json"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new");
        let told = said(&["import", text(&log(name)), text(&log(name)), "-o", text(&out)]);
        assert!(told.contains("40 rows, 0.039 s at 1000 Hz by 't' in s"), "{told}");
        assert!(told.contains("-> joint_angle_rad"), "{told}");
        let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
        // The same rows cannot both be fitted and judge.
        assert!(Campaign::read(&out).unwrap_err().to_string().contains("two roles"));
        std::fs::write(out.join("campaign.toml"), written.replace("holdout", "fit")).unwrap();
        let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
        let record = &campaign.runs[0].record;
        assert_eq!(record.len(), 40);
        assert!(record.input("voltage_v").is_some() && record.output("joint_angle_rad").is_some());
    }
}

#[test]
fn logs_and_campaign_can_be_moved_together() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["old", "new"].map(|name| folder.path().join(name));
    std::fs::create_dir_all(old.join("logs")).unwrap();
    let file = old.join("logs/run.csv");
    std::fs::copy(log("semicolon.csv"), &file).unwrap();
    said(&["import", text(&file), "-o", text(&old.join("knee"))]);
    std::fs::rename(&old, &new).unwrap();
    let written = std::fs::read_to_string(new.join("knee/campaign.toml")).unwrap();
    assert!(written.contains("file = \"../logs/run.csv\""), "{written}");
    assert_eq!(Campaign::read(&new.join("knee")).unwrap().runs[0].record.len(), 40);
}

#[test]
fn topics_joints_and_faults_are_shown() {
    let told = said(&["import", text(&log("bag.mcap"))]);
    for words in
        ["/joint_states: 40 rows", "/joint_states.position[knee]", "-> knee.angle_rad", "/command: 4 rows"]
    {
        assert!(told.contains(words), "{words} is not in {told}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gaps.csv");
    let row = |i: u32| {
        format!("{},{},7,{}\n", if i < 20 { i } else { i + 500 }, i % 3, if i == 5 { "x" } else { "1" })
    };
    let rows: String = (0..40).map(row).collect();
    std::fs::write(&file, format!("time_ms,force,dead,odd\n{rows}")).unwrap();
    let told = said(&["import", text(&file), "-o", text(folder.path())]);
    for words in
        ["1 gap(s), the longest 0.501 s", "always 7", "line 7: 'x' is no number", "by 'time_ms' in ms"]
    {
        assert!(told.contains(words), "{words} is not in {told}");
    }
    // Beside the campaign the log is named by its name alone.
    let written = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    assert!(written.contains("file = \"gaps.csv\""), "{written}");
}

#[test]
fn files_with_one_clock_are_one_run_of_a_robot_and_single_numbers_are_comments() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, quantity: &str, step: f64| {
        let rows: String = (0..40)
            .map(|i| {
                let (t, x) = (step * f64::from(i), (0.3 * f64::from(i)).sin());
                format!("{t},{x},{}\n", 0.5 * x)
            })
            .collect();
        let file = folder.path().join(name);
        std::fs::write(&file, format!("t,- arm_1_joint_{quantity},- arm_2_joint_{quantity}\n{rows}"))
            .unwrap();
        file
    };
    let (position, effort) = (write("position.csv", "position", 0.01), write("effort.csv", "effort", 0.01));
    let out = folder.path().join("same");
    said(&["import", text(&position), text(&effort), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    assert!(written.contains("bench = \"robot\"") && written.matches("[[run]]").count() == 1, "{written}");
    let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
    let record = &campaign.runs[0].record;
    assert!(record.input("arm_2_joint.torque_nm").is_some(), "{written}");
    assert!(record.output("arm_1_joint.angle_rad").is_some(), "{written}");
    // Another clock is another run.
    let slower = write("slower.csv", "effort", 0.02);
    let out = folder.path().join("other");
    said(&["import", text(&position), text(&slower), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    assert_eq!(written.matches("[[run]]").count(), 2, "{written}");

    let servo = folder.path().join("servo.json");
    let entries: Vec<String> =
        (0..40).map(|i| format!("{{\"timestamp\": {}, \"position\": 0.{i}}}", 0.01 * f64::from(i))).collect();
    let head = "\"mass\": 1.13, \"kp\": 32";
    std::fs::write(&servo, format!("{{{head}, \"entries\": [{}]}}", entries.join(", "))).unwrap();
    // The folders above are made, too.
    let out = folder.path().join("of/a/servo");
    said(&["import", text(&servo), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    assert!(written.contains("mass = 1.13") && written.contains("kp = 32"), "{written}");
}

#[test]
fn a_load_cell_with_a_logger_of_its_own_is_a_part_of_the_run_on_one_clock_or_two() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, header: &str, start: f64, step: f64, rows: usize| {
        let row = |i: usize| format!("{},{}\n", start + step * i as f64, (0.01 * i as f64).sin());
        let file = folder.path().join(name);
        std::fs::write(&file, format!("{header}\n{}", (0..rows).map(row).collect::<String>())).unwrap();
        file
    };
    let drive = write("drive.csv", "time,motor_current_A", 0.0, 0.002, 500);
    let imported = |cell: &Path, name: &str| {
        let out = folder.path().join(name);
        said(&["import", text(&drive), text(cell), "-o", text(&out)]);
        let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
        (Campaign::read(&out), written)
    };
    let same = write("same.csv", "timestamp,force_N", 0.1, 0.001, 900);
    let (campaign, written) = imported(&same, "one-clock");
    assert!(written.matches("[[run]]").count() == 1 && !written.contains("offset_s"), "{written}");
    campaign.unwrap_or_else(|e| panic!("{e}\n{written}"));
    let own = write("own.csv", "timestamp,force_N", 1000.0, 0.001, 1000);
    let (campaign, written) = imported(&own, "own-clock");
    assert!(
        written.contains("offset_s = -1000.000000") && written.contains("clocks do not meet"),
        "{written}"
    );
    let record = campaign.unwrap_or_else(|e| panic!("{e}\n{written}")).runs.remove(0).record;
    assert!(record.output("force_1_n").is_some() && record.input("current_a").is_some());
    // What is much shorter is another run, whatever it holds.
    let short = write("short.csv", "timestamp,force_N", 1000.0, 0.001, 300);
    let (_, written) = imported(&short, "runs");
    assert_eq!(written.matches("[[run]]").count(), 2, "{written}");
}

#[test]
fn logs_of_instruments_and_of_merged_topics_are_read_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let imported = |name: &str, content: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, content).unwrap();
        let out = folder.path().join(format!("of-{name}"));
        said(&["import", text(&file), "-o", text(&out)]);
        let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
        // What it marks is completed: the rate that stands above the table.
        let completed = written.replace("# sample_rate_hz", "sample_rate_hz");
        std::fs::write(out.join("campaign.toml"), &completed).unwrap();
        (Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{completed}")).runs.remove(0).record, written)
    };
    let wave = |i: i32| (0.03 * f64::from(i)).sin();
    let rows: String = (0..300).map(|i| format!("{},{}\n", wave(i), 0.1 * wave(i + 30))).collect();
    let above = "Knee bench\nOperator: A\nRate: 200 Hz\n\ntorque_cmd [Nm],angle [deg]\n";
    let (record, written) = imported("bench.csv", &format!("{above}{rows}"));
    assert!(written.contains("sample_rate_hz = 200.0"), "{written}");
    assert!((record.time_s[1] - 0.005).abs() < 1e-12 && record.time_s.len() == 300);
    // Each topic has rows of its own; the slower one is brought to the clock of the other.
    let row = |i: i32| match i % 3 {
        0 => format!("{},,{}\n", 0.01 * f64::from(i), wave(i)),
        _ => format!("{},{},\n", 0.01 * f64::from(i), wave(i - 30)),
    };
    let rows: String = (0..300).map(row).collect();
    let (record, _) = imported("merged.csv", &format!("__time,/state/position,/cmd/torque\n{rows}"));
    let (angle, torque) = (record.output("joint_angle_rad"), record.input("joint_torque_nm"));
    assert!(angle.is_some_and(|a| a.len() > 150) && torque.is_some());
}

#[test]
fn bench_and_actuator_are_those_of_the_columns() {
    let folder = tempfile::tempdir().unwrap();
    let logs = [
        ("t_ms,goal_deg,pos_deg", "pendulum", "hobby-servo"),
        ("time_s,motor_torque_nm,joint_angle_rad", "pendulum", "rigid-rotary"),
        ("time_s,motor_force_n,position_m", "free", "rigid-linear"),
        ("time_s,current_a,motor_angle_rad,force_1_n", "locked", "thor-linear"),
        ("time_s,motor_torque_nm,spring_torque_nm,output_torque_nm", "locked", "rmd-x8-rotary-sea"),
        ("time_s,elbow.torque_nm,elbow.angle_rad", "robot", "rigid-rotary"),
    ];
    for (number, (columns, bench, actuator)) in logs.into_iter().enumerate() {
        let wide = columns.split(',').count() - 1;
        let row = |i: i32| format!("{}{}\n", 10 * i, format!(",{}", 30 * (i % 7)).repeat(wide));
        let rows: String = (0..40).map(row).collect();
        let file = folder.path().join(format!("log-{number}.csv"));
        std::fs::write(&file, format!("{columns}\n{rows}")).unwrap();
        let out = folder.path().join(format!("log-{number}"));
        said(&["import", text(&file), "-o", text(&out)]);
        let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
        let has = |key: &str, value: &str| written.contains(&format!("{key} = \"{value}\""));
        assert!(has("bench", bench) && has("actuator", actuator), "{columns}\n{written}");
    }
}

#[test]
fn what_cannot_be_done_is_one_message_and_status_2() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("campaign.toml"), "mine").unwrap();
    let broken = folder.path().join("broken.mat");
    std::fs::write(&broken, "no such thing").unwrap();
    for (arguments, word) in [
        (vec!["import", "nowhere.csv"], "nowhere.csv"),
        (vec!["import", text(&broken)], "broken.mat"),
        (vec!["import", text(&log("plain.mat")), "-o", text(folder.path())], "is there already"),
    ] {
        let done = sealegs(1, &arguments);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains(word) && message.lines().count() == 1, "{message}");
    }
    assert_eq!(std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap(), "mine");
}

#[test]
fn a_dataset_of_lerobot_becomes_a_robot_with_a_run_for_each_episode() {
    let dataset = tempfile::tempdir().unwrap();
    let (data, meta) = (dataset.path().join("data").join("chunk-000"), dataset.path().join("meta"));
    std::fs::create_dir_all(&data).unwrap();
    std::fs::create_dir_all(&meta).unwrap();
    let file = data.join("file-000.parquet");
    std::fs::copy(log("lerobot.parquet"), &file).unwrap();
    let info = r#"{"features": {"action": {"names": ["pan.pos"]},
        "observation.state": {"names": ["pan.pos", "lift.pos"]}}}"#;
    std::fs::write(meta.join("info.json"), info).unwrap();
    let out = dataset.path().join("mine");
    let told = said(&["import", text(&file), "-o", text(&out)]);
    assert!(told.contains("-> pan.position_rad") && told.contains("-> lift.angle_rad"), "{told}");
    for of_dataset in [dataset.path(), &dataset.path().join("data"), &meta.join("info.json")] {
        let told = said(&["import", text(of_dataset)]);
        assert!(told.contains("file-000.parquet") && told.contains("-> pan.position_rad"), "{told}");
    }
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    holds(
        &written,
        &["bench = \"robot\"", "actuator = \"hobby-servo\"", "file = \"../data/chunk-000/file-000.parquet\""],
    );
    let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(campaign.runs.len(), 3);
    assert!(campaign.runs[1].record.name.ends_with("#1"), "{}", campaign.runs[1].record.name);
    let record = &campaign.runs[0].record;
    assert!(record.input("pan.position_rad").is_some() && record.output("lift.angle_rad").is_some());
}

/// Asserts that a text has all these parts.
fn holds(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// A lift that slides, and a shoulder and an elbow on it that turn.
const LIFT: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="a"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="b"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="c"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="arm_lift_joint" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="100" velocity="1"/></joint>
  <joint name="arm_shoulder_joint" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
  <joint name="arm_elbow_joint" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/></joint>
</robot>"#;

#[test]
fn with_a_urdf_columns_get_the_names_of_its_joints() {
    let folder = tempfile::tempdir().unwrap();
    let (urdf, log, out) =
        (folder.path().join("arm.urdf"), folder.path().join("log.csv"), folder.path().join("new"));
    std::fs::write(&urdf, LIFT).unwrap();
    let wave = |n: i32| f64::from(n % 7) * 0.1;
    let rows_of = |header: &str, values: &dyn Fn(i32) -> [f64; 4]| {
        let row = |n: i32| {
            let [a, b, c, d] = values(n);
            format!("{},{a},{b},{c},{d}\n", f64::from(n) * 0.01)
        };
        std::fs::write(&log, format!("{header}\n{}", (0..40).map(row).collect::<String>())).unwrap();
        let _ = std::fs::remove_dir_all(&out);
        said(&["import", text(&urdf), text(&log), "-o", text(&out)]);
        std::fs::read_to_string(out.join("campaign.toml")).unwrap()
    };
    let rows = |header: &str| rows_of(header, &|n| [wave(n), wave(n + 1), wave(n + 2), wave(n + 3)]);
    let written = rows("t,elbow_pos,lift_pos,elbow_tau_J_d,lift_tau_J_d");
    holds(
        &written,
        &[
            "robot = \"../arm.urdf\"",
            "gravity_compensated = true",
            "\"elbow_pos\" = \"arm_elbow_joint.angle_rad\"",
            "\"lift_pos\" = \"arm_lift_joint.position_m\"",
            "\"lift_tau_J_d\" = \"arm_lift_joint.force_n\"",
        ],
    );
    // A name that says nothing is a joint by its order, which somebody has to look at.
    let written = rows("t,q[0],q[1],tau[0],tau[1]");
    holds(
        &written,
        &[
            "\"q[0]\" = \"arm_lift_joint.position_m\"",
            "\"tau[1]\" = \"arm_shoulder_joint.torque_nm\"",
            "by its order",
        ],
    );
    assert!(!written.contains("gravity_compensated"), "{written}");
    // The lift stands still, in the first column: the others keep their places, and it says where.
    let written = rows_of("t,q_0,q_1,q_2,tau_J_d_1", &|n| [1.5, wave(n), wave(n + 1), wave(n + 2)]);
    holds(
        &written,
        &[
            "\"q_0\" = \"arm_lift_joint.position_m\"",
            "the joint stands there",
            "\"q_1\" = \"arm_shoulder_joint.angle_rad\"",
            "\"q_2\" = \"arm_elbow_joint.angle_rad\"",
        ],
    );
    // A brake holds the shoulder: nothing commands it, and least of all what its sensor shows.
    let written =
        rows_of("t,q_1,tau_J_1,tau_J_d_1,tau_J_2", &|n| [wave(n), wave(n + 1), wave(n + 2), wave(n + 3)]);
    assert!(written.contains("\"tau_J_2\" = \"arm_shoulder_joint.torque_nm\""), "{written}");
    let held = std::fs::read_to_string(&log).unwrap().replace("tau_J_2", "tau_J_2,tau_J_d_2");
    let held: Vec<String> =
        held.lines().enumerate().map(|(n, l)| if n == 0 { l.into() } else { format!("{l},0") }).collect();
    std::fs::write(&log, held.join("\n")).unwrap();
    let told = said(&["import", text(&urdf), text(&log)]);
    assert!(
        !told.contains("-> arm_shoulder_joint.torque_nm")
            && told.contains("'tau_J_d_2' is taken in its place"),
        "{told}"
    );
    // The program's own names, and joints within a path.
    let written = rows(
        "t,arm_elbow_joint.position_rad,arm_elbow_joint.angle_rad,cmd.arm_shoulder_joint.q,motors.arm_shoulder_joint.q",
    );
    holds(
        &written,
        &[
            "\"arm_elbow_joint.position_rad\" = \"arm_elbow_joint.position_rad\"",
            "\"arm_elbow_joint.angle_rad\" = \"arm_elbow_joint.angle_rad\"",
            "\"cmd.arm_shoulder_joint.q\" = \"arm_shoulder_joint.position_rad\"",
            "\"motors.arm_shoulder_joint.q\" = \"arm_shoulder_joint.angle_rad\"",
            "actuator = \"hobby-servo\"",
        ],
    );
    let written = rows("t,action.arm_elbow_joint.pos,observation.arm_elbow_joint.pos,x,y");
    holds(
        &written,
        &[
            "\"action.arm_elbow_joint.pos\" = \"arm_elbow_joint.position_rad\"",
            "\"observation.arm_elbow_joint.pos\" = \"arm_elbow_joint.angle_rad\"",
        ],
    );
    // A goal's speed and a feed-forward are of a loop that commands a torque.
    let written = rows("t,elbow_q,elbow_q_des,elbow_dq_des,elbow_tau_ff");
    holds(
        &written,
        &[
            "\"elbow_q_des\" = \"arm_elbow_joint.position_rad\"",
            "\"elbow_dq_des\" = \"arm_elbow_joint.goal_speed_rad_s\"",
            "\"elbow_tau_ff\" = \"arm_elbow_joint.feedforward_nm\"",
            "actuator = \"quasi-direct-drive\"",
        ],
    );
    for (arguments, word) in [
        (vec!["import", text(&urdf)], "no log file"),
        (vec!["import", text(&urdf), text(&urdf), text(&log)], "second URDF"),
    ] {
        let done = sealegs(1, &arguments);
        let message = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{message}");
        assert!(message.contains(word), "{message}");
    }
}

/// Runs of two loggers each, of which one begins so many seconds after the other.
fn paired(apart_s: f64) {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for (n, run) in ["check", "chirp", "steps"].iter().enumerate() {
        for (part, header, step) in [("drive", "epoch,Iq_ref (A),angle", 0.01), ("temp", "epoch,T [°C]", 0.5)]
        {
            let (start, rows) = (1.7e9 + apart_s * n as f64, if part == "drive" { 1000 } else { 20 });
            let row = |i: u32| {
                let (t, x) = (start + step * f64::from(i), (0.3 * f64::from(i)).sin());
                if part == "drive" {
                    format!("{t:.3},{x},{}\n", 0.5 * x)
                } else {
                    format!("{t:.3},{}\n", 30.0 + 0.1 * x)
                }
            };
            let file = folder.path().join(format!("{run}_{part}.csv"));
            std::fs::write(&file, format!("{header}\n{}", (0..rows).map(row).collect::<String>())).unwrap();
            files.push(file);
        }
    }
    let out = folder.path().join("paired");
    let arguments: Vec<&str> =
        ["import"].into_iter().chain(files.iter().map(|f| text(f))).chain(["-o", text(&out)]).collect();
    said(&arguments);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    assert_eq!(written.matches("files = [").count(), 3, "{written}");
    let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert!(campaign.runs.iter().all(|run| run.record.input("temperature_c").is_some()), "{written}");
    let judge: Vec<&str> =
        campaign.runs_of(Role::Holdout).map(|run| run.path.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(judge, ["check_drive.csv"], "{written}");
}

#[test]
fn loggers_of_several_runs_are_paired_by_time_or_name_and_runs_that_are_called_so_judge() {
    paired(100.0);
    // Loggers whose clocks begin with each run tell nothing by their times.
    paired(0.0);
}

/// A recording of 40 entries as BAM writes them: single numbers, and what each entry says at a value of a sine.
fn recording(file: &Path, numbers: &str, says: impl Fn(f64) -> String) {
    let entry = |i: i32| {
        let (t, x) = (0.01 * f64::from(i), (0.3 * f64::from(i)).sin());
        format!("{{\"timestamp\": {t}, {}}}", says(x))
    };
    let entries: Vec<String> = (0..40).map(entry).collect();
    std::fs::write(file, format!("{{{numbers}, \"entries\": [{}]}}", entries.join(", "))).unwrap();
}

#[test]
fn what_logs_say_of_their_loads_and_gains_stands_in_their_runs() {
    let folder = tempfile::tempdir().unwrap();
    let [light, heavy, arm, out] =
        ["light.json", "heavy.json", "arm.json", "out"].map(|n| folder.path().join(n));
    let servo = |x: f64| format!("\"position\": {x}, \"goal_position\": {}", 0.9 * x);
    recording(&light, "\"mass\": 0.5, \"length\": 0.15, \"kp\": 32", servo);
    recording(&heavy, "\"mass\": 1.13, \"length\": 0.1, \"kp\": 16", servo);
    said(&["import", text(&light), text(&heavy), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
    let stated: Vec<_> = campaign.runs.iter().map(|run| (run.rig.mass_kg, run.rig.length_m)).collect();
    assert_eq!(stated, [(Some(0.5), Some(0.15)), (Some(1.13), Some(0.1))], "{written}");
    holds(&written, &["servo_gain = 32.0", "servo_gain = 16.0"]);
    // A robot has no such load, and would refuse its keys.
    let joint =
        |name: &str, x: f64| format!("\"{name}_joint_position\": {x}, \"{name}_joint_torque_cmd\": {x}");
    recording(&arm, "\"mass\": 0.5, \"length\": 0.15", |x| {
        format!("{}, {}", joint("a", x), joint("b", 0.5 * x))
    });
    let out = folder.path().join("robot");
    said(&["import", text(&arm), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
}

#[test]
fn a_measured_torque_is_no_command_where_another_topic_has_the_goal() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, header: &str| {
        let row = |i: u32| {
            let x = (0.3 * f64::from(i)).sin();
            let columns = header.split(',').count();
            let cells: Vec<String> = (1..columns).map(|k| (x * k as f64).to_string()).collect();
            format!("{},{}\n", 0.01 * f64::from(i), cells.join(","))
        };
        let file = folder.path().join(name);
        std::fs::write(&file, format!("{header}\n{}", (0..40).map(row).collect::<String>())).unwrap();
        file
    };
    let measured = "t,haa_joint_position,hfe_joint_position,haa_joint_effort,hfe_joint_effort";
    let state = write("state.csv", measured);
    let goal = write("goal.csv", "t,haa_joint_position_des,hfe_joint_position_des");
    let out = folder.path().join("leg");
    said(&["import", text(&state), text(&goal), "-o", text(&out)]);
    let written = std::fs::read_to_string(out.join("campaign.toml")).unwrap();
    holds(&written, &["# \"haa_joint_effort\"", "'haa_joint_position_des' is the command"]);
    let campaign = Campaign::read(&out).unwrap_or_else(|e| panic!("{e}\n{written}"));
    let record = &campaign.runs[0].record;
    assert!(record.input("haa_joint.position_rad").is_some(), "{written}");
    assert!(record.input("haa_joint.torque_nm").is_none(), "{written}");
}
