//! The recovery matrix: campaigns with a known answer through the whole diagnosis, scored.
//!
//! Every effect of the catalogue on both benches at three strengths with several individuals, two and three effects at once,
//! campaigns with nothing hidden, and with effects of no catalogue, all by the independent simulator
//! (`sealegs-reference`) at a fine step. The runs are shorter than a real campaign's, to keep it affordable.

mod stamp;
mod table;

pub use stamp::stamp;
pub use table::{error, table};

use sealegs::Options;
use sealegs::jobs::JobList;
use sealegs::mystery::answer::{Answer, HiddenEffect};
use sealegs::mystery::score::Score;
use sealegs::mystery::trial::{Strength, visible};
use sealegs::mystery::{Fitted, Located, Verdict, answer_of};
use sealegs_reference::campaign::{BEYOND, CATALOGUE, Draws, Hidden, Order, PAIRS, Rig, SUBSTEPS, TRIPLES};
use sealegs_sysid::Campaign;
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

/// Duration of a run of the whole matrix, s.
pub const DURATION_S: f64 = 8.0;

/// Effects narrowed down to one sensor, beside the catalogue's own ids.
const NARROWED: [&str; 3] =
    ["sensor-lag@force_1_n", "sensor-delay@motor_angle_rad", "sensor-delay@force_2_n"];

/// Campaigns with nothing hidden, per bench and seed: false alarms are to be counted in per cent.
const CLEAN_PER_SEED: u64 = 5;

/// What is asked for.
#[derive(Debug, Clone)]
pub struct Asked {
    /// How many strengths, the weakest last to go: 1 is the middle one alone, 2 adds the dominant one.
    pub strengths: usize,
    /// Individuals per effect, bench and strength.
    pub seeds: u64,
    /// The first of them; the search has never seen those of a matrix that is to count.
    pub first_seed: u64,
    /// This effect only (`nothing` for the campaigns without one).
    pub only: Option<String>,
    /// This bench only.
    pub rig: Option<Rig>,
}

/// One campaign of the matrix.
#[derive(Debug, Clone)]
pub struct Case {
    /// What is hidden; empty for nothing.
    pub ids: Vec<&'static str>,
    /// Where.
    pub rig: Rig,
    /// How strong each of it is.
    pub strength: Strength,
    /// Which individual, from 1 on.
    pub seed: u64,
}

/// Name of the row of campaigns with nothing hidden.
pub const NOTHING: &str = "nothing";

impl Case {
    /// The row of the table.
    #[must_use]
    pub fn row(&self) -> String {
        if self.ids.is_empty() { NOTHING.to_owned() } else { self.ids.join(" + ") }
    }

    /// A name that no other case has, and a folder may have.
    #[must_use]
    pub fn name(&self) -> String {
        let row = self.row().replace(" + ", "+");
        format!("{row}-{}-{}-{}", self.rig.as_str(), self.strength.as_str(), self.seed)
    }
}

