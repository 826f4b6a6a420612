//! Exported models run in MuJoCo itself: what a model gains in our simulator it must gain there.

use sealegs::campaign_model::CampaignModel;
use sealegs::diagnosis::addition::add;
use sealegs::mystery::trial::campaign_of;
use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::bench::BenchModel;
use sealegs_actuator::effect::{Effect, OwnEffect};
use sealegs_export::{Fate, Format};
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use sealegs_model::{Model, Record, Signal};
use sealegs_reference::campaign::{CATALOGUE, Hidden, Individual, Made, Order, Rig, SUBSTEPS, Stamp};
use sealegs_sysid::fit::{self, FitOptions};
use sealegs_sysid::{Campaign, Data, Fit, Role};
use sealegs_tests::mujoco::{BenchJob, Played, at, everything, job, python, rms, run};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Where a virtual environment may be made.
fn folder() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn made(rig: Rig, seed: u64, hidden: Vec<Hidden>, duration_s: f64) -> Made {
    Order { name: "made".to_owned(), rig, seed, hidden, duration_s, substeps: SUBSTEPS, rough: Vec::new() }
        .make()
}

/// Root mean square difference of two simulators' signals in units of the campaign's noise.
fn apart(made: &Made, a: &[Signal], b: &[Signal]) -> f64 {
    let of = |signals: &[Signal], channel: &str| {
        signals.iter().find(|s| s.channel == channel).unwrap().values.clone()
    };
    rms(made.noise_std.iter().flat_map(|(channel, noise)| {
        let pairs = of(a, channel).into_iter().zip(of(b, channel));
        pairs.map(move |(a, b)| (a - b) / noise).collect::<Vec<f64>>()
    }))
}

/// The seed of an individual whose logger stamps rows at the start: the command is in force from its time stamp on.
fn plain_seed() -> u64 {
    (0..).find(|seed| Individual::drawn(*seed).stamp == Stamp::Start).unwrap()
}

/// Laws of a user's own, one for each place.
const OWN: [&str; 4] = [
    "id = \"grease\"\nacts-on = \"rotor\"\nlaw = \"c*y_dot^3 + f*tanh(y_dot/v0)*abs(F_bs)/(abs(F_bs) + 10)\"\nparameters = { c = { guess = \
     1e6, min = 0.0, max = 1e9 }, f = { guess = 20.0, min = 0.0, max = 1e3 }, v0 = { fixed = 1e-3 } }",
    "id = \"heat\"\nacts-on = \"drive\"\nlaw = \"u*(1 - a*tanh(abs(y_dot)/v0))\"\nparameters = { a = { guess = 0.2, min = 0.0, max = \
     1.0 }, v0 = { fixed = 0.01 } }",
    "id = \"rubber\"\nacts-on = \"spring\"\nlaw = \"k_3*delta^3 + c*delta_dot\"\nparameters = { k_3 = { guess = 3e10, min = 0.0, max = \
     1e14 }, c = { guess = 300.0, min = 0.0, max = 1e5 } }",
    "id = \"seal\"\nacts-on = \"output\"\nlaw = \"m*tanh(theta_dot/w0)\"\nparameters = { m = { guess = 0.4, min = 0.0, max = 10.0 }, \
     w0 = { fixed = 0.05 } }",
];

fn read(text: &str) -> Arc<dyn Effect> {
    Arc::new(OwnEffect::from_toml(text, "own.toml").unwrap())
}

/// Effects that the other simulator does not make, with values, and whether they act on a lever alone.
const OURS_ALONE: [(&str, &[f64], bool); 4] = [
    ("directional-efficiency", &[0.2, 0.05], false),
    ("warming-friction", &[30.0, 0.8, 0.5], false),
    ("output-offset", &[3.0], true),
    ("cable-stiffness", &[20.0, 0.3], true),
];

/// How strong an effect is made, in practice campaigns' usual ones, so that this command shows it.
fn strength(id: &str) -> f64 {
    match id.split('@').next().unwrap_or(id) {
        "structural-mode" => 12.0,
        // A softer one than a stiffness that is fitted takes up.
        "series-compliance" => 30.0,
        "current-saturation" | "voltage-saturation" | "sensor-lag" => 4.0,
        "hardening-spring" => 2.0,
        _ => 1.0,
    }
}

