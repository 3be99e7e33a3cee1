//! Reads the order file that a scene names.

use std::path::PathBuf;

use super::{error::OrderError, item::Order, plan::PlannedOrder};
use crate::{
    input::{read_text, without_mark},
    loading::place_of,
    registry::Stages,
    scene::{Place, Scene},
    step::error::InstallError,
};

/// The order of a scene, checked against `stages`.
pub(in crate::step) fn order_of(
    scene: &Scene,
    stages: &Stages,
) -> Result<PlannedOrder, InstallError> {
    let Some(path) = scene.order.as_ref().map(PathBuf::from) else {
        let planned = Order::standard().plan(scene, stages);
        return planned.map_err(|(error, _)| InstallError::Order { place: None, error });
    };
    let text = read_text(&path).map_err(|error| InstallError::OrderFile {
        path: path.clone(),
        error,
    })?;
    let file = path.display().to_string();
    let order = Order::parse(&text).map_err(|error| {
        let (line, column) = match error {
            OrderError::Syntax { line, column, .. } => (line, column),
            _ => (1, 1),
        };
        let place = Place::File {
            file: file.clone(),
            line,
            column,
        };
        InstallError::Order {
            place: Some(place),
            error,
        }
    })?;
    order
        .plan(scene, stages)
        .map_err(|(error, item)| InstallError::Order {
            place: Some(place_of(&item, without_mark(&text), &file)),
            error,
        })
}

/// Refuses an invalid order file.
pub(crate) fn check_order(scene: &Scene) -> Result<(), InstallError> {
    order_of(scene, &Stages::default()).map(|_| ())
}
