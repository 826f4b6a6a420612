//! The leg's dynamics: rigid bodies in the engine, and every force on them.

pub(crate) mod command;
pub mod contact;
pub mod coupling;
pub(crate) mod drive;
pub(crate) mod engine;
pub(crate) mod equations;
mod stiff;
pub mod stop;
pub(crate) mod tree;
