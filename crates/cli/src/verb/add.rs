//! `sealegs add`: puts an effect into a model, refits, and writes the better model.

use crate::failure::bad_input;
use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::diagnosis::named;
use sealegs::sysid::units;
use sealegs::{Addition, Campaign, Options};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Add an effect to a model, refit it on a campaign and write the better model
#[derive(Args)]
pub struct Add {
    /// The effect's id, or the file of your own effect; several, or `a+b`, are fitted together
    #[arg(required_unless_present = "law")]
    effect: Vec<String>,
    /// The file of a law that `diagnose --law` wrote, as if it were named among the effects
    #[arg(long, value_name = "LAW.toml")]
    law: Vec<PathBuf>,
    /// The model: an actuator file, for a leg a scenario file, or a preset; without it the campaign's own
    #[arg(long = "to", value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// The campaign's folder, or its campaign.toml
    #[arg(long)]
    campaign: PathBuf,
    /// Where to write the better model; of a campaign of several units BETTER-UNIT.toml for each
    #[arg(short = 'o', long = "output", value_name = "BETTER.toml")]
    output: PathBuf,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write measured, before, after and residuals as a recording
    #[arg(long, value_name = "FILE.rrd")]
    rrd: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a file with an error in it or an unknown effect; otherwise if an output file cannot be
/// written or nothing can be simulated.
pub fn run(arguments: &Add) -> anyhow::Result<u8> {
    let started = Instant::now();
    let laws = arguments.law.iter().map(|path| path.display().to_string());
    let asked: Vec<String> = arguments.effect.iter().cloned().chain(laws).collect();
    let (effects, _) = named(&asked)?;
    let campaign = kind::campaign(&arguments.campaign)?;
    let better = Better::new(&arguments.output, &campaign)?;
    let json = Destination::optional(arguments.json.as_ref())?;
    let report = Destination::optional(arguments.report.as_ref())?;
    let rrd = Destination::optional(arguments.rrd.as_ref())?;

    let bar = progress::spinner();
    let to = arguments.model.as_ref().map_or(String::new(), |model| format!(" --to {}", model.display()));
    let command =
        format!("sealegs add {}{to} --campaign {}", effects.join(" "), arguments.campaign.display());
    let mut options = Options::new().command(command).on_progress(progress::on(&bar));
    if let Some(model) = &arguments.model {
        options = options.model(model.as_path());
    }
    let addition = sealegs::add(&asked, &campaign, options);
    bar.finish();
    let addition = addition?;

    if let Some(destination) = report {
        destination.write(addition.to_html()?.as_bytes())?;
    }
    if let Some(destination) = rrd {
        destination.record(&addition.recording()?)?;
    }
    let written = better.write(&addition)?;
    if let Some(destination) = json {
        destination.write((addition.to_json()? + "\n").as_bytes())?;
    }
    let to_stdout = |path: &Path| path == Path::new("-");
    let taken = [Some(&arguments.output), arguments.json.as_ref(), arguments.report.as_ref()];
    if !taken.into_iter().flatten().any(|p| to_stdout(p)) {
        let (simulations, simulated_s) = addition.added().work;
        write!(
            std::io::stdout().lock(),
            "{}\nwritten to {written}\n{simulations} simulations, {simulated_s:.0} s of experiment in {:.1} s\n",
            addition.to_text(),
            started.elapsed().as_secs_f64()
        )?;
    }
    Ok(0)
}

/// Where the better model goes: a file, or one for each unit of the campaign.
pub(super) struct Better {
    files: Vec<(PathBuf, Destination)>,
    units: Vec<String>,
}

impl Better {
    /// The files for a path that was asked for.
    ///
    /// # Errors
    ///
    /// Bad input where they cannot be written.
    pub(super) fn new(asked: &Path, campaign: &Campaign) -> anyhow::Result<Self> {
        let units = units::of_campaign(campaign);
        let file = |path: PathBuf| Ok((path.clone(), Destination::new(&path)?));
        let files = outputs(asked, &units)?.into_iter().map(file).collect::<anyhow::Result<_>>()?;
        Ok(Self { files, units })
    }

    /// Writes the model, or each unit's; the files' names for a sentence.
    ///
    /// # Errors
    ///
    /// If the model would not load again, or a file cannot be written.
    pub(super) fn write(self, addition: &Addition) -> anyhow::Result<String> {
        let folder = |path: &Path| match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        let text = |i: usize, path: &Path| match self.units.get(i) {
            Some(unit) => addition.model_file_of(unit, &folder(path)),
            None => addition.model_file(&folder(path)),
        };
        let texts = self.files.iter().enumerate().map(|(i, (path, _))| text(i, path));
        let texts = texts.collect::<sealegs::Result<Vec<_>>>()?;
        let mut names = Vec::new();
        for ((path, destination), text) in self.files.into_iter().zip(texts) {
            destination.write(text.as_bytes())?;
            names.push(path.display().to_string());
        }
        Ok(names.join(", "))
    }
}

/// The files that are written: the one that was asked for, or one for each unit beside it.
fn outputs(asked: &Path, units: &[String]) -> anyhow::Result<Vec<PathBuf>> {
    if units.is_empty() {
        return Ok(vec![asked.to_owned()]);
    }
    if asked == Path::new("-") {
        return Err(bad_input(format!(
            "-o -: the campaign has the units '{}', and a model file is written for each; name a file",
            units.join("', '")
        )));
    }
    let stem = asked.file_stem().unwrap_or_default().to_string_lossy();
    let name = |unit: &String| match asked.extension() {
        Some(ending) => format!("{stem}-{unit}.{}", ending.to_string_lossy()),
        None => format!("{stem}-{unit}"),
    };
    Ok(units.iter().map(|unit| asked.with_file_name(name(unit))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_a_file_beside_the_one_that_was_asked_for() {
        let units = ["left".to_owned(), "right".to_owned()];
        let names = outputs(Path::new("out/better.toml"), &units).expect("names");
        assert_eq!(names, [Path::new("out/better-left.toml"), Path::new("out/better-right.toml")]);
        assert_eq!(outputs(Path::new("better.toml"), &[]).expect("a name"), [Path::new("better.toml")]);
        assert!(outputs(Path::new("-"), &units).is_err());
    }
}
