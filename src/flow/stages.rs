//! The stages of fluid that enters and leaves.

use bevy_ecs::prelude::*;

use super::{
    changes::{self, Changes},
    emit::emit,
    held::HeldRows,
    outflow::{Outflow, find_leaving, remove, somebody_leaves},
    sources::{Emitters, Turnover, has_emitters, removes},
};
use crate::{
    scene::Scene,
    state::{Phase, Stage},
};

/// Fluid that enters.
pub(crate) const EMIT: Stage = Stage {
    invalidates: true,
    wanted: has_emitters,
    install: |world, scene| {
        install(world, scene);
        emit(world);
    },
    // Particles that wait behind a face, and places of a layer: few beside the fluid.
    ..Stage::new("emit", Phase::Reorder, |_| emit.into_configs())
};

/// Fluid that leaves.
pub(crate) const OUTFLOW: Stage = Stage {
    invalidates: true,
    wanted: removes,
    install,
    ..Stage::new("outflow", Phase::Reorder, |_| {
        (find_leaving, remove.run_if(somebody_leaves)).chain()
    })
};

/// Inserts the resources of a scene's flow, also where an order leaves its stages out.
pub(crate) fn install(world: &mut World, scene: &Scene) {
    let (enters, leaves) = (has_emitters(scene), removes(scene));
    if !(enters || leaves) || world.contains_resource::<Turnover>() {
        return;
    }
    world.init_resource::<Turnover>();
    if enters {
        world.insert_resource(Emitters::new(scene));
        world.init_resource::<HeldRows>();
    }
    if leaves {
        world.insert_resource(Outflow::new(scene));
    }
    if changes::are_kept(scene) {
        world.init_resource::<Changes>();
    }
}
