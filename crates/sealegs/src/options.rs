//! With which model a campaign is compared, and how a caller watches and stops the work.

use sealegs_actuator::ActuatorSpec;
use sealegs_leg::scenario::Scenario;
use sealegs_sysid::Campaign;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Where the model of a campaign comes from.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub enum ModelSource {
    /// What the campaign names: its actuator on its bench, or its scenario.
    #[default]
    Campaign,
    /// An actuator file, for a leg a scenario file, or the name of a preset.
    File(PathBuf),
    /// An actuator, on the campaign's bench.
    Actuator(Box<ActuatorSpec>),
    /// A scenario, for a leg.
    Scenario(Box<Scenario>),
}

impl ModelSource {
    /// The model's name in messages and in what is written of its origin.
    #[must_use]
    pub fn label(&self, campaign: &Campaign) -> String {
        match self {
            Self::Campaign => {
                let stated =
                    campaign.scenario.as_ref().or(campaign.robot.as_ref()).unwrap_or(&campaign.actuator);
                campaign.folder().join(stated).display().to_string()
            }
            Self::File(path) => path.display().to_string(),
            Self::Actuator(spec) => format!("actuator '{}'", spec.description),
            Self::Scenario(scenario) => format!("scenario '{}'", scenario.name),
        }
    }

    /// The file, if it is one.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) if path.is_file() => Some(path),
            _ => None,
        }
    }
}

impl From<Option<&Path>> for ModelSource {
    fn from(file: Option<&Path>) -> Self {
        file.map_or(Self::Campaign, |path| Self::File(path.to_owned()))
    }
}

impl From<&str> for ModelSource {
    fn from(name: &str) -> Self {
        Self::File(name.into())
    }
}

impl From<&Path> for ModelSource {
    fn from(path: &Path) -> Self {
        Self::File(path.to_owned())
    }
}

impl From<PathBuf> for ModelSource {
    fn from(path: PathBuf) -> Self {
        Self::File(path)
    }
}

impl From<ActuatorSpec> for ModelSource {
    fn from(spec: ActuatorSpec) -> Self {
        Self::Actuator(Box::new(spec))
    }
}

impl From<Scenario> for ModelSource {
    fn from(scenario: Scenario) -> Self {
        Self::Scenario(Box::new(scenario))
    }
}

/// Whoever is told what is being done.
type Tell = dyn Fn(&str) + Send + Sync;

/// What [`compare`](crate::compare()), [`diagnose`](crate::diagnose()) and [`add`](crate::add()) take beside a campaign.
///
/// ```
/// use sealegs::Options;
///
/// let options = Options::new().model("thor-linear").on_progress(|what| eprintln!("{what}"));
/// ```
#[derive(Clone, Default)]
#[must_use]
pub struct Options {
    pub(crate) model: ModelSource,
    pub(crate) own_effects: Vec<PathBuf>,
    pub(crate) as_is: bool,
    pub(crate) force: bool,
    pub(crate) command: String,
    pub(crate) progress: Option<Arc<Tell>>,
    pub(crate) stop: Stop,
    pub(crate) search_at_most: Option<Duration>,
}

impl Options {
    /// The campaign's own model, nothing more.
    pub fn new() -> Self {
        Self::default()
    }

    /// Another model in place of the campaign's.
    pub fn model(mut self, model: impl Into<ModelSource>) -> Self {
        self.model = model.into();
        self
    }

    /// An effect of the user's own beside the catalogue's, by its file. May be repeated.
    pub fn own_effect(mut self, file: impl Into<PathBuf>) -> Self {
        self.own_effects.push(file.into());
        self
    }

    /// Only [`compare`](crate::compare()) asks: the model's own values are not refitted.
    pub fn as_is(mut self, as_is: bool) -> Self {
        self.as_is = as_is;
        self
    }

    /// Only [`diagnose`](crate::diagnose()) asks: it begins although the log is not what its header says.
    pub fn force(mut self, force: bool) -> Self {
        self.force = force;
        self
    }

    /// Only [`diagnose`](crate::diagnose()) asks: its search ends after this time, counted from its begin, and the best set that was
    /// found until then is judged; the verdict says so. How much is found depends on the machine then.
    pub fn search_at_most(mut self, time: Duration) -> Self {
        self.search_at_most = Some(time);
        self
    }

    /// The command that reports and model files name as their origin.
    pub fn command(mut self, command: impl Into<String>) -> Self {
        self.command = command.into();
        self
    }

    /// Called, from any thread, with what is being done, in a few words.
    pub fn on_progress(mut self, tell: impl Fn(&str) + Send + Sync + 'static) -> Self {
        self.progress = Some(Arc::new(tell));
        self
    }

    /// A handle that ends the work from another thread.
    pub fn stop(mut self, stop: &Stop) -> Self {
        self.stop = stop.clone();
        self
    }

    /// The handle that ends the work.
    #[must_use]
    pub fn stop_handle(&self) -> Stop {
        self.stop.clone()
    }

    /// The files that go into a result beside the campaign's.
    pub(crate) fn files(&self) -> Vec<&Path> {
        self.model.file().into_iter().chain(self.own_effects.iter().map(PathBuf::as_path)).collect()
    }

    /// The command as it was given; without one what the library did.
    pub(crate) fn command_of(&self, call: &str) -> String {
        if self.command.is_empty() { call.to_owned() } else { self.command.clone() }
    }

    pub(crate) fn tell(&self, what: &str) {
        if let Some(tell) = &self.progress {
            tell(what);
        }
    }
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("model", &self.model)
            .field("own_effects", &self.own_effects)
            .field("as_is", &self.as_is)
            .field("force", &self.force)
            .field("command", &self.command)
            .field("stop", &self.stop)
            .field("search_at_most", &self.search_at_most)
            .finish_non_exhaustive()
    }
}

impl<M: Into<ModelSource>> From<M> for Options {
    fn from(model: M) -> Self {
        Self::new().model(model)
    }
}

impl From<&Self> for Options {
    fn from(options: &Self) -> Self {
        options.clone()
    }
}

/// Ends work from another thread, and counts its simulations; clones are handles of the same work.
///
/// The work ends with [`Error::Stopped`](crate::Error::Stopped) after the simulations that are running, which take
/// milliseconds.
///
/// ```
/// use sealegs::{Options, Stop};
///
/// let stop = Stop::new();
/// let options = Options::new().stop(&stop);
/// // In another thread, or when a signal comes:
/// stop.stop();
/// assert!(options.stop_handle().is_stopped());
/// ```
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<State>);

#[derive(Debug, Default)]
struct State {
    stopped: AtomicBool,
    simulations: AtomicU64,
    search_ended: AtomicBool,
}

impl Stop {
    /// A handle of work that has not begun.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Ends the work.
    pub fn stop(&self) {
        self.0.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether the work was told to end.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.0.stopped.load(Ordering::Relaxed)
    }

    /// Ends a diagnosis's search and no more: the best set that was found so far is judged, and the verdict says so. Before the
    /// search has begun, the base model alone is judged.
    pub fn end_search(&self) {
        self.0.search_ended.store(true, Ordering::Relaxed);
    }

    /// Whether a diagnosis's search was told to end.
    pub(crate) fn ends_search(&self) -> bool {
        self.0.search_ended.load(Ordering::Relaxed)
    }

    /// Simulations begun so far.
    #[must_use]
    pub fn simulations(&self) -> u64 {
        self.0.simulations.load(Ordering::Relaxed)
    }

    pub(crate) fn count(&self) {
        self.0.simulations.fetch_add(1, Ordering::Relaxed);
    }
}
