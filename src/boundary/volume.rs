//! The volume that a boundary particle stands for: `V_b = 1/Σ_k W_bk` over the boundary, itself included (Akinci et al.
//! 2012, eq. 4). It is smaller where the sampling is denser, so edges and overlapping shapes push no harder. With
//! direct forcing it is scaled so that a sample in a flat layer has the volume m/ρ0 of a fluid particle.

use glam::Vec4;
use rayon::prelude::*;

use crate::{
    index::SpatialIndex,
    kernel::Kernel,
    neighbours::{Recomputed, Search},
    pairs::{self, Pair, PairSum, Points, Source},
    scene::{BoundaryHandling, Period, Scene},
    simd::{Simd, Vectorised},
    state::{CHUNK, Execution, Material, SENTINEL},
};

/// How the volumes of a scene's boundary particles are found.
#[derive(Debug, Clone, Copy)]
pub struct VolumeRule {
    kernel: Kernel,
    period: Period,
    /// With direct forcing: the volume of a fluid particle \[m³; m² in 2-D], and the sum of a flat layer's kernels.
    layer: Option<[f32; 2]>,
}

impl VolumeRule {
    /// The rule of a scene.
    pub fn new(scene: &Scene) -> Self {
        let kernel = Kernel::of(scene);
        let layer = match scene.boundary_handling() {
            BoundaryHandling::Akinci | BoundaryHandling::Extrapolated => None,
            // Less only where layers of several walls overlap.
            BoundaryHandling::Layers => {
                let material = Material::new(scene);
                let particle = material.particle_mass / material.rest_density;
                Some([particle, 1.0 / particle])
            }
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
        let period = scene.period();
        Self {
            kernel,
            period,
            layer,
        }
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
            Points {
                fluid: packed,
                boundary: &[SENTINEL],
                kernel: &pass.kernel,
                period: self.period,
            },
            &mut volumes,
            execution,
        );
        self.bounded(&mut volumes);
        volumes
    }

    /// The same for some of these particles, by their rows.
    pub fn of_rows(
        &self,
        index: &dyn SpatialIndex,
        packed: &[Vec4],
        rows: &[u32],
        execution: &Execution,
    ) -> Vec<f32> {
        let search = Search::among_themselves(index, &packed[..packed.len() - 1]);
        let mut volumes = vec![0.0; rows.len()];
        execution.install(|| {
            let chunks = volumes.par_chunks_mut(CHUNK).zip(rows.par_chunks(CHUNK));
            chunks.for_each(|(volumes, rows)| {
                execution.instruction_set.dispatch(SomeRows {
                    kernel: &self.kernel,
                    period: self.period,
                    search,
                    rows,
                    volumes,
                });
            });
        });
        self.bounded(&mut volumes);
        volumes
    }

    fn bounded(&self, volumes: &mut [f32]) {
        if let Some([particle, layer]) = self.layer {
            for volume in volumes {
                // Not more at a border, where samples are fewer.
                *volume = particle * (*volume * layer).min(1.0);
            }
        }
    }
}

/// Rows whose volumes are summed one after the other.
struct SomeRows<'a> {
    kernel: &'a Kernel,
    period: Period,
    search: Search<'a>,
    rows: &'a [u32],
    volumes: &'a mut [f32],
}

impl Vectorised for SomeRows<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let points = self.search.points;
        let mut near = Recomputed::new(self.search);
        for (&row, volume) in self.rows.iter().zip(self.volumes) {
            let place = points[row as usize].truncate();
            let value = |&other: &u32| {
                let offset = points[other as usize].truncate() - place;
                self.kernel.value(self.period.nearest(offset).length())
            };
            let others: f32 = near.of(simd, row as usize).iter().map(value).sum();
            *volume = 1.0 / (self.kernel.value(0.0) + others);
        }
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
        *sum = simd.add(*sum, self.kernel.w(simd, pair.r2));
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sum: Self::Sums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        1.0 / (self.kernel.normalisation * (1.0 + simd.sum(sum)))
    }
}
