//! Where things are inside a recording.

use super::rerun::{EntityPath, EntityPathPart};

/// The one timeline: simulated or measured time, s.
pub(super) const TIMELINE: &str = "time";
/// Parent of everything in the 3D view.
pub(super) const WORLD: &str = "world";
/// The text log.
pub(super) const EVENTS: &str = "events";
/// Parent of the documents.
pub(super) const DOCUMENTS: &str = "documents";
/// Where a finished recording says so.
pub(super) const ENDING: &str = "recording_end";
/// What a finished recording says there.
pub(super) const COMPLETE: &str = "complete";

/// A path from parts that may hold any character, without empty parts.
pub(super) fn path<'a>(parts: impl IntoIterator<Item = &'a str>) -> EntityPath {
    EntityPath::new(parts.into_iter().filter(|p| !p.is_empty()).map(EntityPathPart::new).collect())
}

/// The path of a series group, whose name may have several parts.
pub(super) fn group(name: &str) -> EntityPath {
    path(name.split('/'))
}

/// The name of a group as its path reads back.
pub(super) fn name_of(entity: &EntityPath) -> String {
    entity.iter().map(|p| p.unescaped_str()).collect::<Vec<_>>().join("/")
}
