//! The state after a step, as the gauges read it.

use std::sync::OnceLock;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{
    near::{Crowd, Near},
    reactions::Reactions,
    state::State,
};
use crate::state::CHUNK;

/// Interface of the kinds of gauges.
pub(super) trait Probe: Send + Sync {
    /// Appends a figure for each of its quantities, `None` if there is no fluid to measure. `rows` is scratch memory.
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>);
}

/// The state after a step, and quantities that several gauges share.
pub(super) struct Moment<'a, 'w> {
    pub(super) state: &'a State<'w>,
    extent: OnceLock<(Vec3, Vec3)>,
    reactions: OnceLock<Reactions>,
}

impl<'a, 'w> Moment<'a, 'w> {
    pub(super) fn new(state: &'a State<'w>) -> Self {
        Self {
            state,
            extent: OnceLock::new(),
            reactions: OnceLock::new(),
        }
    }

    /// The fluid as it was indexed, at the start of the step.
    pub(super) fn fluid(&self) -> Near<'_> {
        Near {
            index: &*self.state.index.structure,
            points: self.state.pairs.positions().points(),
            slack: self.state.index.slack,
        }
    }

    /// Positions at the end of the step, without the sentinel.
    pub(super) fn places(&self) -> &[Vec4] {
        &self.state.places.0[..self.state.places_len()]
    }

    /// The fluid at the end of the step, found through the index of its start.
    pub(super) fn crowd(&self) -> Crowd<'_> {
        Crowd {
            near: self.fluid(),
            places: self.places(),
            dimension: self.state.material.dimension,
            spacing: self.state.material.spacing,
            period: self.state.material.period,
        }
    }

    /// Half extent of the box around a ball or disc.
    pub(super) fn reach(&self, radius: f32) -> Vec3 {
        self.crowd().reach(radius)
    }

    /// The box around the fluid at the start of the step.
    pub(super) fn extent(&self) -> (Vec3, Vec3) {
        let of = || {
            let points = self.fluid().points;
            let none = || (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (a.0.min(b.0), a.1.max(b.1));
            self.state.execution.install(|| {
                let chunks = points.par_chunks(CHUNK).map(|chunk| {
                    let points = chunk.iter().map(|x| x.truncate());
                    points.fold(none(), |all, x| join(all, (x, x)))
                });
                chunks.reduce(none, join)
            })
        };
        *self.extent.get_or_init(of)
    }

    /// Forces of the walls on the fluid.
    pub(super) fn reactions(&self) -> &Reactions {
        self.reactions.get_or_init(|| Reactions::new(self.state))
    }
}
