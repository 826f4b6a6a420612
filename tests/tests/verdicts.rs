//! What a verdict names and calls indistinguishable: richer laws only where the data leave open what they add, what
//! one moment alone has felt where it explains all of it, a count a thousandth of the greatest command, a delay that
//! may be a sample longer, and a curve where no effect explains anything.

use sealegs::bench_model;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::Bench;
use sealegs_actuator::excitation::Profile;
use sealegs_reference::Reference;
use sealegs_reference::campaign::{Hidden, Order, Rig, SUBSTEPS};
use sealegs_sysid::diagnose::{Diagnosis, VerdictKind};
use sealegs_sysid::{Campaign, diagnose};
use std::fmt::Write as _;
use std::path::Path;

const PERIOD_S: f64 = 1e-3;
const FORCE_NOISE_N: f64 = 2.0;
const ANGLE_NOISE_RAD: f64 = 4.43e-4;

/// A hidden effect with its values, N.
const COULOMB: (&str, &[f64]) = ("coulomb-friction", &[30.0]);

/// Writes a campaign on the locked bench with a hidden effect, from currents in A; a load cell and, if it has one, an
/// encoder at the rotor are logged.
fn write(folder: &Path, (hidden, values): (&str, &[f64]), encoder: bool, runs: &[(&str, Vec<f64>)]) {
    let spec = ActuatorSpec::preset("thor-linear").unwrap();
    let truth = Reference::of(&spec, Bench::Locked, "current_a").with(hidden, values);
    let mut campaign = format!(
        "name = \"hidden\"\nbench = \"locked\"\nactuator = \"thor-linear\"\nsample_rate_hz = 1000.0\n\n[noise_std]\n\
         force_1_n = {FORCE_NOISE_N}\n"
    );
    if encoder {
        writeln!(campaign, "motor_angle_rad = {ANGLE_NOISE_RAD}").unwrap();
    }
    for (seed, (role, command)) in (1..).zip(runs) {
        let out = truth.run(PERIOD_S, command, 100);
        let time_s: Vec<f64> = (0..command.len()).map(|n| n as f64 * PERIOD_S).collect();
        // Nearly white: what is noise lies within the whole band of the samples.
        let noise = |seed| Profile::Noise { rms: 1.0, bandwidth_hz: 500.0, seed }.sample(&time_s);
        let (of_force, of_angle) = (noise(seed), noise(100 + seed));
        let mut csv = String::from("time_s,current_a,force_1_n");
        csv.push_str(if encoder { ",motor_angle_rad\n" } else { "\n" });
        for (n, t) in time_s.iter().enumerate() {
            let force = out.force_1[n] + FORCE_NOISE_N * of_force[n];
            let angle = out.extension[n] / truth.travel_per_rad + ANGLE_NOISE_RAD * of_angle[n];
            write!(csv, "{t:.4},{:.6},{force:.3}", command[n]).unwrap();
            if encoder {
                write!(csv, ",{angle:.7}").unwrap();
            }
            csv.push('\n');
        }
        std::fs::write(folder.join(format!("run_{seed}.csv")), csv).unwrap();
        write!(campaign, "\n[[run]]\nfile = \"run_{seed}.csv\"\nrole = \"{role}\"\n").unwrap();
    }
    std::fs::write(folder.join("campaign.toml"), campaign).unwrap();
}

fn diagnosis(hidden: (&str, &[f64]), encoder: bool, runs: &[(&str, Vec<f64>)]) -> Diagnosis {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), hidden, encoder, runs);
    let mut campaign = Campaign::read(folder.path()).unwrap();
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new()).unwrap();
    diagnose::diagnose(&campaign, &model, &|_, _| ()).unwrap()
}

/// What is named and what is called indistinguishable from it.
fn diagnosed(
    hidden: (&str, &[f64]),
    encoder: bool,
    runs: &[(&str, Vec<f64>)],
) -> (Vec<String>, Vec<Vec<String>>) {
    let verdict = diagnosis(hidden, encoder, runs).verdict;
    (verdict.effects, verdict.indistinguishable)
}

fn sampled(profile: &Profile, duration_s: f64) -> Vec<f64> {
    let samples = (duration_s / PERIOD_S) as usize;
    profile.sample(&(0..samples).map(|n| n as f64 * PERIOD_S).collect::<Vec<f64>>())
}

fn sine(amplitude: f64, frequency_hz: f64) -> Vec<f64> {
    sampled(&Profile::Sine { amplitude, frequency_hz, phase_rad: 0.0 }, 3.0)
}

fn one(id: &str) -> Vec<String> {
    vec![id.to_owned()]
}

#[test]
fn coulomb_and_stribeck_friction_are_tied_where_speed_never_falls_low() {
    // Driven hard the rotor turns round at once, and what a static level does in that moment is lost in the load cell's
    // noise.
    let runs = [("fit", sine(4.0, 12.0)), ("fit", sine(3.5, 17.0)), ("holdout", sine(3.8, 14.0))];
    let (named, tied) = diagnosed(COULOMB, false, &runs);
    let all: Vec<&Vec<String>> = tied.iter().chain([&named]).collect();
    for id in ["coulomb-friction", "stribeck-friction"] {
        assert!(all.contains(&&one(id)), "{id} neither named nor tied: {named:?} {tied:?}");
    }
}

