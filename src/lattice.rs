//! What a method may count on where particles lie on their lattice at rest: waves on it, and walls beside it.
//!
//! A pressure method and a time step are stable on a fluid only if they are on the waves of its lattice. Under a
//! pressure p a particle that is displaced by u feels `−2 p/ρ² Σ_j m H_ij (u_i − u_j)`, H the Hessian of the kernel:
//! neighbouring rows swing against each other with `ω² = s p/(ρ dx²)`, s about 8 at a support of 2. Semi-implicit Euler
//! follows them up to `ω dt = 2`; beyond it rows pair up within a few steps, whatever the pressure method. The analysis
//! is von Neumann's, as in Violeau & Leroy 2014 for a state equation.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::{
    kernel::Kernel,
    scene::{Dimension, KernelFunction, Scene},
};

/// Neighbours of a particle on the lattice, and what the kernel says of them. Lengths in spacings.
#[derive(Debug, Clone)]
pub struct Lattice {
    dimension: Dimension,
    /// The kernel, lengths in spacings.
    kernel: Kernel,
    pairs: Vec<LatticePair>,
    /// Kernel sum, the particle itself included.
    density: f64,
}

#[derive(Debug, Clone, Copy)]
struct LatticePair {
    x: DVec3,
    value: f64,
    /// W′(r)/r, negative.
    slope: f64,
    /// W″(r).
    curvature: f64,
}

/// Steps along each axis of the wave vectors that are tried, from 0 to π.
const WAVES: u32 = 12;