#[test]
fn reference_every_effect_does_in_mujoco_what_it_does_here() {
    let Some(python) = python(folder()) else { return };
    let seed = plain_seed();
    let (mut jobs, mut ours, mut names): (Vec<BenchJob>, _, Vec<String>) =
        (Vec::new(), Vec::new(), Vec::new());
    let own: Vec<Arc<dyn Effect>> = OWN.iter().map(|text| read(text)).collect();
    for rig in [Rig::Locked, Rig::Pendulum] {
        let plain = made(rig, seed, Vec::new(), 1.5);
        let channels: Vec<String> = plain.noise_std.iter().map(|n| n.0.to_owned()).collect();
        // A staircase with noise: it rests, starts and turns round.
        let record = &plain.runs[1].record;
        let spec = ActuatorSpec::preset("thor-linear").unwrap();
        let base = BenchModel::with_own_effects(spec, rig.bench(), own.clone()).unwrap();
        let predict = |model: &BenchModel| {
            let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
            // A fifth of the usual step, so that what is seen is MuJoCo's error.
            model.clone().with_step(2e-5).predict(&values, record, &channels).unwrap().outputs
        };
        let without = predict(&base);
        let more = ["nothing", "sensor-delay@motor_angle_rad", "grease", "heat", "rubber", "seal"];
        // What acts on one another in the files: a limit behind a delay, friction that feels play.
        let sets = [
            "transport-delay+voltage-saturation+current-saturation",
            "backlash+load-dependent-friction+series-compliance",
        ];
        let alone = OURS_ALONE.iter().filter(|(_, _, lever)| rig == Rig::Pendulum || !lever).map(|e| e.0);
        let ids = CATALOGUE.iter().copied().chain(more).chain(sets).filter(|id| Hidden::applies(id, rig));
        for id in ids.filter(|id| *id != "seal" || rig == Rig::Pendulum).chain(alone) {
            let mut model = base.clone();
            let mut values: Vec<f64> = base.parameters().iter().map(|p| p.value).collect();
            for part in id.split('+').filter(|part| *part != "nothing") {
                model = model.including(part, &everything()).unwrap();
                if let Some((_, given, _)) = OURS_ALONE.iter().find(|e| e.0 == part) {
                    values.extend(*given);
                } else if OWN.iter().any(|text| text.contains(&format!("id = \"{part}\""))) {
                    values.extend(model.parameters()[values.len()..].iter().map(|p| p.value));
                } else {
                    values.extend(Hidden::drawn(part, 5, strength(part)).parameters.iter().map(|p| p.1));
                }
            }
            let model = at(&model, &values);
            let exported = sealegs_export::bench(Format::Mjcf, &model, "current_a", "bench").unwrap();
            // What the file says that it has not, it has not.
            if exported.notes.iter().any(|note| note.what == id && note.fate == Fate::Lost) {
                continue;
            }
            jobs.push(job(&model, &[record]));
            let with = predict(&model);
            let effect = apart(&plain, &with, &without);
            ours.push((with, effect, plain.clone()));
            names.push(format!("{id} on the {} bench", rig.as_str()));
        }
    }
    let (shown, _) = run(&python, jobs, &[]);
    let mut faults = Vec::new();
    let mut greatest: BTreeMap<String, f64> = BTreeMap::new();
    for ((name, (with, effect, plain)), shown) in names.iter().zip(&ours).zip(&shown) {
        let error = apart(plain, with, &shown[0]);
        println!("{name:<50} effect {effect:9.2}   MuJoCo apart {error:8.3} noise units");
        // A yielding spring is 2 % off, see its step; dry friction, a soft constraint in MuJoCo, 0.3 %; the rest nothing.
        let most = if name.starts_with("presliding") || name.starts_with("spring-hysteresis") {
            0.03
        } else {
            0.005
        };
        if error > most * effect + 0.02 {
            faults.push(format!("{name}: effect {effect:.2}, apart {error:.3}"));
        }
        let id = name.split(' ').next().unwrap_or_default();
        if id != "nothing" {
            let greatest = greatest.entry(id.to_owned()).or_insert(0.0f64);
            *greatest = greatest.max(*effect);
        }
    }
    // Beside an effect that nobody sees nothing would be shown.
    faults.extend(
        greatest.iter().filter(|(_, e)| **e < 3.0).map(|(id, e)| format!("{id} is not seen: {e:.2}")),
    );
    assert!(faults.is_empty(), "{faults:#?}");
}

