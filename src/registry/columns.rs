//! The columns of a scene's particles.

use crate::{
    flow::HELD,
    pressure::warm_start::MEAN_PRESSURE,
    scene::Scene,
    state::{COLUMNS, Column, Lasting},
};

/// The columns that a scene needs: first those of the state, then those that every step recomputes.
pub fn columns(scene: &Scene) -> impl Iterator<Item = &'static Column> + Clone {
    let all = COLUMNS.iter().chain(const { &[MEAN_PRESSURE, HELD] });
    let of_method = scene.pressure.solver().columns();
    let wanted: Vec<_> = all.filter(|column| (column.wanted)(scene)).collect();
    wanted.into_iter().chain(of_method)
}

/// The transport of a scene's state from step to step.
pub(super) fn lasting(scene: &Scene) -> Vec<Lasting> {
    columns(scene).filter_map(|column| column.lasting).collect()
}
