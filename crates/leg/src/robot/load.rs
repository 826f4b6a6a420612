//! Finding a robot: an embedded one by its name, or a user's files.

use std::path::{Path, PathBuf};

use super::{LoadOptions, Robot, Source};
use crate::LegError;
use crate::error::nearest;

/// Name, URDF and placement file of the robots that come with the program.
const PRESETS: [(&str, &str, &str); 2] = [
    (
        "thor-leg",
        include_str!("../../../../assets/robots/thor-leg.urdf"),
        include_str!("../../../../assets/robots/thor-leg.actuators.toml"),
    ),
    (
        "saffir-leg",
        include_str!("../../../../assets/robots/saffir-leg.urdf"),
        include_str!("../../../../assets/robots/saffir-leg.actuators.toml"),
    ),
];

impl Robot {
    /// Names of the embedded robots.
    #[must_use]
    pub fn preset_names() -> Vec<&'static str> {
        PRESETS.iter().map(|(name, ..)| *name).collect()
    }

    /// The text of an embedded robot's URDF and placement file.
    #[must_use]
    pub fn preset_texts(name: &str) -> Option<(&'static str, &'static str)> {
        PRESETS.iter().find(|(n, ..)| *n == name).map(|(_, urdf, placement)| (*urdf, *placement))
    }

    /// A user's URDF if `name_or_path` is an existing file, else the embedded robot of that name. The
    /// actuators are those of `placement`, if given, else of `NAME.actuators.toml` beside the URDF, if there
    /// is one. Faults are mended with a remark, and packages are looked for where the environment says
    /// ([`LoadOptions::from_environment`]).
    ///
    /// # Errors
    ///
    /// [`LegError::UnknownRobot`], [`LegError::Io`], or what [`Robot::from_urdf`] and
    /// [`Robot::with_placement`] say.
    pub fn load(name_or_path: &str, placement: Option<&Path>) -> Result<Self, LegError> {
        Self::load_with(name_or_path, placement, &LoadOptions::from_environment())
    }

    /// As [`Robot::load`], with options.
    ///
    /// # Errors
    ///
    /// As [`Robot::load`], and with [`LoadOptions::strict`] whatever would be mended.
    pub fn load_with(
        name_or_path: &str,
        placement: Option<&Path>,
        options: &LoadOptions,
    ) -> Result<Self, LegError> {
        let path = Path::new(name_or_path);
        if path.is_file() {
            return Self::from_files(path, placement, options);
        }
        let Some((urdf, beside)) = Self::preset_texts(name_or_path) else {
            if path.extension().is_some_and(|e| e == "urdf") || path.components().count() > 1 {
                return Err(unreadable(path)(std::io::Error::new(
                    std::io::ErrorKind::NotFound,
                    "no such file",
                )));
            }
            let known = Self::preset_names();
            return Err(LegError::UnknownRobot {
                name: name_or_path.to_owned(),
                suggestion: nearest(name_or_path, known.iter().copied()),
                known: known.into_iter().map(str::to_owned).collect(),
            });
        };
        let mut robot = Self::from_urdf_with(urdf, &format!("{name_or_path}.urdf"), None, options)?;
        robot.source = Source::Preset(name_or_path.to_owned());
        match placement {
            Some(file) => robot.with_placement_file(file),
            None => robot.with_placement(beside, &format!("{name_or_path}.actuators.toml"), None),
        }
    }

    fn from_files(urdf: &Path, placement: Option<&Path>, options: &LoadOptions) -> Result<Self, LegError> {
        let text = std::fs::read_to_string(urdf).map_err(unreadable(urdf))?;
        let mut robot =
            Self::from_urdf_with(&text, &urdf.display().to_string(), Some(folder(urdf)), options)?;
        let beside = urdf.with_extension("actuators.toml");
        let placement: Option<PathBuf> =
            placement.map(Path::to_owned).or_else(|| beside.is_file().then_some(beside));
        robot.source = Source::Files { urdf: urdf.to_owned(), placement: placement.clone() };
        match placement {
            Some(file) => robot.with_placement_file(&file),
            None => Ok(robot),
        }
    }

    /// This robot with the actuators of a placement file.
    ///
    /// # Errors
    ///
    /// [`LegError::Io`], or what [`Robot::with_placement`] says.
    pub fn with_placement_file(self, file: &Path) -> Result<Self, LegError> {
        let text = std::fs::read_to_string(file).map_err(unreadable(file))?;
        self.with_placement(&text, &file.display().to_string(), Some(folder(file)))
    }
}

fn folder(file: &Path) -> &Path {
    file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn unreadable(path: &Path) -> impl FnOnce(std::io::Error) -> LegError + use<> {
    let path = path.display().to_string();
    move |source| LegError::Io { path, source }
}
