//! Columns of the state as bytes, for checkpoints and for particles that go to other ranks.

use std::ops::Range;

use bevy_ecs::prelude::*;

use super::{
    remembered::{from_bytes, to_bytes},
    state_column::{Kept, StateColumn},
};

/// A column in a checkpoint: the values of the particles that have it, and the rows of those that lack it.
type Saved<V> = (Vec<V>, Vec<u32>);

pub(super) fn save<C: StateColumn>(world: &World, entities: &[Entity]) -> Result<Vec<u8>, String> {
    let mut saved: Saved<C::Value> = (Vec::with_capacity(entities.len()), Vec::new());
    for (row, &entity) in (0..).zip(entities) {
        match world.get::<C>(entity) {
            Some(value) => saved.0.push(C::peel(*value)),
            None => saved.1.push(row),
        }
    }
    to_bytes(&saved)
}

pub(super) fn load<C: StateColumn>(
    world: &mut World,
    entities: &[Entity],
    bytes: &[u8],
) -> Result<(), String> {
    let (values, lacking): Saved<C::Value> = from_bytes(bytes)?;
    if values.len() + lacking.len() != entities.len() {
        let found = values.len() + lacking.len();
        return Err(format!("{found} values for {} particles", entities.len()));
    }
    let mut values = values.into_iter();
    let mut lacking = lacking.into_iter().peekable();
    for (row, &entity) in (0..).zip(entities) {
        let mut particle = (world.get_entity_mut(entity)).map_err(|error| error.to_string())?;
        if lacking.next_if_eq(&row).is_some() {
            particle.remove::<C>();
            continue;
        }
        let value = C::wrap(values.next().ok_or("its rows are mixed up")?);
        match particle.get_mut::<C>() {
            Some(mut present) => *present = value,
            None => {
                particle.insert(value);
            }
        }
    }
    Ok(())
}

/// Columns of several ranks, in the order of the rows, as one.
pub(super) fn join<C: StateColumn>(parts: &[Vec<u8>]) -> Result<Vec<u8>, String> {
    let mut all: Saved<C::Value> = (Vec::new(), Vec::new());
    for part in parts {
        let (values, lacking): Saved<C::Value> = from_bytes(part)?;
        let first = (all.0.len() + all.1.len()) as u32;
        all.0.extend(values);
        all.1.extend(lacking.iter().map(|row| first + row));
    }
    to_bytes(&all)
}

/// The column of some rows.
pub(super) fn part<C: StateColumn>(bytes: &[u8], rows: Range<usize>) -> Result<Vec<u8>, String> {
    let (values, lacking): Saved<C::Value> = from_bytes(bytes)?;
    let (mut values, mut lacking) = (values.into_iter(), lacking.into_iter().peekable());
    let mut part: Saved<C::Value> = (Vec::with_capacity(rows.len()), Vec::new());
    for row in 0..rows.end {
        let place = row.checked_sub(rows.start);
        if lacking.next_if_eq(&(row as u32)).is_some() {
            part.1.extend(place.map(|place| place as u32));
        } else {
            let value = values.next().ok_or("it has too few values")?;
            part.0.extend(place.map(|_| value));
        }
    }
    to_bytes(&part)
}

pub(super) fn save_kept<C: StateColumn>(world: &World) -> Result<Option<Vec<u8>>, String> {
    let Some(kept) = world.get_resource::<Kept<C>>() else {
        return Ok(None);
    };
    let values: Vec<C::Value> = kept.0.iter().map(|value| C::peel(*value)).collect();
    to_bytes(&values).map(Some)
}

pub(super) fn load_kept<C: StateColumn>(world: &mut World, bytes: &[u8]) -> Result<(), String> {
    let values: Vec<C::Value> = from_bytes(bytes)?;
    let Some(mut kept) = world.get_resource_mut::<Kept<C>>() else {
        return Err("this scene keeps no state to go back to".to_owned());
    };
    kept.0 = values.into_iter().map(C::wrap).collect();
    Ok(())
}
