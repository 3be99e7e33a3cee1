//! The boundary particles of a run, in a file of their own.

use std::path::Path;

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::OutputError;
use super::atomic::write_atomically;
use super::error::equal_columns;
use super::grid::{Array, Cells, Grid, vectors};
use crate::state::Clock;
use crate::state::particle::{Boundary, BoundaryNormal, BoundaryVolume, Position};

/// The boundary particles at one time, in the order of their tables. The columns have one row per particle.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WallFrame {
    /// Number of the step, 0 before the first.
    pub step: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// \[m]
    pub positions: Vec<Vec3>,
    /// Unit vectors from the solid into the fluid.
    pub normals: Vec<Vec3>,
    /// The part of space that each stands for \[m³; m² in 2-D].
    pub volumes: Vec<f32>,
}

impl WallFrame {
    /// Copies the boundary particles of a world in which a scene is installed, as of the last step.
    pub fn from_world(world: &mut World) -> Self {
        let clock = world.get_resource::<Clock>().copied().unwrap_or_default();
        let mut frame = Self {
            step: clock.step,
            time: clock.time,
            ..Self::default()
        };
        let mut particles =
            world.query_filtered::<(&Position, &BoundaryNormal, &BoundaryVolume), With<Boundary>>();
        let rows = particles.iter(world).len();
        frame.positions.reserve_exact(rows);
        frame.normals.reserve_exact(rows);
        frame.volumes.reserve_exact(rows);
        for (position, normal, volume) in particles.iter(world) {
            frame.positions.push(position.0);
            frame.normals.push(normal.0);
            frame.volumes.push(volume.0);
        }
        frame
    }

    /// Writes a VTK XML unstructured grid with one vertex per particle; data are base64, little endian.
    ///
    /// # Errors
    /// If the columns differ in length, there are more than 2³¹ − 1 particles, or the operating system reports an
    /// error.
    pub fn write_vtu(&self, path: &Path) -> Result<(), OutputError> {
        let rows = self.positions.len();
        let columns = [
            ("normal", self.normals.len()),
            ("volume", self.volumes.len()),
        ];
        equal_columns(rows, columns)?;
        if i32::try_from(rows).is_err() {
            return Err(OutputError::TooManyParticles { particles: rows });
        }
        let volumes = Array {
            name: "volume",
            kind: "Float32",
            components: 1,
            row_bytes: 4,
            push_row: Box::new(|row, out| out.extend_from_slice(&self.volumes[row].to_le_bytes())),
        };
        let grid = Grid {
            time: self.time,
            step: self.step,
            rows,
            points: vectors("position", &self.positions),
            cells: Cells::Vertices,
            data: vec![vectors("normal", &self.normals), volumes],
            shown_first: " Normals=\"normal\"",
        };
        write_atomically(path, |out| grid.write(out))
    }
}