#[test]
fn a_law_that_is_fitted_as_coulomb_friction_is_no_tie_of_it() {
    let steps = |amplitude: f64| {
        let noise = Profile::Noise { rms: amplitude, bandwidth_hz: 3.0, seed: amplitude.to_bits() };
        sampled(&noise, 3.0)
    };
    let runs = [("fit", steps(0.8)), ("fit", sine(1.0, 4.0)), ("holdout", steps(0.7))];
    let (named, tied) = diagnosed(COULOMB, true, &runs);
    assert_eq!(named, one("coulomb-friction"));
    for id in ["stribeck-friction", "direction-dependent-friction"] {
        assert!(!tied.contains(&one(id)), "{tied:?}");
    }
}

#[test]
fn a_limit_that_one_moment_alone_has_felt_is_named_where_it_explains_everything() {
    let limited = ("current-saturation", &[4.0][..]);
    let noise = |seed| sampled(&Profile::Noise { rms: 1.0, bandwidth_hz: 10.0, seed }, 3.0);
    let with_a_pulse = |seed| {
        let mut command = noise(seed);
        command[1400..1500].fill(5.0);
        command
    };
    let runs = [("fit", noise(1)), ("fit", with_a_pulse(2)), ("holdout", with_a_pulse(3))];
    let (named, tied) = diagnosed(limited, true, &runs);
    assert_eq!(named, one("current-saturation"), "{tied:?}");
}

#[test]
fn a_fine_count_is_found_and_its_standard_error_is_the_room_that_it_has() {
    const COUNT_A: f64 = 0.003;
    let noise = |seed| sampled(&Profile::Noise { rms: 1.0, bandwidth_hz: 10.0, seed }, 3.0);
    let runs = [("fit", noise(1)), ("fit", noise(2)), ("holdout", noise(3))];
    let most = runs.iter().flat_map(|r| &r.1).fold(0.0, |m: f64, u| m.max(u.abs()));
    assert!(most > 900.0 * COUNT_A, "{most} A is not a fine count");
    let Diagnosis { verdict, found, .. } = diagnosis(("command-quantisation", &[COUNT_A, 1.0]), true, &runs);
    assert_eq!(verdict.effects, one("command-quantisation"));
    let fit = &found.tried[verdict.after.index].fit;
    let count = fit.parameters.iter().find(|p| p.name == "command-quantisation.count_a").unwrap();
    let off = (count.value - COUNT_A).abs();
    assert!(off < 4.0 * count.std && count.std < 1e-3 * COUNT_A, "{off} off, standard error {}", count.std);
}

#[test]
fn a_delay_may_be_a_sample_longer_or_shorter_by_the_end_of_a_period_that_rows_are_stamped_at() {
    const DELAY_S: f64 = 3.4e-3;
    let noise = |seed| sampled(&Profile::Noise { rms: 1.0, bandwidth_hz: 10.0, seed }, 3.0);
    let runs = [("fit", noise(1)), ("fit", noise(2)), ("holdout", noise(3))];
    let Diagnosis { verdict, found, .. } = diagnosis(("transport-delay", &[DELAY_S]), true, &runs);
    let tried: Vec<String> = (found.tried.iter())
        .map(|t| format!("{}: {:.4} {:.4}", t.effects.join(" + "), t.fit.error(), t.validation.mean_square()))
        .collect();
    assert_eq!(verdict.effects, one("transport-delay"), "{tried:#?}");
    let fit = &found.tried[verdict.after.index].fit;
    let stated = fit.parameters.iter().find(|p| p.name == "transport-delay.delay_s").unwrap();
    let [open] = &found.open[..] else { panic!("{:?}", found.open) };
    let [(name, other)] = &open.values[..] else { panic!("{:?}", open.values) };
    assert_eq!(name, "transport-delay.delay_s");
    assert!(
        ((stated.value - other).abs() - PERIOD_S).abs() < 0.02 * PERIOD_S,
        "{} and {other}",
        stated.value
    );
    let off = [stated.value, *other].map(|value| (value - DELAY_S).abs());
    assert!(off.iter().any(|off| *off < 4.0 * stated.std), "{off:?} off, standard error {}", stated.std);
}

#[test]
fn a_curve_that_takes_what_no_effect_takes_ends_the_search() {
    let id = "kinked-spring";
    let order = Order {
        name: id.to_owned(),
        rig: Rig::Locked,
        seed: 5,
        hidden: vec![Hidden::drawn(id, 5, 1.0)],
        duration_s: 6.0,
        substeps: SUBSTEPS,
        rough: Vec::new(),
    };
    let folder = tempfile::tempdir().unwrap();
    for (file, text) in order.make().files() {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    let mut campaign = Campaign::read(folder.path()).unwrap();
    let model = bench_model::of_campaign(&mut campaign, None, Vec::new()).unwrap();
    let Diagnosis { verdict, found, .. } = diagnose::diagnose(&campaign, &model, &|_, _| ()).unwrap();
    assert_eq!(verdict.kind, VerdictKind::Unexplained);
    let law = verdict.law.expect("a curve");
    let curve = &found.laws[law.which];
    assert!((curve.law.acts_on.as_str(), curve.on) == ("spring", "deflection") && law.explained > 0.9);
    assert!(found.tried.iter().all(|set| set.effects.len() < 2), "a pair was fitted");
}
