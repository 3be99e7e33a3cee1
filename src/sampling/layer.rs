//! Depth of the layer of samples behind a wall, and its effect on the lattice beside it.
//!
//! The depth is chosen so that fluid which fills a tank starts at rest. A sample of one layer represents about 1.4
//! times the volume of a fluid particle. At half a spacing behind the face, where a next row of fluid would be, the
//! layer would give a lattice at the wall 6 % more than its rest density (12 % in an edge) and push it away. At
//! [`layer_depth`] it adds exactly what the missing half of the lattice would: 0.6 spacings at the default support.
//!
//! Option 2 was a layer at half a spacing with volumes scaled by 0.70 (γ of Band et al. 2018). The lattice is at rest,
//! too, but the wall pushes so much more weakly that the lowest layers of still water first collapse onto it.

use glam::Vec3;

use crate::{
    kernel::Kernel,
    lattice::{BesideWall, Lattice},
    scene::{BoundaryHandling, Dimension, Scene},
    state::Material,
};

/// Depth of the layer of samples behind the face of a wall \[m]: a lattice that starts half a spacing in front of the
/// face then has its rest density. With direct forcing it is half a spacing: its frozen particles continue the lattice.
pub fn layer_depth(scene: &Scene) -> f32 {
    if !matches!(
        scene.boundary_handling(),
        BoundaryHandling::Akinci | BoundaryHandling::Extrapolated
    ) {
        return 0.5 * scene.spacing;
    }
    let material = Material::new(scene);
    let (kernel, dx) = (material.kernel, scene.spacing);
    let sum = |layer: &dyn Fn(Vec3) -> bool, distance: f32| -> f32 {
        let lattice = kernel.lattice(scene.dimension, dx).filter(|x| layer(*x));
        lattice
            .map(|x| kernel.value(x.with_y(0.0).length().hypot(distance)))
            .sum()
    };
    let sheet = |x: Vec3| x.y.abs() < 0.5 * dx;
    let missing: f32 = {
        let behind = kernel
            .lattice(scene.dimension, dx)
            .filter(|x| x.y < -0.5 * dx);
        behind
            .map(|x| material.particle_mass * kernel.value(x.length()))
            .sum()
    };
    let volume = 1.0 / sum(&sheet, 0.0);
    // The contribution of the layer decreases with its distance: bisection.
    let (mut near, mut far) = (0.0, kernel.support_radius);
    for _ in 0..40 {
        let middle = 0.5 * (near + far);
        if material.rest_density * volume * sum(&sheet, middle) > missing {
            near = middle;
        } else {
            far = middle;
        }
    }
    near - 0.5 * dx
}

/// Depths of all layers of samples behind the face of a wall \[m], the nearest first: one, or as many as the kernel of
/// a particle at the face reaches.
pub fn layer_depths(scene: &Scene) -> impl Iterator<Item = f32> + use<> {
    let layers = match scene.boundary_handling() {
        BoundaryHandling::Akinci
        | BoundaryHandling::Extrapolated
        | BoundaryHandling::DirectForcing(_) => 1,
        BoundaryHandling::Layers => (scene.support() - 0.5).ceil().max(1.0) as u32,
    };
    let (first, spacing) = (layer_depth(scene), scene.spacing);
    (0..layers).map(move |layer| first + layer as f32 * spacing)
}

/// Whether a layer of samples behind the faces of a box has room in it.
pub(super) fn has_room(size: Vec3, depth: f32, dimension: Dimension) -> bool {
    let thinnest = match dimension {
        Dimension::Two => size.truncate().min_element(),
        Dimension::Three => size.min_element(),
    };
    depth <= 0.5 * thinnest
}

/// Radius of a layer of samples in a ball, if there is room for it. The first has at least half of the ball's.
pub(super) fn radius_of_layer(radius: f32, depth: f32, is_first: bool) -> Option<f32> {
    if is_first {
        Some((radius - depth).max(0.5 * radius))
    } else {
        (depth <= radius).then_some(radius - depth)
    }
}

/// The factors with which the layer of samples acts on a lattice beside it as a continued lattice would.
pub fn beside_wall(scene: &Scene) -> BesideWall {
    if scene.boundary_handling() == BoundaryHandling::Layers {
        // A sample has the pressure of the particle, and its velocity across the face with the opposite sign.
        return BesideWall {
            push: 2.0,
            slide: 0.0,
        };
    }
    let (distance, volume) = layer_in_spacings(scene);
    Lattice::of(scene).beside_wall(distance, volume)
}

/// What makes the viscosity of the layers of samples act likewise on a lattice that is sheared along it \[-].
pub fn grip_of_wall(scene: &Scene) -> f32 {
    let (_, volume) = layer_in_spacings(scene);
    let depths = layer_depths(scene).map(|depth| 0.5 + f64::from(depth / scene.spacing));
    Lattice::of(scene).grip_of_wall(&depths.collect::<Vec<_>>(), volume) as f32
}

/// Distance of the layer from the first row of a lattice, and what a sample of it stands for, in spacings.
fn layer_in_spacings(scene: &Scene) -> (f64, f64) {
    let kernel = Kernel::new(scene.kernel(), scene.dimension, scene.support());
    let layer = || kernel.lattice(scene.dimension, 1.0).filter(|x| x.y == 0.0);
    let in_layer: f32 = layer().map(|x| kernel.value(x.length())).sum();
    let volume = match scene.boundary_handling() {
        BoundaryHandling::Akinci | BoundaryHandling::Extrapolated => 1.0 / in_layer,
        // The volume of a fluid particle.
        BoundaryHandling::DirectForcing(_) | BoundaryHandling::Layers => {
            let lattice = kernel.lattice(scene.dimension, 1.0);
            1.0 / lattice.map(|x| kernel.value(x.length())).sum::<f32>()
        }
    };
    let distance = 0.5 + layer_depth(scene) / scene.spacing;
    (f64::from(distance), f64::from(volume))
}