impl Lattice {
    /// The lattice of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self::new(scene.kernel(), scene.dimension, scene.support())
    }

    /// The lattice for a kernel with a support in spacings.
    pub fn new(function: KernelFunction, dimension: Dimension, support: f32) -> Self {
        let kernel = Kernel::new(function, dimension, support);
        let h = f64::from(support);
        let density = kernel
            .lattice(dimension, 1.0)
            .map(|x| f64::from(kernel.value(x.length())))
            .sum();
        let sigma = f64::from(kernel.normalisation);
        let pairs = kernel
            .lattice(dimension, 1.0)
            .filter(|x| x.length() > 0.5)
            .map(|x| {
                let (x, r) = (x.as_dvec3(), f64::from(x.length()));
                let [value, first, second] = function.derivatives(r / h);
                LatticePair {
                    x,
                    value: sigma * value,
                    slope: sigma / h * first / r,
                    curvature: sigma / (h * h) * second,
                }
            })
            .collect();
        Self {
            dimension,
            kernel,
            pairs,
            density,
        }
    }

    /// Sum of the kernel over the lattice, the particle itself included \[spacing⁻³; spacing⁻² in 2-D].
    pub(crate) fn density(&self) -> f64 {
        self.density
    }

    /// Largest eigenvalue of the pressure system on this lattice, over its diagonal \[-]: `|Σ_j ∇W_ij sin(k·x_ij)|²`
    /// over `Σ_j |∇W_ij|²`, and with a stabilisation κ that share of the compact Laplacian in its place. A Jacobi
    /// iteration is stable for relaxations below 2 over it, with momentum below 4/3 over it.
    pub fn largest_eigenvalue(&self, stabilisation: f64) -> f64 {
        let squares: f64 = (self.pairs.iter())
            .map(|pair| pair.slope * pair.slope * pair.x.length_squared())
            .sum();
        let compact = |weight: &dyn Fn(&LatticePair) -> f64| -> f64 {
            let slopes = self.pairs.iter().map(|pair| -pair.slope * weight(pair));
            2.0 * self.density * slopes.sum::<f64>()
        };
        let mix = |wide: f64, compact: f64| (1.0 - stabilisation) * wide + stabilisation * compact;
        let diagonal = mix(squares, compact(&|_| 1.0));
        self.over_waves(|k| {
            let sum: DVec3 = (self.pairs.iter())
                .map(|pair| pair.slope * k.dot(pair.x).sin() * pair.x)
                .sum();
            let neighbours = compact(&|pair| 1.0 - k.dot(pair.x).cos());
            mix(sum.length_squared(), neighbours) / diagonal
        })
    }

    /// Longest stable time step under a pressure p, as the number of spacings that `sqrt(p/ρ)` covers in it \[-]: 0.71
    /// in 2-D and 0.68 in 3-D at a support of 2.
    pub fn pressure_step(&self) -> f64 {
        let stiffness = self.over_waves(|k| {
            let matrix = self.pairs.iter().fold(DMat3::ZERO, |sum, pair| {
                let direction = pair.x.normalize();
                let along = outer(direction);
                let mut hessian = pair.curvature * along + pair.slope * (DMat3::IDENTITY - along);
                if self.dimension == Dimension::Two {
                    hessian.z_axis = DVec3::ZERO;
                }
                sum + (1.0 - k.dot(pair.x).cos()) * hessian
            });
            2.0 / self.density * largest_symmetric_eigenvalue(matrix)
        });
        2.0 / stiffness.sqrt()
    }

    /// Viscosity that the sums of [`viscosity`](crate::force) give a long shear wave along an axis of this lattice,
    /// over the nominal one \[-]: narrow kernels leave much of it out.
    pub fn shear_viscosity(&self) -> f64 {
        let d = f64::from(u8::from(self.dimension));
        let least = 0.01 * f64::from(self.kernel.support_radius).powi(2);
        let sum: f64 = (self.pairs.iter())
            .map(|pair| {
                let strength = -pair.slope / (pair.x.length_squared() + least);
                strength * (pair.x.x * pair.x.y).powi(2)
            })
            .sum();
        (d + 2.0) / self.density * sum
    }

    /// Longest stable time step with an equation of state, as the number of spacings that sound covers in it \[-]: its
    /// waves have `ω = c |Σ_j V ∇W_ij sin(k·x_ij)|`, which semi-implicit Euler follows up to `ω dt = 2`. With many
    /// neighbours it is 0.94 support radii in 2-D and 0.914 in 3-D for the cubic spline.
    pub fn sound_step(&self) -> f64 {
        let fastest = self.over_waves(|k| {
            let sum: DVec3 = (self.pairs.iter())
                .map(|pair| pair.slope * k.dot(pair.x).sin() * pair.x)
                .sum();
            sum.length() / self.density
        });
        2.0 / fastest
    }

    /// Longest stable time step under a kinematic viscosity ν, times ν and over the square of the spacing \[-]. The
    /// operator is that of [`viscosity`](crate::force): its short waves decay faster than `ν k²` says, and the faster
    /// the narrower the kernel is within its support.
    pub fn viscous_step(&self) -> f64 {
        let d = f64::from(u8::from(self.dimension));
        let least = 0.01 * f64::from(self.kernel.support_radius).powi(2);
        let fastest = self.over_waves(|k| {
            let matrix = self.pairs.iter().fold(DMat3::ZERO, |sum, pair| {
                let strength = -pair.slope / (pair.x.length_squared() + least);
                sum + (1.0 - k.dot(pair.x).cos()) * strength * outer(pair.x)
            });
            2.0 * (d + 2.0) / self.density * largest_symmetric_eigenvalue(matrix)
        });
        2.0 / fastest
    }

    /// The largest value over the wave vectors of the lattice.
    fn over_waves(&self, value: impl Fn(DVec3) -> f64) -> f64 {
        let deep = match self.dimension {
            Dimension::Two => 0,
            Dimension::Three => WAVES,
        };
        let component = |n: u32| PI * f64::from(n) / f64::from(WAVES);
        let mut largest = 0.0_f64;
        for z in 0..=deep {
            for y in 0..=WAVES {
                for x in 0..=WAVES {
                    largest =
                        largest.max(value(DVec3::new(component(x), component(y), component(z))));
                }
            }
        }
        largest
    }

    /// What makes a layer of samples act as the lattice behind it would (see [`BesideWall`]). The layer is as dense as
    /// a row of the lattice, its samples are `distance` from the first row, each stands for `volume` (in spacings).
    pub fn beside_wall(&self, distance: f64, volume: f64) -> BesideWall {
        let kernel = self.kernel;
        let rows = 0..(kernel.support_radius.ceil() as u32 - 1).max(1);
        let behind = |row: u32| {
            let border = -f64::from(row) - 0.5;
            self.pairs.iter().filter(move |pair| pair.x.y < border)
        };
        let fluid: f64 = (rows.clone().flat_map(behind))
            .map(|pair| pair.slope * pair.x.y / self.density)
            .sum();
        let layer = |row: u32| {
            let height = (distance + f64::from(row)) as f32;
            let points = kernel.lattice(self.dimension, 1.0);
            points.filter(|x| x.y == 0.0).map(move |x| x.with_y(height))
        };
        let wall: f64 = (rows.flat_map(layer))
            .map(|x| -volume * f64::from(kernel.gradient(x).y))
            .sum();
        let share = behind(0).map(|pair| pair.value).sum::<f64>() / self.density;
        let moment = |pair: &LatticePair| pair.slope * pair.x.x * pair.x.x;
        let missing =
            behind(0).map(moment).sum::<f64>() / self.pairs.iter().map(moment).sum::<f64>();
        BesideWall {
            push: (2.0 * fluid / wall) as f32,
            slide: (missing / share) as f32,
        }
    }
}

