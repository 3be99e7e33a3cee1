//! Solid boundaries and the domain: proper shapes, and their surfaces.

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{box_is_proper, is_flat, radius_is_proper, turns_in_plane};
use crate::mesh::Mesh;
use crate::scene::{BoundaryShape, Dimension, Heights, Scene, TerrainBoundary};

pub(super) fn shapes(scene: &Scene) -> Checked {
    let dimension = scene.dimension;
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let path = format!("boundaries.{index}");
        if let BoundaryShape::Tank { rotation, .. }
        | BoundaryShape::Box { rotation, .. }
        | BoundaryShape::Sphere { rotation, .. }
        | BoundaryShape::Plane { rotation, .. } = *boundary
        {
            turns_in_plane(format!("{path}.rotation"), rotation, dimension)?;
        }
        match *boundary {
            BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max, .. } => {
                box_is_proper(&path, min, max, dimension)?;
            }
            BoundaryShape::Sphere { center, radius, .. } => {
                radius_is_proper(&path, radius)?;
                is_flat(format!("{path}.center"), center, dimension)?;
            }
            BoundaryShape::Plane {
                center,
                normal,
                half_size,
                ..
            } => {
                ensure(normal != Vec3::ZERO, format!("{path}.normal"), || {
                    "the normal is zero; it must point from the solid into the fluid".to_owned()
                })?;
                ensure(half_size > 0.0, format!("{path}.half_size"), || {
                    format!("the half size is {half_size} m; it must be above 0")
                })?;
                is_flat(format!("{path}.center"), center, dimension)?;
                is_flat(format!("{path}.normal"), normal, dimension)?;
            }
            BoundaryShape::Revolution(_) => in_space(dimension, &path, "a surface of revolution")?,
            BoundaryShape::Terrain(ref terrain) => {
                in_space(dimension, &path, "a terrain")?;
                ground(terrain, &path)?;
            }
            BoundaryShape::Mesh(ref mesh) => {
                in_space(dimension, &path, "a mesh")?;
                ensure(mesh.scale > 0.0, format!("{path}.scale"), || {
                    format!("the scale is {}; it must be above 0", mesh.scale)
                })?;
            }
        }
    }
    match scene.domain {
        Some(domain) => box_is_proper("domain", domain.min, domain.max, dimension),
        None => Ok(()),
    }
}

fn in_space(dimension: Dimension, path: &str, what: &str) -> Checked {
    ensure(dimension == Dimension::Three, path, || {
        format!("{what} needs `dimension: 3`; in 2-D a `Plane`, a `Box` or a `Sphere` can be used")
    })
}

fn ground(terrain: &TerrainBoundary, path: &str) -> Checked {
    let size = terrain.size;
    ensure(
        size.iter().all(|edge| *edge > 0.0),
        format!("{path}.size"),
        || {
            format!(
                "the ground is {} × {} m; both edges must be above 0",
                size[0], size[1]
            )
        },
    )?;
    let path = format!("{path}.heights");
    let positive = |name: &str, value: f64| {
        ensure(value > 0.0, format!("{path}.{name}"), || {
            format!("`{name}` is {value} m; it must be above 0")
        })
    };
    let not_negative = |name: &str, value: f64| {
        ensure(value >= 0.0, format!("{path}.{name}"), || {
            format!("`{name}` is {value} m; it must not be negative")
        })
    };
    match &terrain.heights {
        Heights::Image { .. } => Ok(()),
        Heights::Grid { scale, .. } => positive("scale", *scale),
        Heights::Generated(rolling) => {
            positive("cell", rolling.cell)?;
            positive("wavelength", rolling.wavelength)?;
            not_negative("amplitude", rolling.amplitude)?;
            ensure(rolling.octaves <= 16, format!("{path}.octaves"), || {
                format!(
                    "there are {} octaves; at most 16 are possible, and each halves the wavelength",
                    rolling.octaves
                )
            })?;
            let Some(channel) = rolling.channel else {
                return Ok(());
            };
            positive("channel.width", channel.width)?;
            positive("channel.meander_length", channel.meander_length)?;
            not_negative("channel.depth", channel.depth)?;
            not_negative("channel.meander", channel.meander)
        }
    }
}

/// The surfaces of the boundaries that are meshes or made of triangles.
pub(super) fn meshes(scene: &Scene) -> Result<Vec<Option<Mesh>>, Problem> {
    let load = |(index, boundary): (usize, &BoundaryShape)| {
        let field = match boundary {
            BoundaryShape::Revolution(_) => "profile",
            BoundaryShape::Terrain(_) => "heights",
            _ => "file",
        };
        let mesh = boundary.mesh(scene.spacing).transpose();
        mesh.map_err(|error| Problem::new(format!("boundaries.{index}.{field}"), error.to_string()))
    };
    scene.boundaries.iter().enumerate().map(load).collect()
}
