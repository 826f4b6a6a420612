//! What is used of Rerun, from its smaller crates: the crate `rerun` itself brings a data store, a server's client, video
//! and telemetry, which made up half of a first build and of the program.

pub(super) use re_chunk::{Chunk, EntityPath, RowId, TimeColumn, TimePoint};
pub(super) use re_log_types::{
    BlueprintActivationCommand, EntityPathPart, LogMsg, SetStoreInfo, StoreId, StoreInfo, StoreKind,
    StoreSource,
};
pub(super) use re_sdk_types::archetypes::{
    Arrows3D, Boxes3D, Capsules3D, Cylinders3D, Ellipsoids3D, LineStrips3D, Mesh3D, RecordingInfo, Scalars,
    SeriesLines, TextDocument, TextLog, Transform3D, ViewCoordinates,
};
pub(super) use re_sdk_types::components::{Color, FillMode, MediaType, TextLogLevel, Timestamp};
pub(super) use re_sdk_types::datatypes::{Quaternion, Rgba32};
pub(super) use re_sdk_types::{
    AsComponents, ComponentDescriptor, SerializedComponentBatch, SerializedComponentColumn, blueprint,
    components,
};
