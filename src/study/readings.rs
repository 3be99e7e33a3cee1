//! Adds the readings of gauges to the blocks of a study.

use bevy_ecs::prelude::*;

use super::{
    definition::Column,
    gauge::Key,
    measure::{Block, Measure},
};
use crate::{
    gauge::{self, Gauges},
    measure::Curve,
    scene::{self, Scene},
};

/// Reference curves of the gauges of a scene.
pub(super) fn references(scene: &Scene) -> Vec<Option<Curve>> {
    let known = |gauge: &scene::Gauge| gauge.reference.as_ref()?.load().ok();
    scene.gauges.iter().map(known).collect()
}

/// Takes the readings that can no longer be rolled back, and adds those that columns need to a block.
pub(super) fn tally(
    world: &mut World,
    columns: &[Column],
    references: &[Option<Curve>],
    block: &mut Block,
) {
    let settled = gauge::settled_step(world);
    let Some(mut gauges) = world.get_resource_mut::<Gauges>() else {
        return;
    };
    let taken: Vec<_> = gauges.take_readings(settled).collect();
    let mut done: Vec<Key> = Vec::new();
    for column in columns {
        let Measure::Gauge(measure) = &column.measure else {
            continue;
        };
        let key = measure.key();
        if done.contains(&key) {
            continue;
        }
        let of_name = gauges
            .iter()
            .position(|gauge| gauge.name() == measure.gauge);
        let Some((gauge, number)) = of_name.and_then(|k| Some((gauges.iter().nth(k)?, k))) else {
            continue;
        };
        let place = match &measure.column {
            None => Some(0),
            Some(column) => gauge.columns().iter().position(|name| name == column),
        };
        let known = references.get(number).and_then(Option::as_ref);
        let tally = block.gauges.entry(key.clone()).or_default();
        for reading in &taken[number] {
            if let Some(value) = place.and_then(|place| reading.values[place]) {
                tally.add(value, known.and_then(|known| known.at(reading.time)));
            }
        }
        done.push(key);
    }
}
