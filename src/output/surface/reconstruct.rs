//! From particles to the surface around them, by `splashsurf_lib`: marching cubes over the sum of kernels, cleaned and
//! smoothed with weights that keep drops (Löschner, Böttcher, Jeske and Bender, "Weighted Laplacian smoothing for
//! surface reconstruction of particle-based fluids", 2023).

use glam::Vec3;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use splashsurf_lib::mesh::{Mesh3d as _, TriMesh3d};
use splashsurf_lib::nalgebra::Vector3;
use splashsurf_lib::postprocessing as library;
use splashsurf_lib::sph_interpolation::SphInterpolator;
use splashsurf_lib::{
    GridDecompositionParameters, Parameters, SpatialDecomposition, SurfaceReconstruction,
    reconstruct_surface,
};

use super::SurfaceMesh;
use super::motion::Motion;
use crate::output::Frame;

/// Weighted number of neighbours from which a vertex is smoothed fully; the library's, for its smoothing length.
const ALL_NEIGHBOURS: f32 = 13.0;
/// Passes in which vertices beside one corner of a cube are joined.
const CLEANING_PASSES: usize = 5;

/// How a surface is found. The defaults are those that the library recommends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfacing {
    /// Radius of a particle \[m]: half of its spacing.
    pub particle_radius: f32,
    /// Smoothing length \[particle radii]; the kernel reaches two of them.
    pub smoothing_length: f32,
    /// Edge of a cube of the grid on which the surface is found \[particle radii].
    pub cube_size: f32,
    /// Part of the rest density at which the surface is.
    pub threshold: f32,
    /// Passes that smooth the vertices; 0 leaves the surface of marching cubes as it is.
    pub smoothing: usize,
    /// Passes that smooth the normals.
    pub normal_smoothing: usize,
}

/// Why a surface could not be found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A parameter is out of its range.
    #[error("{name} of a surface is {value} and must be {allowed}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// Its value.
        value: f32,
        /// What would be right.
        allowed: &'static str,
    },
    /// The particles are too far apart for a grid around all of them, or there are too many.
    #[error(
        "no grid of cubes of {cube_size} m fits around the particles: {reason}; make the cubes larger, or remove what \
         flies away (`outside: Remove`)"
    )]
    Grid {
        /// \[m]
        cube_size: f32,
        /// The library's reason.
        reason: String,
    },
    /// The operating system refused a thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] rayon::ThreadPoolBuildError),
}

type Reconstruction = SurfaceReconstruction<i64, f32>;

impl Surfacing {
    /// The recommended way for particles of this spacing \[m].
    pub fn for_spacing(spacing: f32) -> Self {
        Self {
            particle_radius: 0.5 * spacing,
            smoothing_length: 2.0,
            cube_size: 0.5,
            threshold: 0.6,
            smoothing: 25,
            normal_smoothing: 10,
        }
    }

    /// Whether all parameters are possible.
    ///
    /// # Errors
    /// The first that is not.
    pub fn check(&self) -> Result<(), SurfaceError> {
        for (name, value, most, allowed) in [
            (
                "the particle radius",
                self.particle_radius,
                f32::MAX,
                "above 0",
            ),
            (
                "the smoothing length",
                self.smoothing_length,
                10.0,
                "above 0, at most 10 radii",
            ),
            (
                "the cube size",
                self.cube_size,
                10.0,
                "above 0, at most 10 radii",
            ),
            ("the threshold", self.threshold, 0.99, "above 0 and below 1"),
        ] {
            if !(value > 0.0 && value <= most) {
                return Err(SurfaceError::Parameter {
                    name,
                    value,
                    allowed,
                });
            }
        }
        Ok(())
    }

    /// The surface of a frame's particles; those without a finite position are left out. Without particles it is empty.
    ///
    /// One thread computes it, so that a frame has one surface: with several, the library adds and joins in an order
    /// that differs from run to run. Several frames at the same time occupy several threads.
    ///
    /// # Errors
    /// See [`SurfaceError`].
    pub fn of(&self, frame: &Frame) -> Result<SurfaceMesh, SurfaceError> {
        self.check()?;
        let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
        pool.install(|| self.of_particles(frame))
    }

