//! Restores a world from a checkpoint.

use std::collections::BTreeSet;
use std::{io::Read, ops::Range};

use bevy_ecs::prelude::*;
use serde::de::DeserializeOwned;

use super::{
    error::CheckpointError,
    file::{Checkpoint, SCENE},
    save::{
        COLUMN, FILES, KEPT, NUMBERS, SAME_ROWS, STAGES, TABLES, WALLS, lasting, tables, walls,
    },
};
use crate::{
    boundary::moving,
    ranks,
    registry::{REMEMBERED, REORDERING},
    reorder,
    scene::Scene,
    state::{Execution, Rows, from_bytes, particle::gather_particles, seal::reseal},
    step::{Installed, NamedFile, between_steps},
};

/// Sets the state of a world that has the same scene to that of a checkpoint.
///
/// A fluid particle of the world whose number is in the checkpoint is kept, with the components that a host gave it.
/// Other fluid particles are despawned, and missing ones are spawned. The following steps are those of the original
/// run, bit for bit, with any number of threads. If a host has since given a component to some of the particles, they
/// are in another table of the ECS. Rows, and with them the terms of sums, then have another order, and steps agree to
/// rounding.
///
/// # Errors
/// If the file is incomplete or belongs to another run; the world is then unchanged. If the file is complete but a part
/// of it cannot be used; the world is then inconsistent and must be discarded.
pub fn restore(world: &mut World, reader: &mut impl Read) -> Result<(), CheckpointError> {
    Checkpoint::read(reader)?.restore(world)
}

impl Checkpoint {
    /// The scene of the run. Files that it names are taken relative to the working directory, as in the run.
    pub fn scene(&self) -> Result<Scene, CheckpointError> {
        let text = str::from_utf8(self.bytes(SCENE)?)
            .map_err(|error| CheckpointError::malformed(SCENE, error.to_string()))?;
        Ok(Scene::parse(text, "scene.ron", &[])?)
    }

    /// Gives a world the state, as [`restore`](fn@restore) does.
    pub fn restore(&self, world: &mut World) -> Result<(), CheckpointError> {
        let installed = world.get_resource::<Installed>();
        let installed = installed.ok_or(CheckpointError::NotInstalled)?.clone();
        between_steps(world)?;
        ranks::check_checkpoints(world, &installed.scene)?;
        self.check(world, &installed)?;
        let numbers: Vec<u32> = self.part(NUMBERS)?;
        let own = self.own_rows(world, numbers.len())?;
        let particles = gather_particles(world, &numbers[own.clone()]);
        let malformed = |name: &str| {
            let name = name.to_owned();
            move |reason: String| CheckpointError::malformed(name, reason)
        };
        for (name, lasting) in lasting(&installed) {
            let column = format!("{COLUMN}{name}");
            let bytes = self.bytes(&column)?;
            let loaded = match own.len() == numbers.len() {
                true => (lasting.load)(world, &particles, bytes),
                false => (lasting.part)(bytes, own.clone())
                    .and_then(|bytes| (lasting.load)(world, &particles, &bytes)),
            };
            loaded.map_err(malformed(&column))?;
            let kept = format!("{KEPT}{name}");
            if let Some(bytes) = self.find(&kept) {
                (lasting.load_kept)(world, bytes).map_err(malformed(&kept))?;
            }
        }
        for remembered in REMEMBERED {
            if !(remembered.is_present)(world) {
                continue;
            }
            let bytes = self.bytes(remembered.name)?;
            (remembered.load)(world, &particles, bytes).map_err(malformed(remembered.name))?;
        }
        moving::place_walls(world);
        reorder::arrange(world, &particles);
        // What stages left behind by row is of no use. Where none reads it, stages that run every n-th step are due as
        // in the run that went on.
        let same_rows = self.find(SAME_ROWS).is_some() && self.part::<bool>(SAME_ROWS)?;
        world.resource_mut::<Rows>().entities = if same_rows { particles } else { Vec::new() };
        reseal(world);
        Ok(())
    }

