//! How a robot's file is read: with its faults mended or refused, and where its packages are looked for.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// What a reader of URDF may do.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LoadOptions {
    /// Refuses what would otherwise be mended or left out with a remark: links of zero mass, mass properties that
    /// no body has, joints without limits, `mimic`, meshes that cannot be read.
    pub strict: bool,
    /// Folders that hold packages, each in a folder of its own name, and packages themselves: where
    /// `package://name/path` is looked for before the folders above the URDF.
    pub package_folders: Vec<PathBuf>,
}

impl LoadOptions {
    /// Mends, and looks for packages where `ROS_PACKAGE_PATH` (ROS 1) and `AMENT_PREFIX_PATH` (ROS 2, in `share`
    /// below each prefix) say.
    #[must_use]
    pub fn from_environment() -> Self {
        let variable = |name| std::env::var_os(name).unwrap_or_default();
        Self::with_paths(&variable("ROS_PACKAGE_PATH"), &variable("AMENT_PREFIX_PATH"))
    }

    fn with_paths(ros_package_path: &OsStr, ament_prefix_path: &OsStr) -> Self {
        let ros = std::env::split_paths(ros_package_path);
        let ament = std::env::split_paths(ament_prefix_path).map(|prefix| prefix.join("share"));
        let named = |p: &PathBuf| p.is_absolute();
        Self { strict: false, package_folders: ros.chain(ament).filter(named).collect() }
    }

    /// The file that a URDF in `folder` calls `name`: a path from that folder, `file://`, or `package://` (also
    /// `model://`, as Gazebo has it).
    ///
    /// A package is looked for in [`LoadOptions::package_folders`] and one level below them, then in the folders
    /// above the URDF, where the URDF's own package may have any name.
    pub(super) fn find(&self, name: &str, folder: Option<&Path>) -> Option<PathBuf> {
        let folder = folder.unwrap_or(Path::new("."));
        let Some(inside) = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://")) else {
            let path = folder.join(name.strip_prefix("file://").unwrap_or(name));
            return path.is_file().then_some(path);
        };
        let (package, below) = inside.split_once('/').unwrap_or(("", inside));
        let below = below.trim_start_matches('/');
        let stated = self.package_folders.iter().find_map(|root| in_package(root, package, below));
        stated.or_else(|| {
            let absolute = std::path::absolute(folder).ok()?;
            absolute
                .ancestors()
                .flat_map(|a| [a.join(below), a.join(package).join(below)])
                .find(|p| p.is_file())
        })
    }
}

/// A file of a package that is `root` itself, lies in it, or lies in a folder of it.
fn in_package(root: &Path, package: &str, below: &str) -> Option<PathBuf> {
    let itself = root.file_name().is_some_and(|n| n == package).then(|| root.join(below));
    let direct = std::iter::once(root.join(package).join(below));
    if let Some(found) = itself.into_iter().chain(direct).find(|p| p.is_file()) {
        return Some(found);
    }
    let mut folders: Vec<PathBuf> = std::fs::read_dir(root).ok()?.flatten().map(|e| e.path()).collect();
    // The order of a folder's entries is the file system's.
    folders.sort();
    folders.into_iter().map(|f| f.join(package).join(below)).find(|p| p.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_generations_of_ros_say_where_packages_are() {
        let roots = std::env::temp_dir();
        let (a, b, c) = (roots.join("a"), roots.join("b"), roots.join("c"));
        let ros = std::env::join_paths([&a, &b]).expect("no separator in them");
        let options = LoadOptions::with_paths(&ros, c.as_os_str());
        assert_eq!(options.package_folders, [a, b, c.join("share")]);
        assert!(!options.strict);
        // An empty variable is no root: it would stand for the working folder.
        assert!(LoadOptions::with_paths(OsStr::new(""), OsStr::new("")).package_folders.is_empty());
    }
}