/// Every case that is asked for, in the order of the table.
#[must_use]
pub fn cases(asked: &Asked) -> Vec<Case> {
    use Strength::{Dominant, Middle, Weak};
    let strengths = &[Middle, Dominant, Weak][..asked.strengths.clamp(1, 3)];
    let mut rows: Vec<(Vec<&'static str>, Vec<Strength>, u64)> = Vec::new();
    for id in CATALOGUE.iter().chain(&NARROWED) {
        rows.push((vec![*id], strengths.to_vec(), asked.seeds));
    }
    let several = PAIRS.iter().map(|pair| pair.to_vec()).chain(TRIPLES.iter().map(|three| three.to_vec()));
    rows.extend(several.map(|ids| (ids, vec![Middle], asked.seeds)));
    rows.push((Vec::new(), vec![Weak], asked.seeds * CLEAN_PER_SEED));
    let strong: Vec<Strength> = strengths.iter().copied().filter(|s| *s != Weak).collect();
    rows.extend(BEYOND.iter().map(|id| (vec![*id], strong.clone(), asked.seeds)));
    let mut all = Vec::new();
    for (ids, strengths, seeds) in rows {
        for rig in [Rig::Locked, Rig::Pendulum] {
            if asked.rig.is_some_and(|r| r != rig) || !ids.iter().all(|id| Hidden::applies(id, rig)) {
                continue;
            }
            for strength in &strengths {
                for seed in asked.first_seed..asked.first_seed + seeds {
                    all.push(Case { ids: ids.clone(), rig, strength: *strength, seed });
                }
            }
        }
    }
    all.retain(|case| asked.only.as_ref().is_none_or(|only| case.row() == *only));
    all
}

/// The cases as a list of jobs, with runs of a duration; their results are [`Outcome`]s.
///
/// # Errors
///
/// If a source of the search cannot be read.
pub fn jobs(cases: &[Case], duration_s: f64) -> std::io::Result<JobList> {
    let names: Vec<String> = cases.iter().map(Case::name).collect();
    let about = serde_json::json!({ "duration_s": duration_s, "cases": names });
    Ok(JobList::new("recovery-matrix", &stamp()?, about, &names))
}

/// What came out, as a line of the results file keeps it. Lines that were read back from a page know no more than it
/// says: the score, and the errors of what was not right.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outcome {
    /// [`stamp`] of the search that made it.
    #[serde(default)]
    pub search: String,
    /// [`Case::name`].
    pub name: String,
    /// The row of the table.
    pub row: String,
    /// The bench.
    pub bench: String,
    /// The strength.
    pub strength: String,
    /// The score in words; `invisible` where no strength lets it show on this bench.
    pub score: String,
    /// The verdict in the data contract's words.
    pub verdict: String,
    /// What was named.
    pub said: Vec<String>,
    /// What could not be told from it.
    pub tied: Vec<Vec<String>>,
    /// Error of the base model on the holdout runs, noise units.
    pub base_error: Option<f64>,
    /// The same with what was named.
    pub after_error: Option<f64>,
    /// Greatest relative error of a parameter of the effect, where exactly the hidden ones were named.
    pub worst_parameter: Option<f64>,
    /// What was stated of the base model's and the effects' parameters beside the truth, where exactly the hidden ones
    /// were named. Lines made before this was kept have none.
    #[serde(default)]
    pub stated: Vec<Stated>,
    /// Whether port and dependence of what is in no catalogue were said; none where nothing of the kind is hidden, and in
    /// lines made before this was kept.
    #[serde(default)]
    pub located: Option<Located>,
    /// Share of the energy above the floor that a curve beyond the catalogue takes on the holdout runs, where one was found.
    #[serde(default)]
    pub explained: Option<f64>,
    /// Integration steps of the diagnosis; none in lines made before they were counted.
    #[serde(default)]
    pub steps: Option<u64>,
    /// Time of the diagnosis, s.
    pub seconds: Option<f64>,
}

impl Outcome {
    /// The greatest of some error over the stated parameters of the effects; none where none is stated.
    #[must_use]
    pub fn worst(&self, error: impl Fn(&Stated) -> Option<f64>) -> Option<f64> {
        self.stated.iter().filter(|s| s.of_effect()).filter_map(error).max_by(f64::total_cmp)
    }
}

/// A fitted parameter beside its true value.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Stated {
    /// Its name, with the effect's before it if it is one's.
    pub name: String,
    /// The true value.
    pub truth: f64,
    /// The fitted value.
    pub value: f64,
    /// The stated standard error.
    pub std: f64,
    /// The values under the other choices of the base model that were said to explain the runs as well.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<f64>,
}

impl Stated {
    /// Whether it is an effect's.
    #[must_use]
    pub fn of_effect(&self) -> bool {
        self.name.contains('.')
    }

    /// The fitted value's error over the true value; a phase has no ratio.
    #[must_use]
    pub fn relative_error(&self) -> Option<f64> {
        (!self.name.ends_with("phase_rad")).then(|| self.error_of(self.value))
    }

    /// The same of whichever of the values that were said is nearest.
    #[must_use]
    pub fn nearest_error(&self) -> Option<f64> {
        let others = self.others.iter().map(|value| self.error_of(*value));
        self.relative_error().map(|own| others.fold(own, f64::min))
    }

    fn error_of(&self, value: f64) -> f64 {
        (value / self.truth - 1.0).abs()
    }

    /// Whether the stated interval of 95 % holds the truth.
    #[must_use]
    pub fn holds(&self) -> bool {
        (self.value - self.truth).abs() <= 1.96 * self.std
    }
}

