//! The folder of a list of jobs: `jobs.json` and one file for each result.

use super::Shard;
use crate::{Error, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// The list's file.
const LIST: &str = "jobs.json";

/// What a result's file says between the list's hash and the result's, and what follows it.
const BEFORE_HASH: &str = "\",\"sha256\":\"";
const BEFORE_RESULT: &str = "\",\"result\":";
const END: &str = "}\n";

/// Letters of a SHA-256 in hexadecimal.
const HASH: usize = 64;

/// Characters of a job's name that its file keeps.
const NAME: usize = 80;

/// What is to be done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobList {
    /// Which verb's jobs they are.
    pub verb: String,
    /// The program and its version: results of different versions are not put together.
    pub program: String,
    /// Everything that the results follow from, and that putting them together needs.
    pub about: Value,
    /// The jobs' names in their order; each is its file's name as well, without `.json`.
    pub jobs: Vec<String>,
}

impl JobList {
    /// A list; each name gets its number before it, and keeps only what a file's name may have everywhere.
    #[must_use]
    pub fn new<S: AsRef<str>>(verb: &str, program: &str, about: Value, names: &[S]) -> Self {
        let safe = |c: char| if is_safe(c) { c } else { '_' };
        let name = |(number, name): (usize, &S)| {
            let name: String = name.as_ref().chars().map(safe).take(NAME).collect();
            format!("{:04}-{name}", number + 1)
        };
        let jobs = names.iter().enumerate().map(name).collect();
        Self { verb: verb.to_owned(), program: program.to_owned(), about, jobs }
    }

    /// The list as its file has it.
    fn text(&self) -> Result<String> {
        Ok(crate::json(self)? + "\n")
    }
}

/// Whether a job's name may have this character: a file's name may have it everywhere.
fn is_safe(c: char) -> bool {
    c.is_ascii_alphanumeric() || "-_.+".contains(c)
}

/// SHA-256 of a text, in hexadecimal.
#[must_use]
pub fn hash(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// How far a shard has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Worked {
    /// Jobs of the shard.
    pub jobs: usize,
    /// Of these, those whose whole result was there already.
    pub kept: usize,
    /// Jobs of the whole list that have no whole result yet.
    pub missing: usize,
}

/// A folder with a list of jobs and the results so far.
#[derive(Debug, Clone)]
pub struct JobFolder {
    path: PathBuf,
    list: JobList,
    /// Hash of the list: a result belongs to one list.
    id: String,
}

impl JobFolder {
    /// Opens the folder for this list; makes it, and writes the list, where they are not there or the list's file is no
    /// list at all.
    ///
    /// # Errors
    ///
    /// [`Error::OtherJobs`] if it holds another list, [`Error::Io`] if it cannot be made or read.
    pub fn open(path: &Path, list: JobList) -> Result<Self> {
        let file = path.join(LIST);
        let text = list.text()?;
        std::fs::create_dir_all(path).map_err(|e| Error::io(path, e))?;
        match there(&file)?.and_then(|text| serde_json::from_str::<JobList>(&text).ok()) {
            Some(there) if there == list => {}
            Some(there) => return Err(Error::OtherJobs { file, what: difference(&there, &list) }),
            None => write(&file, &text)?,
        }
        Ok(Self { path: path.to_owned(), id: hash(&text), list })
    }