/// One side of a comparison: the fitted model, and its sensors as the fit runs left them.
struct Side<'a> {
    model: BenchModel,
    fit: &'a Fit,
}

/// A campaign with the model before and after.
struct Case {
    name: String,
    campaign: Campaign,
    before: (BenchModel, Fit),
    after: (BenchModel, Fit),
}

/// An effect hidden in a campaign, and the model that `sealegs add` writes.
fn hidden(id: &str, rig: Rig, seed: u64) -> Case {
    let made = made(rig, seed, vec![Hidden::drawn(id, seed, strength(id))], 3.0);
    let (campaign, model) = campaign_of(&made).unwrap();
    let added = add(&campaign, &model, &[id.to_owned()], &|_| ()).unwrap();
    let better = model.better(&added.fitted(), &campaign, &[], Path::new(".")).unwrap();
    let after =
        BenchModel::new(ActuatorSpec::from_toml(&better, "better.toml").unwrap(), rig.bench()).unwrap();
    let before = at(&model, &added.before.fit.values);
    Case {
        name: format!("{id} on the {} bench", rig.as_str()),
        campaign,
        before: (before, added.before.fit),
        after: (after, added.after.fit),
    }
}

/// A fitted base model, and the same with one of its parameters misstated; nothing else takes that up.
fn misstated(parameter: &str, ratio: f64, seed: u64) -> Case {
    let made = made(Rig::Locked, seed, Vec::new(), 3.0);
    let (campaign, model) = campaign_of(&made).unwrap();
    let data = Data::new(&campaign, Some(Role::Fit), &model).unwrap();
    let fitted = |start: Vec<f64>, held: Vec<String>| {
        fit::fit(&data, &model, &FitOptions { start: Some(start), held, ..FitOptions::of(&model) }).unwrap()
    };
    let choices = fit::choices(&model).into_iter().map(|choice| fitted(choice, Vec::new()));
    let after = choices.min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap();
    let mut wrong = after.values.clone();
    wrong[model.parameters().iter().position(|p| p.name == parameter).unwrap()] *= ratio;
    let before = fitted(wrong, model.parameters().iter().map(|p| p.name.clone()).collect());
    Case {
        name: format!("{parameter} misstated by {ratio}"),
        before: (at(&model, &before.values), before),
        after: (at(&model, &after.values), after),
        campaign,
    }
}