/// The score of a case that cannot be made.
pub const INVISIBLE: &str = "invisible";

/// Makes a case's campaign of runs of a duration, as files in `folder/NAME`, diagnoses it and scores the verdict. The folder stays where
/// the verdict is neither right nor tied.
///
/// # Errors
///
/// If a file cannot be written or read, or nothing can be simulated.
pub fn run(case: &Case, duration_s: f64, folder: &Path) -> Result<Outcome, Box<dyn Error>> {
    let name = case.name();
    let plain = Order {
        name: name.clone(),
        rig: case.rig,
        seed: Draws::of(case.seed, &name).seed(),
        hidden: Vec::new(),
        duration_s,
        substeps: SUBSTEPS,
        rough: Vec::new(),
    };
    let mut outcome = Outcome {
        search: stamp()?,
        name: name.clone(),
        row: case.row(),
        bench: case.rig.as_str().to_owned(),
        strength: case.strength.as_str().to_owned(),
        score: INVISIBLE.to_owned(),
        verdict: String::new(),
        said: Vec::new(),
        tied: Vec::new(),
        base_error: None,
        after_error: None,
        worst_parameter: None,
        stated: Vec::new(),
        located: None,
        explained: None,
        steps: None,
        seconds: None,
    };
    let mut hidden = Vec::new();
    for id in &case.ids {
        match visible(&plain, id, case.strength)? {
            Some(effect) => hidden.push(effect),
            None => return Ok(outcome),
        }
    }
    let made = Order { hidden, ..plain }.make();
    let place = folder.join(&name);
    std::fs::create_dir_all(&place)?;
    for (file, text) in made.files() {
        std::fs::write(place.join(file), text)?;
    }
    let started = Instant::now();
    let diagnosis = sealegs::diagnose(&Campaign::read(&place)?, Options::new().force(true))?;
    outcome.seconds = Some(started.elapsed().as_secs_f64());
    outcome.steps = Some(diagnosis.outcome().work.steps);
    let said = Verdict::of(&diagnosis)?;
    let answer = answer_of(&made, case.seed, said.base.holdout_error);
    let after = said.after.as_ref().unwrap_or(&said.base);
    let scored = said.score(&answer);
    outcome.located = said.located(&answer);
    outcome.explained = diagnosis.outcome().law.as_ref().map(|law| law.explained);
    outcome.score = scored.to_string();
    outcome.verdict.clone_from(&said.verdict);
    outcome.said.clone_from(&said.effects);
    outcome.tied.clone_from(&said.indistinguishable);
    outcome.base_error = Some(said.base.holdout_error);
    outcome.after_error = Some(after.holdout_error);
    if scored == Score::Right {
        outcome.stated = stated(&answer, &after.parameters, |name| {
            let choices = diagnosis.outcome().equally_good_choices.iter();
            choices.filter_map(|other| other.parameters.get(name).copied()).collect()
        });
        outcome.worst_parameter = outcome.worst(Stated::relative_error);
    }
    if matches!(scored, Score::Right | Score::Tied) && outcome.located.is_none_or(Located::right) {
        std::fs::remove_dir_all(&place)?;
    }
    Ok(outcome)
}

/// What is stated of what is known of a campaign. A choice of rounding is no quantity, and what the bench or the model file
/// fixes, or is withheld, has no interval. `others` gives a parameter's values under the choices that explain the runs as well.
fn stated(answer: &Answer, fitted: &[Fitted], others: impl Fn(&str) -> Vec<f64>) -> Vec<Stated> {
    let base = answer.parameters.iter().map(|p| (p.name.clone(), p.value));
    let own = |e: &HiddenEffect| {
        e.parameters.iter().map(|p| (format!("{}.{}", e.id, p.name), p.value)).collect::<Vec<_>>()
    };
    let effects = answer.effects.iter().flat_map(own).filter(|(name, _)| !name.ends_with("rounding"));
    base.chain(effects)
        .filter_map(|(name, truth)| {
            let p = fitted.iter().find(|p| p.name == name)?;
            let std = p.std.filter(|std| *std > 0.0)?;
            let others = others(&name);
            Some(Stated { name, truth, value: p.value, std, others })
        })
        .collect()
}
