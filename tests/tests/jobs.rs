//! The recovery matrix in shards is the recovery matrix.

use sealegs::jobs::JobFolder;
use sealegs_reference::campaign::Rig;
use sealegs_tests::matrix::{Case, Outcome, jobs, run};
use std::error::Error;

/// Duration of a run, s: the shortest in which the chirp is still one.
const DURATION_S: f64 = 3.0;

/// An outcome without the time that it took, which is the machine's.
fn timeless(outcome: Outcome) -> String {
    serde_json::to_string(&Outcome { seconds: None, ..outcome }).unwrap()
}

#[test]
fn regress_shards_of_the_matrix_equal_the_serial_run_bit_for_bit() {
    use sealegs::mystery::trial::Strength::{Middle, Weak};
    let folder = tempfile::tempdir().unwrap();
    let cases = [(Vec::new(), Weak, 1), (vec!["hardening-spring"], Middle, 1), (Vec::new(), Weak, 2)]
        .map(|(ids, strength, seed)| Case { ids, rig: Rig::Locked, strength, seed });
    let campaigns = folder.path().join("campaigns");
    let one =
        |number: usize| -> Result<Outcome, Box<dyn Error>> { run(&cases[number], DURATION_S, &campaigns) };
    let serial: Vec<String> = (0..cases.len()).map(|number| timeless(one(number).unwrap())).collect();

    let place = folder.path().join("jobs");
    for shard in ["2/2", "1/2"] {
        let jobs = JobFolder::open(&place, jobs(&cases, DURATION_S).unwrap()).unwrap();
        let worked = jobs.work(shard.parse().unwrap(), &|_| (), one).unwrap();
        assert_eq!((worked.kept, worked.missing), (0, if shard == "2/2" { 2 } else { 0 }));
    }
    let merged: Vec<Outcome> = JobFolder::read(&place).unwrap().results().unwrap();
    assert!(merged.iter().all(|o| o.seconds.is_some_and(|s| s > 0.0)), "{merged:?}");
    assert_eq!(merged.into_iter().map(timeless).collect::<Vec<_>>(), serial);
}
