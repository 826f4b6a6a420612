//! Lists of jobs as a user types them: shards put together are the serial run, bit for bit.

mod program;

use program::{json, sealegs};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Runs the program, which ends with a status; returns what it prints.
fn ends(status: i32, threads: usize, arguments: &[&str]) -> String {
    let done = sealegs(threads, arguments);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(status), "{arguments:?}: {error}");
    String::from_utf8(done.stdout).unwrap()
}

fn refused(arguments: &[&str], said: &str) {
    let done = sealegs(1, arguments);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.contains(said), "{arguments:?}: {error}");
}

fn with<'a>(arguments: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [arguments, more].concat()
}

/// Every file below a folder with its bytes, by its name within it.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_owned(), bytes(&path)));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn regress_drops_in_shards_are_the_sweep_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (jobs, json, csv, merged, merged_csv) =
        (at("jobs"), at("serial.json"), at("serial.csv"), at("merged.json"), at("merged.csv"));
    let sweep = ["impact", "thor-impact", "--heights", "0.02,0.05", "--springs", "compliant,locked-out"];
    let sweep = with(&sweep, &["--set", "duration_s=0.2", "--check", "--max-force", "3000"]);
    let said = ends(3, 2, &sweep);
    ends(3, 2, &with(&sweep, &["--json", text(&json), "--csv", text(&csv)]));
    for shard in ["3/3", "1/3"] {
        let out = ends(0, 1, &with(&sweep, &["--jobs", text(&jobs), "--shard", shard]));
        assert!(out.contains("0 before"), "{out}");
    }
    let merge = ["merge", text(&jobs), "--json", text(&merged), "--csv", text(&merged_csv)];
    refused(&merge, "1 of 4 jobs have no whole result: 0002-0.02m-locked-out");
    assert!(!merged.exists() && !merged_csv.exists(), "nothing half written");
    ends(0, 2, &with(&sweep, &["--jobs", text(&jobs), "--shard", "2/3"]));
    ends(3, 1, &merge);
    assert_eq!((bytes(&merged), bytes(&merged_csv)), (bytes(&json), bytes(&csv)));
    assert_eq!(ends(3, 1, &["merge", text(&jobs)]), said);

    // A file that was cut short is made again, the others are not.
    let broken = jobs.join("0003-0.05m-compliant.json");
    let whole = bytes(&broken);
    std::fs::write(&broken, &whole[..whole.len() / 2]).unwrap();
    let out = ends(0, 1, &with(&sweep, &["--jobs", text(&jobs)]));
    assert!(out.contains("1 done now, 3 before"), "{out}");
    assert_eq!(bytes(&broken), whole);

    refused(
        &with(&sweep, &["--jobs", text(&jobs), "--set", "duration_s=0.3"]),
        "differ in 'scenario_sha256'",
    );
    refused(&with(&sweep, &["--jobs", text(&jobs), "--shard", "4/3"]), "'4/3' is no shard");
    refused(&with(&sweep, &["--shard", "1/3"]), "--jobs");
    refused(&with(&sweep, &["--jobs", text(&jobs), "--json", "-"]), "cannot be used with");
    refused(&["merge", text(folder.path())], "jobs.json");
    refused(&["merge", text(&jobs), "-o", text(&at("x"))], "--output: the jobs are those of `impact`");
}

#[test]
fn regress_mysteries_and_their_diagnoses_in_shards_are_the_serial_ones_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (serial, jobs, merged) = (at("serial"), at("jobs"), at("merged"));
    let make = ["mystery", "--seed", "4-5", "--duration", "3"];
    ends(0, 2, &with(&make, &["-o", text(&serial)]));
    for shard in ["2/2", "1/2"] {
        ends(0, 1, &with(&make, &["--jobs", text(&jobs), "--shard", shard]));
    }
    ends(0, 1, &["merge", text(&jobs), "-o", text(&merged)]);
    let made = files(&merged);
    assert_eq!(made.len(), 12, "two campaigns of four runs, their files and their answers");
    assert!(made == files(&serial));

    let (one, two) = (merged.join("mystery-locked-4"), merged.join("mystery-locked-5"));
    let diagnose = ["diagnose", text(&one), text(&two)];
    let (serial, verdicts, together) = (at("serial.json"), at("verdicts"), at("together.json"));
    let said = ends(0, 2, &with(&diagnose, &["--json", text(&serial)]));
    for shard in ["1/2", "2/2"] {
        ends(0, 1, &with(&diagnose, &["--jobs", text(&verdicts), "--shard", shard]));
    }
    assert_eq!(ends(0, 1, &["merge", text(&verdicts), "--json", text(&together)]), said);
    assert_eq!(bytes(&together), bytes(&serial));
    let list = json(&serial);
    assert_eq!(
        (&list[0]["campaign"], &list[1]["campaign"]),
        (&"mystery-locked-4".into(), &"mystery-locked-5".into())
    );
    refused(&with(&diagnose, &["--report", text(&at("r.html"))]), "--report: is one campaign's");
    std::fs::write(two.join("campaign.toml"), "name = \"other\"").unwrap();
    refused(&with(&diagnose, &["--jobs", text(&verdicts)]), "campaign.toml");
}

/// Runs the script of the job array as SLURM does, one task after the other.
fn array(jobs: &Path, tasks: usize) -> Vec<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/jobs/mysteries.slurm.sh");
    let program = Path::new(env!("CARGO_BIN_EXE_sealegs")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let task = |number: usize| {
        let mut bash = Command::new("bash");
        bash.arg(&script).env("PATH", &path).env("JOBS", jobs).env("SEEDS", "1-2").env("DURATION", "3");
        bash.env("SLURM_ARRAY_TASK_ID", number.to_string());
        bash.env("SLURM_ARRAY_TASK_COUNT", tasks.to_string()).output().unwrap()
    };
    (1..=tasks).map(task).collect()
}

#[test]
fn regress_a_job_array_judges_mysteries_as_one_machine_does_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (serial, jobs, merged) = (at("serial.json"), at("jobs"), at("merged.json"));
    let judge = ["mystery", "--seed", "1-2", "--duration", "3", "--judge", "--json", text(&serial)];
    let said = ends(0, 2, &judge);
    assert!(said.lines().last().unwrap().starts_with("2 mysteries: "), "{said}");
    for task in array(&jobs, 2) {
        assert!(task.status.success(), "{}", String::from_utf8_lossy(&task.stderr));
    }
    assert_eq!(ends(0, 1, &["merge", text(&jobs), "--json", text(&merged)]), said);
    assert_eq!(bytes(&merged), bytes(&serial));
    let scores = json(&serial)["scores"].as_object().unwrap().clone();
    assert_eq!(scores.values().map(|n| n.as_u64().unwrap()).sum::<u64>(), 2);
    // Sent once more, it has nothing to do.
    let again = String::from_utf8(array(&jobs, 1).remove(0).stdout).unwrap();
    assert!(again.contains("0 done now, 2 before"), "{again}");
    refused(&["mystery", "--duration", "1", "-o", text(&at("short"))], "at least 3 s");
    refused(&["mystery", "--bench", "leg", "--duration", "5", "-o", text(&at("leg"))], "--duration");
    refused(&["mystery"], "--output");
}
