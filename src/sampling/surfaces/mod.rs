//! Samples surfaces at the spacing, in one layer inside the solid.

#[cfg(test)]
mod tests;

use std::f32::consts::{PI, TAU};

use glam::{IVec3, Vec3};

use super::{
    BoundarySample,
    ground::sample_ground,
    layer::{has_room, layer_depth, layer_depths, radius_of_layer},
    mesh::sample_mesh,
    round::{self, Row},
};
use crate::{
    mesh::MeshError,
    scene::{BoundaryShape, Dimension, Period, Scene, shapes::wall_axes},
};

/// Boundary particles of a scene. Fails if the file of a mesh was removed or is no longer valid.
pub fn sample(scene: &Scene) -> Result<Vec<BoundarySample>, MeshError> {
    let mut samples = Vec::new();
    for_each_sample(scene, &mut |sample| samples.push(sample))?;
    Ok(samples)
}

/// Calls `put` with each sample that [`sample`] would return. Only meshes need memory for it.
pub(crate) fn for_each_sample(
    scene: &Scene,
    put: &mut dyn FnMut(BoundarySample),
) -> Result<(), MeshError> {
    for_each_sample_of(scene, &mut |_, sample| put(sample))
}

/// As [`for_each_sample`], with the number of the sample's boundary.
pub(crate) fn for_each_sample_of(
    scene: &Scene,
    put: &mut dyn FnMut(u32, BoundarySample),
) -> Result<(), MeshError> {
    if scene.boundaries.is_empty() {
        return Ok(());
    }
    let period = scene.period();
    let mut shapes = (0..).zip(&scene.boundaries);
    shapes.try_for_each(|(number, shape)| {
        let mut put = |sample| put(number, sample);
        let lattice = (scene.dimension, scene.spacing, &period);
        layer_depths(scene)
            .enumerate()
            .try_for_each(|(layer, depth)| {
                let mut put = |sample| put(BoundarySample { depth, ..sample });
                sample_shape(shape, lattice, (depth, layer == 0), &mut put)
            })
    })
}

/// Places of the nearest layer of samples of one boundary \[m].
pub(crate) fn sample_boundary(
    shape: &BoundaryShape,
    scene: &Scene,
    put: &mut dyn FnMut(Vec3),
) -> Result<(), MeshError> {
    let period = scene.period();
    let lattice = (scene.dimension, scene.spacing, &period);
    sample_shape(shape, lattice, (layer_depth(scene), true), &mut |sample| {
        put(sample.position);
    })
}

fn sample_shape(
    shape: &BoundaryShape,
    (dimension, spacing, period): (Dimension, f32, &Period),
    (depth, is_first): (f32, bool),
    put: &mut dyn FnMut(BoundarySample),
) -> Result<(), MeshError> {
    let frame = shape.frame();
    if !frame.is_turned() {
        return sample_as_written(shape, (dimension, spacing, period), (depth, is_first), put);
    }
    let mut turned = |sample: BoundarySample| {
        put(BoundarySample {
            position: frame.place(sample.position.as_dvec3()).as_vec3(),
            normal: frame.direction(sample.normal.as_dvec3()).as_vec3(),
            ..sample
        });
    };
    // What is turned goes round no axis.
    let lattice = (dimension, spacing, &Period::NONE);
    sample_as_written(shape, lattice, (depth, is_first), &mut turned)
}

/// The samples of a shape before it is turned.
fn sample_as_written(
    shape: &BoundaryShape,
    (dimension, spacing, period): (Dimension, f32, &Period),
    (depth, is_first): (f32, bool),
    put: &mut dyn FnMut(BoundarySample),
) -> Result<(), MeshError> {
    let round = |min, max| round::rows(period, min, max, spacing);
    let inset = Vec3::splat(depth);
    match *shape {
        BoundaryShape::Tank { min, max, open, .. } => shell(
            min - inset,
            max + inset,
            (Side::Inside { open }, round(min, max)),
            dimension,
            spacing,
            put,
        ),
        BoundaryShape::Box { min, max, .. } => {
            if !is_first && !has_room(max - min, depth, dimension) {
                return Ok(());
            }
            // A plate thinner than the spacing has one layer, in its middle.
            let middle = 0.5 * (min + max);
            shell(
                (min + inset).min(middle),
                (max - inset).max(middle),
                (Side::Outside, round(min, max)),
                dimension,
                spacing,
                put,
            );
        }
        BoundaryShape::Sphere { center, radius, .. } => {
            let Some(radius) = radius_of_layer(radius, depth, is_first) else {
                return Ok(());
            };
            match dimension {
                Dimension::Two => circle(center, radius, spacing, put),
                Dimension::Three => sphere(center, radius, spacing, put),
            }
        }
        BoundaryShape::Plane {
            center,
            normal,
            half_size,
            ..
        } => {
            let normal = normal.normalize_or(Vec3::Y);
            plane(
                center - depth * normal,
                normal,
                half_size,
                (dimension, spacing, period),
                put,
            );
        }
        BoundaryShape::Mesh(_) | BoundaryShape::Revolution(_) | BoundaryShape::Terrain(_) => {
            let mut samples = Vec::new();
            let Some(mesh) = shape.mesh(spacing) else {
                return Ok(());
            };
            let mesh = mesh?;
            match &mesh.heights {
                Some(heights) => sample_ground(heights, spacing, depth, &mut samples),
                None => sample_mesh(&mesh, spacing, (depth, is_first), &mut samples),
            }
            // What goes round an axis is there once.
            let (low, high) = samples.iter().fold(
                (Vec3::INFINITY, Vec3::NEG_INFINITY),
                |(low, high), sample: &BoundarySample| {
                    (low.min(sample.position), high.max(sample.position))
                },
            );
            let goes_round = period.goes_round(low - spacing, high + spacing);
            let is_once = |sample: &BoundarySample| {
                let moved = sample.position.cmpne(period.wrap(sample.position));
                !(moved & goes_round).any()
            };
            samples.into_iter().filter(is_once).for_each(put);
        }
    }
    Ok(())
}

