//! Tests of the leg in motion, by topic.

mod coupling;
mod drop;
mod fault;
mod momentum;
mod pendulum;
mod repeat;
mod stance;
