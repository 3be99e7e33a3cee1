//! Particles in a CSV file: columns x, y, z \[units of the file], vx, vy, vz \[m/s]; z and the velocity may be absent.

use std::path::Path;

use glam::DVec3;

use super::particles::Particles;
use crate::measure::{Column, Columns};

pub(super) fn read(file: &Path) -> Result<Particles, String> {
    let wanted = [
        Column::named("x"),
        Column::named("y"),
        Column::optional("z"),
        Column::optional("vx"),
        Column::optional("vy"),
        Column::optional("vz"),
    ];
    let columns = Columns::load(file, wanted);
    let columns = columns.map_err(|error| format!("the particles {error}"))?;
    let rows = columns.rows.iter().map(|(_, row)| row);
    let velocities = rows.clone().map(|row| DVec3::new(row[3], row[4], row[5]));
    let moves = columns.present[3..].contains(&true);
    Ok(Particles {
        positions: rows.map(|row| DVec3::new(row[0], row[1], row[2])).collect(),
        velocities: moves.then(|| velocities.collect()),
    })
}
