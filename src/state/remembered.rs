//! What a step leaves behind for the next besides the columns, as bytes that a checkpoint keeps.
//!
//! A resource that a later step reads before that step writes it is part of the state of a run. It says beside its own
//! code what of it is.

use bevy_ecs::{component::Mutable, prelude::*};
use serde::{Serialize, de::DeserializeOwned};

/// A resource that is part of the state of a run.
pub(crate) trait Remembers: Resource<Mutability = Mutable> {
    /// What of it is.
    type State: Serialize + DeserializeOwned;

    /// That part now; `rows` are the particles in the order of the rows.
    fn state(&self, rows: &[Entity]) -> Self::State;

    /// Takes over that part. Fails if it is of another scene.
    fn set_state(&mut self, state: Self::State, rows: &[Entity]) -> Result<(), &'static str>;
}

/// The state of a world's particles, in the order of these rows, as bytes; none in a world that lacks it.
pub(crate) type SaveRows = fn(&World, &[Entity]) -> Result<Option<Vec<u8>>, String>;

/// Gives a world's particles, in the order of these rows, the state that bytes hold.
pub(crate) type LoadRows = fn(&mut World, &[Entity], &[u8]) -> Result<(), String>;

/// A resource of that kind, by its row in the registry.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Remembered {
    /// Its name in a checkpoint.
    pub(crate) name: &'static str,
    /// Its state as bytes; none in a world that lacks it.
    pub(crate) save: SaveRows,
    /// Takes over its state from bytes.
    pub(crate) load: LoadRows,
    /// Whether the world has it.
    pub(crate) is_present: fn(&World) -> bool,
}

impl Remembered {
    /// The row of a resource.
    pub(crate) const fn new<R: Remembers>(name: &'static str) -> Self {
        Self {
            name,
            save: save::<R>,
            load: load::<R>,
            is_present: |world| world.contains_resource::<R>(),
        }
    }
}

fn save<R: Remembers>(world: &World, rows: &[Entity]) -> Result<Option<Vec<u8>>, String> {
    let Some(resource) = world.get_resource::<R>() else {
        return Ok(None);
    };
    to_bytes(&resource.state(rows)).map(Some)
}

fn load<R: Remembers>(world: &mut World, rows: &[Entity], bytes: &[u8]) -> Result<(), String> {
    let state = from_bytes(bytes)?;
    let Some(mut resource) = world.get_resource_mut::<R>() else {
        return Err("this scene does not have it".to_owned());
    };
    Ok(resource.set_state(state, rows)?)
}

/// A value as bytes.
pub(crate) fn to_bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, String> {
    postcard::to_stdvec(value).map_err(|error| error.to_string())
}

/// The value that bytes hold, all of them.
pub(crate) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let (value, rest) = postcard::take_from_bytes(bytes).map_err(|error| error.to_string())?;
    if rest.is_empty() {
        Ok(value)
    } else {
        Err(format!("{} bytes are left over", rest.len()))
    }
}
