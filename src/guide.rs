//! Pages that teach: how a step works, where the data is, and what to rely on. Every example is compiled and run.

#[doc = include_str!("../docs/guide/step.md")]
pub mod step {}

#[doc = include_str!("../docs/guide/data.md")]
pub mod data {}

#[doc = include_str!("../docs/guide/embedding.md")]
pub mod embedding {}

#[doc = include_str!("../docs/guide/orders.md")]
pub mod orders {}

#[doc = include_str!("../docs/guide/accuracy.md")]
pub mod accuracy {}

#[doc = include_str!("../docs/guide/limits.md")]
pub mod limits {}
