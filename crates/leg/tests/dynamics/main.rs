//! Tests of the leg in motion, by topic.

mod coupling;
mod drop;
mod fault;
mod momentum;
mod pendulum;
mod reference;
mod repeat;
mod stance;