impl Lattice {
    /// What makes the viscosity of layers of samples hold a lattice that is sheared along it as the lattice behind it
    /// would \[-]: the sum over the rows that reach the layer, so that the stress at the wall is that within the
    /// lattice. The layers are as [`beside_wall`](Self::beside_wall) has one.
    pub fn grip_of_wall(&self, distances: &[f64], volume: f64) -> f64 {
        let least = 0.01 * f64::from(self.kernel.support_radius).powi(2);
        let rows = 0..self.kernel.support_radius.ceil() as u32;
        let (mut lattice, mut layer) = (0.0, 0.0);
        for row in rows {
            let behind = |pair: &&LatticePair| pair.x.y > f64::from(row) + 0.5;
            for pair in self.pairs.iter().filter(behind) {
                let part = pair.x.x * pair.x.x / (pair.x.length_squared() + least);
                lattice += pair.x.y * part * pair.slope / self.density;
            }
            for height in distances.iter().map(|distance| distance + f64::from(row)) {
                let points = self.kernel.lattice(self.dimension, 1.0);
                for x in points.filter(|x| x.y == 0.0) {
                    let x = x.with_y(height as f32);
                    let along = f64::from(self.kernel.gradient(x).dot(x));
                    layer += volume * height * along / (f64::from(x.length_squared()) + least);
                }
            }
        }
        lattice / layer
    }
}

/// What makes a wall of samples act on a lattice beside it as a lattice that goes on would.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BesideWall {
    /// Factor of the gradients of the walls' kernels \[-]. With it a constant pressure exerts no force beside a wall:
    /// what the wall pushes, the fluid pushes back.
    pub push: f32,
    /// Part of a particle's force along the wall that is missing, for each part of its kernel that lies in the wall
    /// \[-].
    pub slide: f32,
}

/// Dyadic square.
fn outer(x: DVec3) -> DMat3 {
    DMat3::from_cols(x.x * x, x.y * x, x.z * x)
}

/// By the trigonometric solution of the characteristic equation.
fn largest_symmetric_eigenvalue(matrix: DMat3) -> f64 {
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let mean = trace / 3.0;
    let deviation = matrix - DMat3::from_diagonal(DVec3::splat(mean));
    let square: f64 = [deviation.x_axis, deviation.y_axis, deviation.z_axis]
        .iter()
        .map(|axis| axis.length_squared())
        .sum();
    let radius = (square / 6.0).sqrt();
    if radius == 0.0 {
        return mean;
    }
    let half_determinant = (deviation.determinant() / (2.0 * radius.powi(3))).clamp(-1.0, 1.0);
    mean + 2.0 * radius * (half_determinant.acos() / 3.0).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against an analysis of the same lattices in numpy.
    #[test]
    fn waves_have_the_eigenvalues_and_frequencies_of_an_independent_analysis() {
        use Dimension::{Three, Two};
        use KernelFunction::{CubicSpline, QuinticSpline, WendlandC2, WendlandC4};
        for (function, dimension, support, eigenvalue, step, viscous) in [
            (CubicSpline, Two, 1.5, 1.998, 0.559, 0.0812),
            (CubicSpline, Two, 2.0, 2.147, 0.708, 0.0382),
            (CubicSpline, Two, 2.4, 2.519, 1.114, 0.0333),
            (CubicSpline, Two, 2.6, 2.876, 1.202, 0.0331),
            (CubicSpline, Three, 2.0, 2.818, 0.685, 0.0351),
            (CubicSpline, Three, 3.0, 7.467, 1.408, 0.0346),
            (WendlandC2, Two, 2.6, 2.593, 1.116, 0.0308),
            (WendlandC2, Three, 3.0, 6.237, 1.287, 0.0301),
            (WendlandC4, Two, 3.0, 2.585, 1.113, 0.0231),
            (WendlandC4, Three, 3.0, 4.215, 1.090, 0.0223),
            (QuinticSpline, Two, 3.0, 2.590, 1.129, 0.0229),
            (QuinticSpline, Three, 3.0, 4.237, 1.095, 0.0222),
        ] {
            let lattice = Lattice::new(function, dimension, support);
            // A compact Laplacian has the shortest waves: less than twice its diagonal, more than that.
            let compact = lattice.largest_eigenvalue(1.0);
            assert!(compact > 1.0 && compact < 2.0, "{function:?} {compact}");
            let viscous_step = lattice.viscous_step() / f64::from(support * support);
            let found = [
                lattice.largest_eigenvalue(0.0),
                lattice.pressure_step(),
                viscous_step,
            ];
            for (found, known) in found.into_iter().zip([eigenvalue, step, viscous]) {
                assert!(
                    (found / known - 1.0).abs() < 0.02,
                    "{function:?} {dimension:?} {support}: {found} for {known}"
                );
            }
        }
    }
}
