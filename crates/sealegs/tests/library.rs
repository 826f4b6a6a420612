//! What a caller of the library relies on: columns in memory are as good as files, errors can be matched on, work stops.

use sealegs::{
    Campaign, Error, ModelSource, Options, Role, RunColumns, Scenario, Stop, add, compare, diagnose,
};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/campaigns").join(name)
}

fn bench() -> Campaign {
    Campaign::read(&shipped("bench-knee")).unwrap()
}

/// The same campaign, of columns.
fn in_memory(read: &Campaign) -> Campaign {
    let builder = Campaign::builder(&read.name, read.bench, &read.actuator).sample_rate_hz(500.0);
    let builder = read.noise.iter().fold(builder, |b, n| b.noise_std(&n.channel, n.std));
    let runs = read.runs.iter().map(|run| {
        let signals = run.record.inputs.iter().chain(&run.record.outputs);
        let columns = signals.map(|s| (s.channel.clone(), s.values.clone()));
        let time = ("time_s".to_owned(), run.record.time_s.clone());
        RunColumns::new(&run.record.name, run.role, std::iter::once(time).chain(columns))
    });
    runs.fold(builder, sealegs::CampaignBuilder::run).build().unwrap()
}

#[test]
fn columns_in_memory_are_compared_as_files_are() {
    let read = bench();
    let of_files = compare(&read, Options::new()).unwrap();
    let of_columns = compare(&in_memory(&read), Options::new()).unwrap();
    let numbers = |comparison: &sealegs::Comparison| {
        let mut json: serde_json::Value = serde_json::from_str(&comparison.to_json().unwrap()).unwrap();
        json.as_object_mut().unwrap().remove("provenance").unwrap();
        json
    };
    assert_eq!(numbers(&of_files), numbers(&of_columns));
    let inputs = &of_columns.summary().provenance.inputs;
    assert_eq!(inputs.len(), read.runs.len());
    assert!(inputs.iter().all(|i| i.file.starts_with("(memory)") && i.sha256.len() == 64), "{inputs:?}");
    assert!(of_columns.to_html().unwrap().contains("sealegs::compare"));
    assert!(of_columns.recording().unwrap().runs.len() == read.runs.len());
}

#[test]
fn a_recording_of_an_addition_opens_where_the_model_was_worst_without_it() {
    let recording = add(&["spring-hysteresis"], &bench(), Options::new()).unwrap().recording().unwrap();
    let first = &recording.runs[0];
    assert!(first.name.contains("check-noise.csv (holdout)"), "{}", first.name);
    assert_eq!(first.channels[0].name, "motor_angle_rad");
}

#[test]
fn what_goes_wrong_can_be_matched_on() {
    let campaign = bench();
    match add(&["coulomb-frictoin"], &campaign, Options::new()).unwrap_err() {
        Error::UnknownEffect { known, .. } => {
            assert!(known.contains(&"coulomb-friction".to_owned()), "{known:?}")
        }
        other => panic!("{other}"),
    }
    let named = |effects: &[&str]| add(effects, &campaign, Options::new()).unwrap_err();
    assert!(matches!(named(&[]), Error::NoEffect), "{}", named(&[]));
    assert!(matches!(named(&["a", "a"]), Error::BadEffect { .. }));
    assert!(matches!(named(&["own.toml"]), Error::BadEffect { .. }));
    let leg = Scenario::load("thor-drop", &[]).unwrap();
    let wrong = compare(&campaign, leg).unwrap_err();
    assert!(
        matches!(&wrong, Error::WrongModel { needed: "an actuator", .. }) && wrong.is_bad_input(),
        "{wrong}"
    );
    let absent = compare(&campaign, ModelSource::from("no-such-actuator")).unwrap_err();
    assert!(matches!(absent, Error::Actuator(_)), "{absent}");
    let mut fit_only = campaign.clone();
    fit_only.runs.retain(|run| run.role == Role::Fit);
    let no_holdout = diagnose(&fit_only, Options::new()).unwrap_err();
    assert!(matches!(&no_holdout, Error::Campaign(sealegs::sysid::Error::NoRun { role: "holdout", .. })));
    assert!(no_holdout.is_bad_input());
}

#[test]
fn work_ends_when_it_is_told_to() {
    let campaign = Campaign::read(&shipped("leg-drop")).unwrap();
    let stop = Stop::new();
    let options = Options::new().stop(&stop);
    let handle = stop.clone();
    // A leg's diagnosis takes tens of seconds; it is stopped as soon as its search has begun.
    let stopper = std::thread::spawn(move || {
        while handle.simulations() < 20 {
            std::thread::sleep(Duration::from_millis(5));
        }
        handle.stop();
        Instant::now()
    });
    let done = diagnose(&campaign, options);
    let ended = Instant::now();
    let told = stopper.join().unwrap();
    assert!(matches!(done, Err(Error::Stopped)), "{done:?}");
    let late = ended.duration_since(told);
    assert!(late < Duration::from_secs(10), "{late:?} after it was told");
    assert!(!Error::Stopped.is_bad_input());
}

#[test]
fn a_search_that_is_ended_is_judged_by_what_it_found() {
    let told = |end: Option<&'static str>| {
        let stop = Stop::new();
        let handle = stop.clone();
        let ends = move |what: &str| {
            if end.is_some_and(|end| what.starts_with(end)) {
                handle.end_search();
            }
        };
        diagnose(&bench(), Options::new().stop(&stop).on_progress(ends)).unwrap()
    };
    let whole = told(None);
    assert!(!whole.outcome().work.ended_early && !whole.sentence().contains("ended"));
    // Once a set is the best so far, that one is judged, with its values at the end of their fit.
    let found = told(Some(sealegs::diagnosis::progress::SO_FAR));
    let o = found.outcome();
    assert!(o.work.ended_early && o.work.simulations < whole.outcome().work.simulations);
    assert_eq!(o.effects, whole.outcome().effects);
    assert!(found.sentence().contains("The search was ended before it was done"), "{}", found.sentence());
    assert!(o.confidence.reasons[0].contains("ended before it was done"));
    assert_ne!(o.confidence.level, sealegs::diagnosis::confidence::Level::Sure);
    let (cut, all) = (o.after.as_ref().unwrap(), whole.outcome().after.as_ref().unwrap());
    assert!((cut.holdout_error / all.holdout_error - 1.0).abs() < 0.01);
    // Before any is, the base model alone is.
    let base = told(Some("refitting"));
    let o = base.outcome();
    assert!(o.work.ended_early && o.effects.is_empty() && o.after.is_none(), "{}", base.sentence());
}
