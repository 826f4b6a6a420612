//! What is wrong with a log: faults put into the logs of an independent simulator, and logs that have none.

mod program;

use program::{json, sealegs};
use sealegs::reference::campaign::{BEYOND, CATALOGUE, Hidden, Made, Order, Rig, Rough};
use sealegs::sysid::Campaign;
use sealegs::sysid::sanity::{Finding, Problem, Severity, look};
use sealegs::{bench_model, sanity::gate};
use std::path::Path;

/// Steps of the integrator per row: 50 us, as where strengths are looked for.
const SUBSTEPS: usize = 20;

fn made(rig: Rig, seed: u64, hidden: Vec<Hidden>, rough: Vec<Rough>) -> Made {
    Order { name: "made".to_owned(), rig, seed, hidden, duration_s: 4.0, substeps: SUBSTEPS, rough }.make()
}

fn write(made: &Made, folder: &Path) {
    for (file, text) in made.files() {
        std::fs::write(folder.join(file), text).unwrap();
    }
}

/// What is found in a campaign's files.
fn found(made: &Made) -> (Campaign, Vec<Finding>) {
    let folder = tempfile::tempdir().unwrap();
    write(made, folder.path());
    let mut campaign = Campaign::read(folder.path()).unwrap();
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new()).unwrap();
    let findings = look(&campaign, &model);
    (campaign, findings)
}

/// A pendulum's campaign with every value of some columns changed.
fn with(columns: &[&str], change: impl Fn(f64) -> f64) -> Vec<Finding> {
    let mut made = made(Rig::Pendulum, 4, Vec::new(), Vec::new());
    for run in &mut made.runs {
        for signal in run.record.outputs.iter_mut().chain(&mut run.record.inputs) {
            if columns.contains(&signal.channel.as_str()) {
                signal.values.iter_mut().for_each(|v| *v = change(*v));
            }
        }
    }
    found(&made).1
}

/// What stops a diagnosis.
fn told(findings: &[Finding]) -> Vec<(Problem, &str, Severity)> {
    findings.iter().filter(|f| f.stops()).map(|f| (f.problem, f.channel.as_str(), f.severity)).collect()
}

#[test]
fn reference_signs_units_and_names_are_told_apart() {
    let forces = ["force_1_n", "force_2_n"];
    let flipped = with(&forces, |v| -v);
    let stops = Severity::Stops;
    assert_eq!(told(&flipped), forces.map(|c| (Problem::FlippedSign, c, stops)));
    assert!(flipped[0].sentence().contains("`force_1_n` runs against the model with slope -"), "{flipped:?}");
    let degrees = with(&["joint_angle_rad"], f64::to_degrees);
    assert_eq!(told(&degrees), [(Problem::UnitFactor, "joint_angle_rad", stops)]);
    assert!(degrees[0].sentence().contains("degrees?"), "{degrees:?}");
    let current = with(&["current_a"], |v| -v);
    assert_eq!(told(&current), [(Problem::FlippedSign, "current_a", stops)]);
}

#[test]
fn reference_exchanged_columns_are_found_where_they_differ() {
    let mut made = made(Rig::Pendulum, 4, Vec::new(), Vec::new());
    assert_eq!(told(&found(&made).1), []);
    let (a, b) = ("motor_angle_rad", "joint_angle_rad");
    for signal in made.runs.iter_mut().flat_map(|r| &mut r.record.outputs) {
        if signal.channel == a {
            signal.channel = b.to_owned();
        } else if signal.channel == b {
            signal.channel = a.to_owned();
        }
    }
    let findings = found(&made).1;
    assert!(findings[0].problem == Problem::SwappedColumns && findings[0].stops(), "{findings:?}");
    for name in [a, b] {
        assert!(findings[0].evidence.contains(name), "{findings:?}");
    }
}

#[test]
fn reference_no_effect_of_the_catalogue_or_beyond_it_stops_a_diagnosis() {
    for rig in [Rig::Locked, Rig::Pendulum] {
        for (i, id) in CATALOGUE.iter().chain(&BEYOND).enumerate().filter(|(_, id)| Hidden::applies(id, rig))
        {
            // As strong as it comes: delays of 3 ms, play of a tenth of a millimetre, friction of 90 N.
            let hidden = Hidden::drawn(id, 20 + i as u64, 3.0);
            let findings = found(&made(rig, 20 + i as u64, vec![hidden], Vec::new())).1;
            assert!(findings.iter().all(|f| !f.stops()), "{id}, {rig:?}: {findings:#?}");
        }
    }
}

