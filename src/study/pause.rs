//! What a study has done so far, so that an interrupted one goes on: finished blocks, and the state of every variant.
//!
//! It is saved after every turn. A study that resumes repeats the turn that was interrupted, and nothing before it.

use std::io::Read;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Block, Plan, StudyError, Table, measure::LastStep};
use crate::checkpoint::{Checkpoint, CheckpointError};

/// Name of the part that holds the progress.
const PROGRESS: &str = "study";

/// The progress of a study, with checkpoints of the case that is measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pause(Checkpoint);

/// What is finished.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Progress {
    /// The study and its scenes, as text.
    plan: String,
    /// Number of the case that is measured; the number of cases if all are.
    pub(super) case: usize,
    /// Turns that are finished in it, the warm-up included.
    pub(super) turns: u32,
    /// Blocks of all rows, and why a row ended early.
    rows: Vec<(Vec<Block>, Option<String>)>,
    /// The last step of each variant of the case; none if it failed.
    pub(super) last: Vec<Option<LastStep>>,
}

/// The study and its scenes.
fn text(plan: &Plan) -> Result<String, StudyError> {
    let unreadable = |error: String| StudyError::Resume(error);
    let mut text = ron::to_string(&plan.study).map_err(|error| unreadable(error.to_string()))?;
    let variants = plan.cases.iter().flat_map(|case| &case.variants);
    let starts = plan.cases.iter().filter_map(|case| case.start.as_ref());
    for scene in starts
        .map(|start| &start.0)
        .chain(variants.map(|variant| &variant.scene))
    {
        text.push('\n');
        text.push_str(
            &scene
                .to_ron()
                .map_err(|error| unreadable(error.to_string()))?,
        );
    }
    Ok(text)
}

impl Pause {
    /// The progress after a turn; none if a variant cannot be saved at this step.
    pub(super) fn of<'a>(
        plan: &Plan,
        table: &Table,
        (case, turns): (usize, u32),
        variants: impl Iterator<Item = (&'a mut World, Option<LastStep>)>,
    ) -> Option<Self> {
        let mut all = Checkpoint::default();
        let mut last = Vec::new();
        for (k, (world, of_variant)) in variants.enumerate() {
            if of_variant.is_some() {
                let saved = Checkpoint::of(world).ok()?;
                all.attach(&k.to_string(), saved.to_bytes());
            }
            last.push(of_variant);
        }
        let progress = Progress {
            plan: text(plan).ok()?,
            case,
            turns,
            rows: (table.rows.iter())
                .map(|row| (row.blocks.clone(), row.failure.clone()))
                .collect(),
            last,
        };
        all.attach(PROGRESS, postcard::to_stdvec(&progress).ok()?);
        Some(Self(all))
    }

    /// Reads a progress. Refuses what is no file of a study's.
    pub fn read(reader: &mut impl Read) -> Result<Self, CheckpointError> {
        Checkpoint::read(reader).map(Self)
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.0.to_bytes()
    }

    /// Puts finished blocks into the table. Fails if the study has changed since.
    pub(super) fn resume(&self, plan: &Plan, table: &mut Table) -> Result<Progress, StudyError> {
        let refused = |reason: &str| StudyError::Resume(reason.to_owned());
        let bytes = self.0.attached(PROGRESS);
        let bytes = bytes.ok_or_else(|| refused("it is a checkpoint of a run"))?;
        let progress: Progress =
            postcard::from_bytes(bytes).map_err(|error| refused(&error.to_string()))?;
        let (saved, now) = (progress.plan.lines(), text(plan)?);
        let differs = saved.zip(now.lines()).find(|(saved, now)| saved != now);
        if let Some((saved, now)) = differs {
            return Err(refused(&format!(
                "the study has changed since: it said `{}`, and says `{}` now",
                saved.trim(),
                now.trim()
            )));
        }
        let count = plan
            .cases
            .get(progress.case)
            .map(|case| case.variants.len());
        if progress.plan != now
            || progress.rows.len() != table.rows.len()
            || progress.turns > 0 && count != Some(progress.last.len())
        {
            return Err(refused("it is of another study"));
        }
        for (row, (blocks, failure)) in table.rows.iter_mut().zip(&progress.rows) {
            (row.blocks, row.failure) = (blocks.clone(), failure.clone());
        }
        Ok(progress)
    }

    /// Gives a variant of the case that is measured its state.
    pub(super) fn restore(&self, variant: usize, world: &mut World) -> Result<(), StudyError> {
        let refused = |reason: String| StudyError::Resume(reason);
        let bytes = self.0.attached(&variant.to_string());
        let bytes = bytes.ok_or_else(|| refused(format!("variant {variant} is not in it")))?;
        Checkpoint::read(&mut &bytes[..])
            .and_then(|saved| saved.restore(world))
            .map_err(|error| refused(error.to_string()))
    }
}
