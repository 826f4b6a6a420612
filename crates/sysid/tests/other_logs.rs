//! Campaigns of logs as their makers published them: columns are mapped, nothing is converted.
//!
//! The logs are no part of the project: the tests look for them in `../shared/real-logs` beside it and say so where they
//! are not.

use sealegs_sysid::Campaign;
use std::path::{Path, PathBuf};

/// The folder of a rig's logs, if it is there.
fn rig(name: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real-logs").join(name);
    let found = folder.canonicalize().ok();
    if found.is_none() {
        eprintln!("{} is not there: nothing is tested", folder.display());
    }
    found
}

fn read(description: &str) -> Campaign {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("campaign.toml"), description).unwrap();
    Campaign::read(folder.path()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn published_log_of_a_carriage_in_matlab_is_read() {
    let Some(folder) = rig("emps") else { return };
    let campaign = read(&format!(
        "bench = \"locked\"\nactuator = \"a\"\n[columns]\n\"t\" = \"time_s\"\n\"qm\" = \"position_m\"\n\
         \"vir\" = {{ as = \"motor_force_n\", scale = 35.15 }}\n[[run]]\nfile = {:?}\nrole = \"fit\"\n",
        folder.join("DATA_EMPS.mat")
    ));
    let run = &campaign.runs[0];
    // One run of 24.8 s at 1 kHz.
    assert!((run.clock.duration_s - 24.8).abs() < 0.1 && (run.clock.rate_hz() - 1000.0).abs() < 0.1);
    assert!(run.record.output("position_m").unwrap().iter().all(|q| q.abs() < 1.0));
    // The amplifier gives at most 10 V.
    let peak = run.record.input("motor_force_n").unwrap().iter().fold(0.0f64, |p, f| p.max(f.abs()));
    assert!(peak > 10.0 && peak < 351.5, "{peak}");
}

#[test]
fn published_logs_of_a_servo_in_json_are_read() {
    let Some(folder) = rig("bam-xl330") else { return };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    let runs: String =
        files.iter().map(|f| format!("[[run]]\nfile = {f:?}\nrole = \"fit\"\nunit = \"xl330\"\n")).collect();
    let campaign = read(&format!(
        "bench = \"locked\"\nactuator = \"a\"\n[columns]\n\"timestamp\" = \"time_s\"\n\
         \"goal_position\" = \"position_rad\"\n\"entries.position\" = \"joint_angle_rad\"\n\
         \"speed\" = \"speed_rad_s\"\n\"torque_enable\" = \"enable\"\n\"input_volts\" = \"supply_v\"\n\
         \"temp\" = \"temperature_c\"\n{runs}"
    ));
    assert_eq!(campaign.runs.len(), 12);
    for run in &campaign.runs {
        assert_eq!(run.record.time_s[0], 0.0);
        assert!((run.clock.duration_s - 6.0).abs() < 0.5, "{}: {:?}", run.record.name, run.clock.duration_s);
        // Nominally 7.4 V; it sags and is fed back into.
        assert!(run.record.input("supply_v").unwrap().iter().all(|v| (v - 7.4).abs() < 2.5));
        let names: Vec<&str> = run.record.inputs.iter().map(|s| s.channel.as_str()).collect();
        // The temperature is beside the input: a friction may fall with it.
        assert_eq!(names, ["position_rad", "enable", "supply_v", "temperature_c"]);
    }
    // In some of the runs the servo is released.
    let released = |run: &&sealegs_sysid::Run| run.record.input("enable").unwrap().contains(&0.0);
    assert!(campaign.runs.iter().filter(released).count() > 0);
}

#[test]
fn published_logs_of_a_double_pendulum_in_csv_are_read() {
    let Some(folder) = rig("double-pendulum") else { return };
    let columns = "\"time\" = \"time_s\"\n\"pos_meas1\" = \"joint1.angle_rad\"\n\"pos_meas2\" = \"joint2.angle_rad\"\n\
        \"tau_con1\" = \"joint1.torque_nm\"\n\"tau_con2\" = \"joint2.torque_nm\"\n";
    let campaign = read(&format!(
        "bench = \"leg\"\nscenario = \"s\"\ninputs = [\"joint1.torque_nm\", \"joint2.torque_nm\"]\n[columns]\n{columns}\
         [[run]]\nfile = {:?}\nrole = \"fit\"\n",
        folder.join("design-a-trajectory-00.csv")
    ));
    let run = &campaign.runs[0];
    assert!((run.clock.duration_s - 10.0).abs() < 0.1, "{}", run.clock.duration_s);
    assert_eq!((run.record.inputs.len(), run.record.outputs.len()), (2, 2));
    assert!(run.unknown.iter().any(|s| s.channel == "tau_meas2"));
}