    fn of_particles(&self, frame: &Frame) -> Result<SurfaceMesh, SurfaceError> {
        let rows = frame.positions.iter().zip(&frame.velocities);
        let finite = rows.filter(|(position, _)| position.is_finite());
        let (positions, velocities): (Vec<Vec3>, Vec<Vec3>) = finite.unzip();
        let mut surface = SurfaceMesh {
            step: frame.step,
            time: frame.time,
            ..SurfaceMesh::default()
        };
        if positions.is_empty() {
            return Ok(surface);
        }
        let points: Vec<Vector3<f32>> = positions.iter().map(|p| to_library(*p)).collect();
        let parameters = self.parameters();
        let found: Result<Reconstruction, _> = reconstruct_surface(&points, &parameters);
        let mut found = found.map_err(|error| SurfaceError::Grid {
            cube_size: parameters.cube_size,
            reason: error.to_string(),
        })?;
        let mut mesh = std::mem::take(&mut found.mesh);
        let normals = self.finish(&mut mesh, &found, &points, &parameters);
        surface.positions = mesh.vertices.iter().map(from_library).collect();
        surface.normals = normals;
        let corners = |triangle: &[usize; 3]| triangle.map(|corner| corner as u32);
        surface.triangles = mesh.triangles.iter().map(corners).collect();
        let reach = f64::from(parameters.compact_support_radius);
        let motion = Motion::new(&positions, &velocities, reach);
        surface.velocities = motion.at_all(&surface.positions);
        Ok(surface)
    }

    fn parameters(&self) -> Parameters<f32> {
        let radius = self.particle_radius;
        let mut parameters = Parameters::new(
            radius,
            2.0 * self.smoothing_length * radius,
            self.cube_size * radius,
        );
        parameters.iso_surface_threshold = self.threshold;
        parameters.global_neighborhood_list = true;
        // Always in blocks of cubes: the other way of the library fills hash maps with all of them.
        parameters.spatial_decomposition =
            SpatialDecomposition::UniformGrid(GridDecompositionParameters {
                auto_disable: false,
                ..GridDecompositionParameters::default()
            });
        parameters
    }

    /// Cleans and smooths the mesh; returns its normals.
    fn finish(
        &self,
        mesh: &mut TriMesh3d<f32>,
        found: &Reconstruction,
        points: &[Vector3<f32>],
        parameters: &Parameters<f32>,
    ) -> Vec<Vec3> {
        let mut connected = None;
        if self.smoothing > 0 {
            // Small triangles at corners of cubes would become pimples.
            library::marching_cubes_cleanup(mesh, &found.grid, None, CLEANING_PASSES, false);
            connected = Some(library::decimation(mesh, false));
            let weights = weights(mesh, found, points, parameters);
            let neighbours = connected.as_deref().unwrap_or_default();
            library::par_laplacian_smoothing_inplace(
                mesh,
                neighbours,
                self.smoothing,
                1.0,
                &weights,
            );
        }
        let neighbours = connected.unwrap_or_else(|| mesh.vertex_vertex_connectivity());
        let mut normals: Vec<Vector3<f32>> = (mesh
            .vertex_normals()
            .into_iter()
            .map(|normal| normal.into_inner()))
        .collect();
        library::par_laplacian_smoothing_normals_inplace(
            &mut normals,
            &neighbours,
            self.normal_smoothing,
        );
        // A needle's normal may be 0 / 0.
        let unit = |normal: &Vector3<f32>| from_library(normal).normalize_or(Vec3::Y);
        normals.iter().map(unit).collect()
    }
}

/// How much each vertex may be smoothed, 0 to 1: less where particles have few neighbours, so that drops stay.
fn weights(
    mesh: &TriMesh3d<f32>,
    found: &Reconstruction,
    points: &[Vector3<f32>],
    parameters: &Parameters<f32>,
) -> Vec<f32> {
    let (Some(densities), Some(lists)) = (&found.particle_densities, &found.particle_neighbors)
    else {
        return vec![1.0; mesh.vertices.len()];
    };
    let reach2 = parameters.compact_support_radius.powi(2);
    let weighted: Vec<f32> = (points.par_iter().zip(lists))
        .map(|(at, list)| {
            let near = list
                .iter()
                .map(|j| (at - points[*j]).norm_squared() / reach2);
            near.map(|far| 1.0 - far.clamp(0.0, 1.0)).sum()
        })
        .collect();
    let volume = (2.0 * parameters.particle_radius).powi(3);
    let interpolator = SphInterpolator::new(
        points,
        densities,
        volume * parameters.rest_density,
        parameters.compact_support_radius,
    );
    let of_vertices = interpolator.interpolate_scalar_quantity(&weighted, &mesh.vertices, true);
    let weight = |neighbours: f32| {
        // No particle in reach gives 0 / 0, and no weight.
        let x = (neighbours.max(0.0) / ALL_NEIGHBOURS).min(1.0);
        x.powi(3) * (x * (6.0 * x - 15.0) + 10.0)
    };
    of_vertices.into_iter().map(weight).collect()
}

fn to_library(vector: Vec3) -> Vector3<f32> {
    Vector3::from(vector.to_array())
}

fn from_library(vector: &Vector3<f32>) -> Vec3 {
    Vec3::new(vector.x, vector.y, vector.z)
}