    /// The rows, of so many, that the world's rank owns.
    fn own_rows(&self, world: &mut World, rows: usize) -> Result<Range<usize>, CheckpointError> {
        let mut execution = world.resource_mut::<Execution>();
        let Some(mut team) = execution.team().cloned() else {
            return Ok(0..rows);
        };
        if team.all() as usize != rows {
            let other = format!("it has {rows} particles, this run {}", team.all());
            return Err(CheckpointError::OtherRun(other));
        }
        if self.find(REORDERING).is_some() {
            let (_, downwards): (bool, bool) = self.part(REORDERING)?;
            team.turn(downwards);
        }
        let range = team.range();
        execution.set_team(Some(team));
        Ok(range.start as usize..range.end as usize)
    }

    /// Refuses a checkpoint of another run.
    fn check(&self, world: &mut World, installed: &Installed) -> Result<(), CheckpointError> {
        let other = |what: String| Err(CheckpointError::OtherRun(what));
        if let Some(line) = difference(&self.scene()?, &installed.scene)? {
            return other(line);
        }
        // Checkpoints of older programs have no such part.
        if self.find(FILES).is_some() {
            let files: Vec<NamedFile> = self.part(FILES)?;
            let differs = |(saved, now): &(&NamedFile, &NamedFile)| saved != now;
            if let Some((_, (file, ..))) = files.iter().zip(&installed.files).find(differs) {
                return other(format!(
                    "the file {file} has changed since; put back the one that the run read, or start a new run"
                ));
            }
        }
        let stages: Vec<(String, u64)> = self.part(STAGES)?;
        if stages != installed.stages {
            return other("its steps have another order of stages".to_owned());
        }
        let (count, sum): (u64, u32) = self.part(WALLS)?;
        let present = walls(world);
        if present != (count, sum) {
            return other(format!(
                "its walls differ ({count} boundary particles instead of {} here): the file of a mesh has changed, or \
                 the program that samples it",
                present.0
            ));
        }
        if self.part::<u32>(TABLES)? != tables(world) {
            return other(
                "its walls move, or its forces act, by other figures: a file of a `Table` has changed".to_owned(),
            );
        }
        let mut known: BTreeSet<String> = [SCENE, FILES, STAGES, SAME_ROWS, WALLS, TABLES, NUMBERS]
            .map(str::to_owned)
            .into();
        known.extend(REMEMBERED.iter().map(|row| row.name.to_owned()));
        for (name, _) in lasting(installed) {
            known.extend([format!("{COLUMN}{name}"), format!("{KEPT}{name}")]);
        }
        match self.names().find(|name| !known.contains(*name)) {
            Some(name) => Err(CheckpointError::malformed(
                name,
                "this program does not know it",
            )),
            None => Ok(()),
        }
    }

    fn bytes(&self, name: &str) -> Result<&[u8], CheckpointError> {
        let missing = || CheckpointError::malformed(name, "it is not there");
        self.find(name).ok_or_else(missing)
    }

    fn part<T: DeserializeOwned>(&self, name: &str) -> Result<T, CheckpointError> {
        from_bytes(self.bytes(name)?).map_err(|reason| CheckpointError::malformed(name, reason))
    }
}

/// The first line in which two scenes differ, but for how long they run and what they write.
fn difference(saved: &Scene, installed: &Scene) -> Result<Option<String>, CheckpointError> {
    let text = |scene: &Scene| {
        let scene = Scene {
            duration: 1.0,
            output: crate::scene::Output::default(),
            ..scene.clone()
        };
        scene.to_ron()
    };
    let (saved, installed) = (text(saved)?, text(installed)?);
    let (mut saved, mut installed) = (saved.lines(), installed.lines());
    loop {
        match (saved.next(), installed.next()) {
            (None, None) => return Ok(None),
            (a, b) if a == b => {}
            (a, b) => {
                let [a, b] = [a, b].map(|line| line.unwrap_or("nothing").trim().to_owned());
                return Ok(Some(format!("its scene says `{a}`, this one `{b}`")));
            }
        }
    }
}
