//! Parts of the messages of failures.

use bevy_ecs::entity::Entity;
use glam::Vec3;

pub(super) fn boundaries(numbers: &[u32]) -> String {
    let names = numbers
        .iter()
        .map(|number| format!("`boundaries.{number}`"));
    names.collect::<Vec<_>>().join(" and ")
}

/// As many particles of one table lack the same.
pub(super) fn others(particles: usize) -> String {
    match particles {
        0 | 1 => String::new(),
        more => format!(", and so do {} others", more - 1),
    }
}

pub(super) fn place(particle: &Option<(Entity, Vec3)>) -> String {
    particle.map_or_else(String::new, |(entity, at)| {
        format!(
            " (entity {} at ({:.4}, {:.4}, {:.4}) m)",
            entity.index_u32(),
            at.x,
            at.y,
            at.z
        )
    })
}