/// The side of a shell on which the fluid is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Inside { open: bool },
    Outside,
}

/// The surface of the box `min`–`max` on a lattice at most as coarse as the spacing; edges and corners once. Along an
/// axis that it goes round it has no ends, but the samples of a row.
fn shell(
    min: Vec3,
    max: Vec3,
    (fluid, round): (Side, [Option<Row>; 3]),
    dimension: Dimension,
    spacing: f32,
    put: &mut dyn FnMut(BoundarySample),
) {
    let size = max - min;
    let mut last = ((size / spacing) - Vec3::splat(1e-3))
        .ceil()
        .max(Vec3::ZERO)
        .as_ivec3();
    let (mut min, mut size) = (min, size);
    if dimension == Dimension::Two {
        (last.z, min.z, size.z) = (0, 0.0, 0.0);
    }
    let mut step = size / last.max(IVec3::ONE).as_vec3();
    for (axis, row) in round.iter().enumerate() {
        if let Some(row) = row {
            (min[axis], step[axis], last[axis]) = (row.first, row.step, row.count - 1);
        }
    }
    let open_top = fluid == Side::Inside { open: true } && round[1].is_none();
    let inwards = |axis: usize, k: i32| {
        let last = last[axis];
        let end = i32::from(k == 0) - i32::from(k == last && last > 0);
        if round[axis].is_some() { 0 } else { end }
    };
    for z in 0..=last.z {
        for y in 0..=last.y {
            // The walls of an open tank end at its rim.
            if open_top && y == last.y && y > 0 {
                continue;
            }
            let depth = if dimension == Dimension::Two {
                0
            } else {
                inwards(2, z)
            };
            // In a row inside the box only the ends are on the surface.
            let is_within = depth == 0 && inwards(1, y) == 0;
            let stride = if is_within { last.x.max(1) } else { 1 };
            for x in (0..=last.x).step_by(stride as usize) {
                let normal = IVec3::new(inwards(0, x), inwards(1, y), depth);
                if normal == IVec3::ZERO {
                    continue;
                }
                let mut face = |normal: IVec3| {
                    let outwards = if fluid == Side::Outside { -1.0 } else { 1.0 };
                    put(BoundarySample {
                        depth: 0.0,
                        position: min + step * IVec3::new(x, y, z).as_vec3(),
                        normal: outwards * normal.as_vec3().normalize(),
                    });
                };
                face(normal);
                // A plate with one layer has both faces in one place.
                let other = IVec3::select(last.cmpeq(IVec3::ZERO), -normal, normal);
                if other != normal {
                    face(other);
                }
            }
        }
    }
}

fn circle(center: Vec3, radius: f32, spacing: f32, put: &mut dyn FnMut(BoundarySample)) {
    let count = (TAU * radius / spacing).ceil().max(1.0) as u32;
    (0..count).for_each(|k| {
        let (sin, cos) = (TAU * k as f32 / count as f32).sin_cos();
        let normal = Vec3::new(cos, sin, 0.0);
        put(BoundarySample {
            depth: 0.0,
            position: (center + radius * normal).with_z(0.0),
            normal,
        });
    });
}

/// A Fibonacci lattice with one particle per square of the spacing.
fn sphere(center: Vec3, radius: f32, spacing: f32, put: &mut dyn FnMut(BoundarySample)) {
    let count = (4.0 * PI * (radius / spacing).powi(2)).ceil().max(1.0) as u32;
    let golden_angle = PI * (3.0 - 5f32.sqrt());
    (0..count).for_each(|k| {
        let height = 1.0 - (2.0 * k as f32 + 1.0) / count as f32;
        let ring = (1.0 - height * height).max(0.0).sqrt();
        let (sin, cos) = (golden_angle * k as f32).sin_cos();
        let normal = Vec3::new(ring * cos, height, ring * sin);
        put(BoundarySample {
            depth: 0.0,
            position: center + radius * normal,
            normal,
        });
    });
}

fn plane(
    center: Vec3,
    normal: Vec3,
    half_size: f32,
    (dimension, spacing, period): (Dimension, f32, &Period),
    put: &mut dyn FnMut(BoundarySample),
) {
    let (along, across) = wall_axes(normal, dimension);
    let places = |direction: Vec3| -> Vec<f32> {
        if let Some(row) = round::along(period, (center, direction, half_size), spacing) {
            return (0..row.count)
                .map(|k| row.first + row.step * k as f32)
                .collect();
        }
        let count = (2.0 * half_size / spacing - 1e-3).ceil().max(1.0) as i32;
        (0..=count)
            .map(|k| half_size * (2.0 * k as f32 / count as f32 - 1.0))
            .collect()
    };
    // In 2-D a wall is a line: a single row through its centre.
    let rows = match dimension {
        Dimension::Two => vec![0.0],
        Dimension::Three => places(across),
    };
    let columns = places(along);
    for aside in rows {
        columns.iter().for_each(|&place| {
            put(BoundarySample {
                depth: 0.0,
                position: center + place * along + aside * across,
                normal,
            });
        });
    }
}
