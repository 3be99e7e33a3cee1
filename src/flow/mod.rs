//! Fluid that enters and leaves during a run: emitters, boxes that remove, particles outside the domain.
//!
//! Both happen at the end of a step, after the rows were reordered: frames, checkpoints and hosts find the particles
//! that there are at that time. A step that fails has changed nothing, so only a roll-back by two steps has to undo
//! them ([`changes`]).
//!
//! A layer of an emitter is placed by the time alone, so layers are equally far apart whatever the steps are. It starts
//! about a support radius behind the face and moves at the emitter's speed up to there ([`held`]): fluid in front of
//! the face always has neighbours behind it. Why: `docs/decisions/emitters.md`.

pub(crate) mod changes;
mod emit;
mod held;
mod outflow;
mod sources;
mod stages;

pub(crate) use changes::Changes;
pub(crate) use held::{HELD, HeldRows, Hold, after_density, around_solve, find_held, require_held};
pub(crate) use sources::{Emitters, Turnover, has_emitters, removes};
pub(crate) use stages::{EMIT, OUTFLOW, install};
