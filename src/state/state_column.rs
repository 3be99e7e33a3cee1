//! What a component needs to be a column of the state.

use std::ops::Range;

use bevy_ecs::{component::Mutable, prelude::*};
use bytemuck::TransparentWrapper;
use serde::{Serialize, de::DeserializeOwned};

use super::execution::Execution;

/// A component that lasts from step to step, and the column of rows that a step leaves of it.
pub(crate) trait StateColumn:
    Component<Mutability = Mutable> + TransparentWrapper<Self::Value> + Copy
{
    /// What it wraps.
    type Value: Copy + Send + Sync + Serialize + DeserializeOwned + 'static;
    /// The resource that holds its rows at the end of a step.
    type Result: Resource;

    /// Name of the component in messages.
    const COMPONENT: &'static str;

    /// Copies rows of the result.
    fn scatter(result: &Self::Result, rows: Range<usize>, out: &mut [Self::Value], on: &Execution);

    /// What stands for it in a table that lacks it.
    fn stand_in(_: &[f32]) -> Option<&[Self::Value]> {
        None
    }
}

/// A column of the state whose values a step starts from.
pub(crate) trait GatheredColumn: StateColumn {
    /// The resource that holds its rows at the start of a step.
    type Start: Resource<Mutability = Mutable>;

    /// Name of the quantity in messages.
    const QUANTITY: &'static str;

    /// Makes room for so many rows.
    fn resize(start: &mut Self::Start, rows: usize);

    /// Copies values into the rows from `first` on. Gives the first row whose value no step can start from, and
    /// whether it is only too large.
    fn gather(
        start: &mut Self::Start,
        first: usize,
        values: &[Self::Value],
        on: &Execution,
    ) -> Option<(usize, bool)>;

    /// Copies the rows of other ranks' particles from them.
    fn share(start: &mut Self::Start, on: &Execution);
}

/// What a table held before it took the state of the last good step, in the order of the rows.
#[derive(Resource)]
pub(super) struct Kept<C>(pub(super) Vec<C>);