#[test]
fn reference_rough_logs_are_said_to_be_rough_and_stop_nothing() {
    for rough in Rough::ALL {
        let (campaign, findings) = found(&made(Rig::Pendulum, 7, Vec::new(), vec![rough]));
        assert!(findings.iter().all(|f| !f.stops()), "{rough:?}: {findings:#?}");
        let problems: Vec<Problem> = findings.iter().map(|f| f.problem).collect();
        assert_eq!(problems.contains(&Problem::Spikes), rough == Rough::Spikes, "{findings:#?}");
        assert_eq!(problems.contains(&Problem::RepeatedRows), rough == Rough::RepeatedRows, "{findings:#?}");
        if rough == Rough::NoStatedNoise {
            for (channel, std) in made(Rig::Pendulum, 7, Vec::new(), Vec::new()).noise_std {
                let ratio = campaign.noise_std(channel).unwrap().std / std;
                assert!((0.8..1.4).contains(&ratio), "{channel}: {ratio} of its noise");
            }
        }
    }
}

#[test]
fn a_spike_is_left_out_and_everything_else_counts() {
    let (campaign, _) = found(&made(Rig::Locked, 7, Vec::new(), vec![Rough::Spikes]));
    let plain = made(Rig::Locked, 7, Vec::new(), Vec::new());
    for (run, plain) in campaign.runs.iter().zip(&plain.runs) {
        let (rough, smooth) = (&run.record.outputs[0].values, &plain.record.outputs[0].values);
        let off: Vec<usize> =
            (0..run.record.len()).filter(|&i| (rough[i] - smooth[i]).abs() > 100.0).collect();
        assert!(off.len() > 5, "{off:?}");
        let left_out = run.left_out.rows();
        assert!(left_out.iter().all(|row| off.contains(row)), "{left_out:?} of {off:?}");
        assert!(10 * left_out.len() >= 9 * off.len(), "{left_out:?} of {off:?}");
        let counted: usize = run.counted().iter().map(std::ops::Range::len).sum();
        assert_eq!(counted, run.record.len() - left_out.len());
    }
}

#[test]
fn a_log_that_is_not_what_it_says_is_not_diagnosed_unless_forced() {
    let folder = tempfile::tempdir().unwrap();
    let mut made = made(Rig::Pendulum, 4, Vec::new(), Vec::new());
    for signal in made.runs.iter_mut().flat_map(|r| &mut r.record.outputs) {
        if signal.channel == "force_2_n" {
            signal.values.iter_mut().for_each(|v| *v = -*v);
        }
    }
    let campaign = folder.path().join("bench");
    std::fs::create_dir(&campaign).unwrap();
    write(&made, &campaign);
    let (place, out) = (campaign.to_str().unwrap(), folder.path().join("out.json"));
    let done = sealegs(2, &["diagnose", place, "--json", out.to_str().unwrap()]);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{error}");
    assert!(error.contains("`force_2_n` runs against the model") && error.contains("--force"), "{error}");
    assert!(error.trim_end().lines().count() == 1 && !out.exists(), "{error}");

    let done = sealegs(2, &["check", place, "--json", out.to_str().unwrap()]);
    assert_eq!(done.status.code(), Some(0));
    let text = String::from_utf8_lossy(&done.stdout);
    let (sanity, runs) = (text.find("Checks of the log").unwrap(), text.find("\nRun ").unwrap());
    assert!(sanity < runs, "shown first: {text}");
    let told = &json(&out)["sanity"][0];
    for (key, value) in [("channel", "force_2_n"), ("problem", "flipped-sign"), ("severity", "stops")] {
        assert_eq!(told[key], value);
    }
    assert!(told["evidence"].as_str().unwrap().contains("slope") && told["cure"].is_string());

    let findings = found(&made).1;
    assert!(gate(&campaign, &findings, false).is_err() && gate(&campaign, &findings, true).is_ok());
    assert!(gate(&campaign, &[], false).is_ok());
}