    /// Opens a folder whose list was written before.
    ///
    /// # Errors
    ///
    /// [`Error::NoJobs`] if there is no list in it, [`Error::Io`] if it cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        let file = path.join(LIST);
        let no = |problem: String| Error::NoJobs { file: file.clone(), problem };
        let Some(text) = there(&file)? else { return Err(no("is not there".to_owned())) };
        let list: JobList =
            serde_json::from_str(&text).map_err(|e| no(format!("is no list of jobs: {e}")))?;
        if let Some(bad) = list.jobs.iter().find(|name| !name.chars().all(is_safe)) {
            return Err(no(format!("key 'jobs': '{bad}' is no name of a job")));
        }
        let id = hash(&list.text()?);
        Ok(Self { path: path.to_owned(), list, id })
    }

    /// What is to be done.
    #[must_use]
    pub fn list(&self) -> &JobList {
        &self.list
    }

    /// What the list is about, in the type that wrote it.
    ///
    /// # Errors
    ///
    /// [`Error::NoJobs`] if it is of another type.
    pub fn about<T: DeserializeOwned>(&self) -> Result<T> {
        T::deserialize(&self.list.about)
            .map_err(|e| Error::NoJobs { file: self.path.join(LIST), problem: format!("key 'about': {e}") })
    }

    /// The file of a job's result.
    #[must_use]
    pub fn file(&self, job: usize) -> PathBuf {
        self.path.join(format!("{}.json", self.list.jobs[job]))
    }

    /// How a result's file begins.
    fn head(&self, job: usize) -> String {
        format!("{{\"job\":\"{}\",\"list\":\"{}{BEFORE_HASH}", self.list.jobs[job], self.id)
    }

    /// The text of a job's result, if its file is there, whole, and of this list.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if a file is there and cannot be read.
    pub fn kept(&self, job: usize) -> Result<Option<String>> {
        let Some(text) = there(&self.file(job))? else { return Ok(None) };
        let whole = || {
            let rest = text.strip_prefix(&self.head(job))?;
            let (sha256, rest) = rest.split_at_checked(HASH)?;
            let result = rest.strip_prefix(BEFORE_RESULT)?.strip_suffix(END)?;
            (hash(result) == sha256).then(|| result.to_owned())
        };
        Ok(whole())
    }

    /// Keeps a job's result, in a file that is whole or not there.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the disk does not take it, [`Error::Unwritable`] if it cannot be put into JSON.
    pub fn keep(&self, job: usize, result: &impl Serialize) -> Result<()> {
        let result = crate::json(result)?;
        let text = format!("{}{}{BEFORE_RESULT}{result}{END}", self.head(job), hash(&result));
        write(&self.file(job), &text)
    }

    /// Does the jobs of a shard that have no whole result, one after the other, and keeps what comes of each. `tell` is
    /// called with the job's name before it begins.
    ///
    /// # Errors
    ///
    /// That of the first job that fails, with the results so far kept; those of [`JobFolder::keep`].
    pub fn work<T: Serialize, E: From<Error>>(
        &self,
        shard: Shard,
        tell: &dyn Fn(&str),
        job: impl Fn(usize) -> std::result::Result<T, E>,
    ) -> std::result::Result<Worked, E> {
        let mut worked = Worked { jobs: 0, kept: 0, missing: 0 };
        for (number, name) in self.list.jobs.iter().enumerate().filter(|(n, _)| shard.takes(*n)) {
            worked.jobs += 1;
            if self.kept(number)?.is_some() {
                worked.kept += 1;
                continue;
            }
            tell(name);
            self.keep(number, &job(number)?)?;
        }
        worked.missing = self.missing()?.len();
        Ok(worked)
    }

    /// The jobs without a whole result.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if a file is there and cannot be read.
    pub fn missing(&self) -> Result<Vec<&str>> {
        let mut missing = Vec::new();
        for (number, name) in self.list.jobs.iter().enumerate() {
            if self.kept(number)?.is_none() {
                missing.push(name.as_str());
            }
        }
        Ok(missing)
    }

    /// The results as texts in JSON, in the list's order.
    ///
    /// # Errors
    ///
    /// [`Error::JobsMissing`] if not every job has a whole one.
    pub fn texts(&self) -> Result<Vec<String>> {
        let texts: Vec<Option<String>> =
            (0..self.list.jobs.len()).map(|job| self.kept(job)).collect::<Result<_>>()?;
        texts.into_iter().collect::<Option<_>>().ok_or_else(|| {
            let missing = self.missing().unwrap_or_default();
            Error::JobsMissing {
                folder: self.path.clone(),
                of: self.list.jobs.len(),
                missing: missing.iter().map(|name| (*name).to_owned()).collect(),
            }
        })
    }

    /// The results, in the list's order.
    ///
    /// # Errors
    ///
    /// As [`JobFolder::texts`], and [`Error::NoJobs`] if one is of another type.
    pub fn results<T: DeserializeOwned>(&self) -> Result<Vec<T>> {
        let texts = self.texts()?;
        let read = |(job, text): (usize, &String)| {
            serde_json::from_str(text).map_err(|e| Error::NoJobs {
                file: self.file(job),
                problem: format!("is no result of '{}': {e}", self.list.verb),
            })
        };
        texts.iter().enumerate().map(read).collect()
    }
}

