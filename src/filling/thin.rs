//! Samples of meshes that are thinner than two layers somewhere: there samples lie nearer to the faces than elsewhere,
//! and fluid that is far enough from a face is too near to them.

use std::collections::HashMap;

use glam::{DVec3, IVec3};

use crate::mesh::Mesh;
use crate::sampling::{has_thin_parts, layer_depth, sample_boundary};
use crate::scene::shapes::tolerance;
use crate::scene::{Period, Scene};

/// The samples of thin meshes, in cells as wide as their reach.
pub(super) struct ThinMeshes {
    cells: HashMap<IVec3, Vec<DVec3>>,
    /// Distance of the fluid's first row from the layer behind a flat face \[m].
    reach: f64,
    period: Period,
}

/// Samples lie at this part of the layer's depth at least.
const DEEP: f64 = 0.97;

impl ThinMeshes {
    /// `meshes` are the surfaces of the boundaries.
    pub(super) fn new(scene: &Scene, meshes: &[Option<Mesh>]) -> Self {
        let (spacing, depth) = (f64::from(scene.spacing), f64::from(layer_depth(scene)));
        let mut thin = Self {
            cells: HashMap::new(),
            reach: (0.5 - tolerance(0.0, spacing)) * spacing + DEEP * depth,
            period: scene.period(),
        };
        for (boundary, mesh) in scene.boundaries.iter().zip(meshes) {
            let is_thin = mesh
                .as_ref()
                .is_some_and(|mesh| has_thin_parts(mesh, spacing, depth));
            if is_thin {
                let put = &mut |place: glam::Vec3| thin.put(place.as_dvec3());
                // A file that was lost meanwhile is named where the walls are made.
                sample_boundary(boundary, scene, put).ok();
            }
        }
        thin
    }

    fn cell(&self, place: DVec3) -> IVec3 {
        (place / self.reach).floor().as_ivec3()
    }

    fn put(&mut self, place: DVec3) {
        let cell = self.cell(place);
        self.cells.entry(cell).or_default().push(place);
    }

    /// Whether fluid at a point is as far from all samples as from a layer behind a flat face.
    pub(super) fn leave_room(&self, point: DVec3) -> bool {
        if self.cells.is_empty() {
            return true;
        }
        self.images(point).all(|point| {
            let cell = self.cell(point);
            let around = (-1..=1).flat_map(|z| {
                (-1..=1).flat_map(move |y| (-1..=1).map(move |x| cell + IVec3::new(x, y, z)))
            });
            let near = around.filter_map(|cell| self.cells.get(&cell)).flatten();
            let mut squares = near.map(|sample| sample.distance_squared(point));
            squares.all(|square| square >= self.reach * self.reach)
        })
    }

    /// A point, and where it is again in a periodic scene, as far as samples may lie beyond the faces.
    fn images(&self, point: DVec3) -> impl Iterator<Item = DVec3> {
        let length = self.period.length.as_dvec3();
        let steps = [0, 1, 2].map(|axis| i32::from(self.period.faces(axis).is_some()));
        let along = move |axis: usize| -steps[axis]..=steps[axis];
        along(2).flat_map(move |z| {
            along(1).flat_map(move |y| {
                along(0).map(move |x| point + DVec3::new(x.into(), y.into(), z.into()) * length)
            })
        })
    }
}
