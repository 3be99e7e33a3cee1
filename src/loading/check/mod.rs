//! What a scene must fulfil before it runs. The first problem is reported: a later one is often its consequence.

mod bodies;
mod body_shapes;
mod boxes;
mod carried;
mod emitter_places;
mod emitters;
mod forces;
mod gauges;
mod motions;
mod numbers;
mod periodic;
mod pressure;
mod problem;
mod proper;
mod sequence;
mod size;
mod solids;
mod stability;

pub(in crate::loading) use problem::Problem;
pub(in crate::loading) use sequence::check;
pub(crate) use size::Size;
