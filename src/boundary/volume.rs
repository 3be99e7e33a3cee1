//! The volume that a boundary particle stands for: `V_b = 1/Σ_k W_bk` over the boundary, itself included (Akinci et al.
//! 2012, eq. 4). It is smaller where the sampling is denser, so edges and overlapping shapes push no harder. With
//! direct forcing it is scaled so that a sample in a flat layer has the volume m/ρ0 of a fluid particle.

use glam::Vec4;

use crate::{
    index::SpatialIndex,
    kernel::Kernel,
    neighbours::Search,
    pairs::{self, Pair, PairSum, Places, Source},
    scene::{BoundaryHandling, Scene},
    simd::Simd,
    state::{Execution, Material, SENTINEL},
};

/// How the volumes of a scene's boundary particles are found.
#[derive(Debug, Clone, Copy)]
pub struct VolumeRule {
    kernel: Kernel,
    /// With direct forcing: the volume of a fluid particle \[m³; m² in 2-D], and the sum of a flat layer's kernels.
    layer: Option<[f32; 2]>,
}

impl VolumeRule {
    /// The rule of a scene.
    pub fn new(scene: &Scene) -> Self {
        let kernel = Kernel::of(scene);
        let layer = match scene.boundary_handling {
            BoundaryHandling::Akinci => None,
            BoundaryHandling::DirectForcing(_) => {
                let material = Material::new(scene);
                let layer: f32 = kernel
                    .lattice(scene.dimension, scene.spacing)
                    .filter(|x| x.y.abs() < 0.5 * scene.spacing)
                    .map(|x| kernel.value(x.length()))
                    .sum();
                Some([material.particle_mass / material.rest_density, layer])
            }
        };
        Self { kernel, layer }
    }

    /// Volumes \[m³; m² in 2-D] of the particles of `index`, at `packed` without its sentinel.
    pub fn volumes(
        &self,
        index: &dyn SpatialIndex,
        packed: &[Vec4],
        execution: &Execution,
    ) -> Vec<f32> {
        let pass = BoundaryVolumeSum {
            kernel: self.kernel,
        };
        let points = &packed[..packed.len() - 1];
        let search = Search {
            of: index,
            points,
            among: index,
            among_points: points,
            same: true,
        };
        let mut volumes = vec![0.0; points.len()];
        pairs::sum(
            &pass,
            Source::Recomputed(search, None),
            Places {
                fluid: packed,
                boundary: &[SENTINEL],
                kernel: &pass.kernel,
            },
            &mut volumes,
            execution,
        );
        if let Some([particle, layer]) = self.layer {
            for volume in &mut volumes {
                // Not more at a border, where samples are fewer.
                *volume = particle * (*volume * layer).min(1.0);
            }
        }
        volumes
    }
}

#[derive(Clone, Copy)]
struct BoundaryVolumeSum {
    kernel: Kernel,
}

impl PairSum for BoundaryVolumeSum {
    type Sums<S: Simd> = S::F;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> Self::Sums<S> {
        simd.splat(0.0)
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sum: &mut Self::Sums<S>) {
        *sum = simd.add(*sum, self.kernel.shape(simd, pair.distance));
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sum: Self::Sums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        1.0 / (self.kernel.normalisation * (1.0 + simd.sum(sum)))
    }
}