/// A file's text, if it is there; text that is not UTF-8 is no text of ours, and counts as broken.
fn there(file: &Path) -> Result<Option<String>> {
    match std::fs::read(file) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(Error::io(file, e)),
    }
}

/// Writes a file beside its place and renames it. Two processes that do the same job write two files, and the last name
/// stands: both are the same.
fn write(file: &Path, text: &str) -> Result<()> {
    let mut part = file.as_os_str().to_owned();
    part.push(format!(".{}.part", std::process::id()));
    let part = PathBuf::from(part);
    let done = std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, file));
    done.map_err(|e| {
        // What is left of it is of no use to anybody.
        let _ = std::fs::remove_file(&part);
        Error::io(file, e)
    })
}

/// In what two lists differ, for a message.
fn difference(there: &JobList, asked: &JobList) -> String {
    if there.verb != asked.verb {
        return format!("it holds jobs of `{}`, not of `{}`", there.verb, asked.verb);
    }
    if there.program != asked.program {
        return format!("its jobs are of sealegs {}, this is {}", there.program, asked.program);
    }
    let (Value::Object(there), Value::Object(asked)) = (&there.about, &asked.about) else {
        return "its jobs are others".to_owned();
    };
    let mut keys = there.keys().chain(asked.keys()).filter(|key| there.get(*key) != asked.get(*key));
    keys.next().map_or_else(|| "its jobs are others".to_owned(), |key| format!("its jobs differ in '{key}'"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::cell::RefCell;

    fn list() -> JobList {
        JobList::new("thirds", "0", json!({ "of": 4 }), &["a", "b/c", "d", "e"])
    }

    /// A number whose digits do not end.
    fn third(job: usize) -> Result<f64> {
        Ok(job as f64 / 3.0)
    }

    #[test]
    fn shards_make_together_what_one_makes_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (alone, together) = (folder.path().join("alone"), folder.path().join("together"));
        let one = JobFolder::open(&alone, list()).unwrap();
        assert_eq!(one.work(Shard::WHOLE, &|_| (), third).unwrap(), Worked { jobs: 4, kept: 0, missing: 0 });
        let two = JobFolder::open(&together, list()).unwrap();
        for (shard, missing) in [("2/3", 3), ("3/3", 2), ("1/3", 0)] {
            let worked = two.work(shard.parse().unwrap(), &|_| (), third).unwrap();
            assert_eq!(worked.missing, missing, "{shard}");
            if missing > 0 {
                let error = two.texts().unwrap_err().to_string();
                assert!(error.contains(&format!("{missing} of 4")) && error.contains("0001-a"), "{error}");
            }
        }
        assert_eq!(two.list().jobs, ["0001-a", "0002-b_c", "0003-d", "0004-e"]);
        let read = JobFolder::read(&together).unwrap();
        assert_eq!(read.texts().unwrap(), one.texts().unwrap());
        let numbers: Vec<f64> = read.results().unwrap();
        assert!(numbers.iter().enumerate().all(|(job, n)| n.to_bits() == third(job).unwrap().to_bits()));
        for job in 0..4 {
            assert_eq!(std::fs::read(one.file(job)).unwrap(), std::fs::read(two.file(job)).unwrap());
            let text = std::fs::read_to_string(one.file(job)).unwrap();
            assert!(serde_json::from_str::<Value>(&text).unwrap()["result"].is_number(), "{text}");
        }
        assert_eq!(std::fs::read_dir(&together).unwrap().count(), 5, "nothing unfinished");
    }

    #[test]
    fn a_whole_result_is_not_computed_again_and_a_broken_one_is() {
        let folder = tempfile::tempdir().unwrap();
        let jobs = JobFolder::open(folder.path(), list()).unwrap();
        jobs.work(Shard::WHOLE, &|_| (), third).unwrap();
        let whole: Vec<String> = (0..4).map(|job| std::fs::read_to_string(jobs.file(job)).unwrap()).collect();
        type Break<'a> = &'a dyn Fn(&str) -> Option<String>;
        let breaks: [Break; 5] = [
            &|_| None,
            &|text| Some(text[..text.len() - 1].to_owned()),
            &|text| Some(text.replace("0.333", "0.334")),
            &|_| Some(String::new()),
            &|_| Some(whole[2].clone()),
        ];
        for (number, broken) in breaks.iter().enumerate() {
            match broken(&whole[1]) {
                None => std::fs::remove_file(jobs.file(1)).unwrap(),
                Some(text) => {
                    assert_ne!(text, whole[1], "{number}");
                    std::fs::write(jobs.file(1), text).unwrap();
                }
            }
            assert_eq!(jobs.missing().unwrap(), ["0002-b_c"], "{number}");
            let told = RefCell::new(Vec::new());
            let worked = jobs.work(Shard::WHOLE, &|name| told.borrow_mut().push(name.to_owned()), third);
            assert_eq!(worked.unwrap(), Worked { jobs: 4, kept: 3, missing: 0 }, "{number}");
            assert_eq!(*told.borrow(), ["0002-b_c"], "{number}");
            assert_eq!(std::fs::read_to_string(jobs.file(1)).unwrap(), whole[1], "{number}");
        }
    }

    #[test]
    fn a_job_that_fails_leaves_what_was_done_and_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let jobs = JobFolder::open(folder.path(), list()).unwrap();
        let fails = |job: usize| if job == 2 { Err(Error::NoEffect) } else { third(job) };
        assert!(matches!(jobs.work(Shard::WHOLE, &|_| (), fails), Err(Error::NoEffect)));
        assert_eq!(jobs.missing().unwrap(), ["0003-d", "0004-e"]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[test]
    fn a_folder_of_other_jobs_is_refused_and_a_broken_list_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(LIST);
        assert!(JobFolder::read(folder.path()).unwrap_err().to_string().contains("is not there"));
        let jobs = JobFolder::open(folder.path(), list()).unwrap();
        jobs.work(Shard::WHOLE, &|_| (), third).unwrap();
        for (other, said) in [
            (JobList { verb: "halves".to_owned(), ..list() }, "jobs of `thirds`, not of `halves`"),
            (JobList { program: "1".to_owned(), ..list() }, "of sealegs 0, this is 1"),
            (JobList { about: json!({ "of": 5 }), ..list() }, "differ in 'of'"),
            (JobList::new("thirds", "0", json!({ "of": 4 }), &["a"]), "others"),
        ] {
            let error = JobFolder::open(folder.path(), other).unwrap_err();
            assert!(error.is_bad_input() && error.to_string().contains(said), "{error}");
        }
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, &text[..text.len() / 2]).unwrap();
        assert!(JobFolder::read(folder.path()).unwrap_err().to_string().contains("no list of jobs"));
        let again = JobFolder::open(folder.path(), list()).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        assert!(again.missing().unwrap().is_empty(), "the results are of this list");
    }
}