#[test]
fn reference_the_error_falls_in_mujoco_as_it_falls_here() {
    let Some(python) = python(folder()) else { return };
    let cases = [
        hidden("coulomb-friction", Rig::Locked, 3),
        hidden("stribeck-friction", Rig::Locked, 3),
        hidden("quadratic-drag", Rig::Locked, 3),
        misstated("damping", 0.6, 3),
        misstated("reflected_inertia", 0.8, 3),
        hidden("transport-delay", Rig::Locked, 3),
        hidden("current-saturation", Rig::Locked, 3),
        hidden("backlash", Rig::Locked, 3),
        hidden("series-compliance", Rig::Locked, 3),
        hidden("coulomb-friction", Rig::Pendulum, 3),
        hidden("backlash", Rig::Pendulum, 3),
    ];
    let holdout = |case: &Case| -> Vec<Record> {
        case.campaign.runs_of(Role::Holdout).map(|run| run.record.clone()).collect()
    };
    let mut jobs = Vec::new();
    for case in &cases {
        let records = holdout(case);
        let records: Vec<&Record> = records.iter().collect();
        jobs.push(job(&case.before.0, &records));
        jobs.push(job(&case.after.0, &records));
    }
    let (shown, _) = run(&python, jobs, &[]);
    let mut faults = Vec::new();
    println!(
        "{:<38} {:>21}   {:>21}   falls",
        "held-out runs, noise units", "sealegs: before after", "MuJoCo: before after"
    );
    for (case, shown) in cases.iter().zip(shown.chunks(2)) {
        let records = holdout(case);
        let judged = |side: &Side, shown: &[Vec<Signal>]| {
            let data = Data::new(&case.campaign, Some(Role::Holdout), &side.model).unwrap();
            let values: Vec<f64> = side.model.parameters().iter().map(|p| p.value).collect();
            let ours = data.judge(&side.model, &values, side.fit.sensors()).unwrap().rms;
            let names = records.iter().map(|r| r.name.clone());
            let played = Played { shown: names.zip(shown.iter().cloned()).collect() };
            (ours, data.judge(&played, &[], side.fit.sensors()).unwrap().rms)
        };
        let before = judged(&Side { model: case.before.0.clone(), fit: &case.before.1 }, &shown[0]);
        let after = judged(&Side { model: case.after.0.clone(), fit: &case.after.1 }, &shown[1]);
        let falls = (before.0 - after.0, before.1 - after.1);
        println!(
            "{:<38} {:>11.3} {:>9.3}   {:>11.3} {:>9.3}   {:.4}",
            case.name,
            before.0,
            after.0,
            before.1,
            after.1,
            falls.1 / falls.0
        );
        // The effect must matter, and our own model must explain most of it, for the fall to say anything.
        if !(before.0 > 5.0 && after.0 < 0.2 * before.0) {
            faults.push(format!("{}: {before:?} {after:?}: our own error does not fall", case.name));
        }
        if (falls.1 / falls.0 - 1.0).abs() > 0.1 {
            faults.push(format!("{}: {before:?} {after:?}: falls {falls:?}", case.name));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn reference_a_leg_loads_weighs_the_same_and_lands() {
    let Some(python) = python(folder()) else { return };
    let scenario = Scenario::load("thor-drop", &[]).unwrap();
    let mjcf = sealegs_export::leg(Format::Mjcf, &scenario, "leg").unwrap();
    let urdf = sealegs_export::leg(Format::Urdf, &scenario, "leg").unwrap();
    // Half a second: the fall from 0.1 m takes 0.14 s.
    let legs = [("leg.xml", mjcf.text.as_str(), 5000), ("leg.urdf", urdf.text.as_str(), 0)];
    let (_, weighed) = run(&python, Vec::new(), &legs);
    // Links of the URDF, six sprung masses (Table 5), the carriage.
    let mass_kg = Robot::load("thor-leg", None).unwrap().mass_kg() + 6.0 * 0.6461 + 20.0;
    for leg in &weighed {
        assert!((leg.mass_kg / mass_kg - 1.0).abs() < 1e-9, "{} kg and {mass_kg} kg", leg.mass_kg);
        assert_eq!(leg.warnings, 0);
    }
    // Six joints and the rail; in MJCF the screw and the spring of each of six actuators, too.
    assert_eq!((weighed[0].dofs, weighed[0].actuators, weighed[1].dofs), (7 + 12, 6, 7));
    let heights = &weighed[0].heights_m;
    let fallen = |step: usize| heights[0] - heights[step];
    // Free fall first, 9.81 t^2 / 2 at 0.1 s; then the ground holds it up.
    assert!((fallen(1000) - 0.04905).abs() < 5e-4, "{}", fallen(1000));
    let last = heights.len() - 1;
    assert!(
        fallen(last) > 0.1 && fallen(last) < 0.5 && weighed[0].speed < 100.0,
        "{} {}",
        fallen(last),
        weighed[0].speed
    );
}

#[test]
fn reference_a_leg_without_current_sinks_in_mujoco_as_it_sinks_here() {
    let Some(python) = python(folder()) else { return };
    let free =
        ["controller.kind=\"free\"", "start.springs=\"unloaded\"", "duration_s=0.5"].map(str::to_owned);
    let scenario = Scenario::load("thor-swing", &free).unwrap();
    let (ours, _) = sealegs_leg::channels(&scenario, Robot::load("thor-leg", None).unwrap()).unwrap();
    let mjcf = sealegs_export::leg(Format::Mjcf, &scenario, "leg").unwrap();
    let (_, shown) = run(&python, Vec::new(), &[("leg.xml", mjcf.text.as_str(), 5000)]);
    let (mut moved, mut apart) = (0.0f64, 0.0f64);
    for (joint, theirs) in &shown[0].joints {
        let Some(angle) = ours.get(&format!("{joint}.angle_rad")) else { continue };
        let (start, end) = (angle[0], angle[angle.len() - 1]);
        println!("{joint:<12} from {start:7.4} to {end:7.4} rad, in MuJoCo to {theirs:7.4}");
        moved = moved.max((end - start).abs());
        apart = apart.max((end - theirs).abs());
    }
    // Weight against rotors, springs and linkages. The linkages' polynomials are 1 % off in their arms.
    assert!(moved > 0.05 && apart < 0.02 * moved, "moved by {moved} rad, apart by {apart}");
}

#[test]
fn reference_an_isaac_lab_module_is_python_with_fields_that_its_classes_have() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("mujoco/isaaclab.py");
    let read = |exported: &sealegs_export::Exported| -> Option<serde_json::Value> {
        let file = folder.path().join("robot.py");
        std::fs::write(&file, &exported.text).unwrap();
        let Ok(done) = std::process::Command::new("python3").arg(&script).arg(&file).output() else {
            let _ = writeln!(std::io::stderr(), "SKIPPED: no python3");
            return None;
        };
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        Some(serde_json::from_slice(&done.stdout).unwrap())
    };
    let scenario = Scenario::load("thor-drop", &[]).unwrap();
    let Some(leg) = read(&sealegs_export::leg(Format::IsaacLab, &scenario, "leg").unwrap()) else { return };
    let knee = &leg["knee"];
    assert_eq!((leg.as_object().unwrap().len(), &knee["class"]), (6, &"ImplicitActuatorCfg".into()));
    // 294.9 kg and 11658 N s/m at the linkage's arm of some 0.056 m.
    let (armature, damping) =
        (knee["armature"].as_f64().unwrap(), knee["viscous_friction"].as_f64().unwrap());
    assert!(
        (damping / armature - 11658.0 / 294.9).abs() < 1e-3 && (armature / 0.925 - 1.0).abs() < 0.1,
        "{knee}"
    );
    let spec = ActuatorSpec::preset("thor-linear").unwrap();
    let base = BenchModel::new(spec, Rig::Pendulum.bench()).unwrap();
    for (id, class) in [("transport-delay", "DelayedPDActuatorCfg"), ("voltage-saturation", "DCMotorCfg")] {
        let with = base.including(id, &everything()).unwrap();
        let hidden = Hidden::drawn(id, 5, strength(id));
        let values: Vec<f64> = (base.parameters().iter().map(|p| p.value))
            .chain(hidden.parameters.iter().map(|p| p.1))
            .collect();
        let bench =
            sealegs_export::bench(Format::IsaacLab, &at(&with, &values), "current_a", "bench").unwrap();
        let groups = read(&bench).unwrap();
        assert_eq!(groups["lever"]["class"], class, "{groups}");
    }
}

#[test]
fn reference_every_preset_loads_in_mujoco_and_stays_finite() {
    let Some(python) = python(folder()) else { return };
    let mut files = Vec::new();
    for format in [Format::Mjcf, Format::Urdf] {
        for name in ActuatorSpec::preset_names() {
            for rig in [Rig::Locked, Rig::Pendulum] {
                let spec = ActuatorSpec::preset(name).unwrap();
                if spec.is_rigid() {
                    continue; // Neither of these benches is for a drive without a spring.
                }
                let model = BenchModel::new(spec, rig.bench()).unwrap();
                let text = sealegs_export::bench(format, &model, "current_a", "bench").unwrap().text;
                files.push((format!("{name}_{}.{format}.xml", rig.as_str()), text));
            }
        }
        for name in sealegs_leg::scenario::preset_names() {
            let scenario = Scenario::load(name, &[]).unwrap();
            let text = sealegs_export::leg(format, &scenario, "leg").unwrap().text;
            files.push((format!("{name}.{format}.xml"), text));
        }
    }
    let legs: Vec<(&str, &str, usize)> =
        files.iter().map(|(name, text)| (name.as_str(), text.as_str(), 1000)).collect();
    let (_, weighed) = run(&python, Vec::new(), &legs);
    assert_eq!(weighed.len(), files.len());
    for ((name, _), seen) in files.iter().zip(&weighed) {
        assert!(seen.warnings == 0 && seen.speed.is_finite() && seen.dofs > 0, "{name}: {seen:?}");
    }
}
