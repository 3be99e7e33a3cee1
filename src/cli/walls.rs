//! The files of the boundary particles: one of a run whose walls stand, one per frame where walls move.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use bevy_ecs::prelude::World;
use overfall::output::{OutputError, Series, WallFrame};
use overfall::scene::{FrameFormat, Scene};

use super::claims::Claims;
use super::exit::{Failure, cannot_write};
use super::folder::{self, BOUNDARY, BOUNDARY_FILE, BOUNDARY_SERIES};
use super::manifest::{create_folder, is_absent};

/// With which frames the boundary particles are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// With none: the scene has no frames that ParaView reads.
    Never,
    /// With the next, since the walls stand.
    Once,
    /// With every frame, since walls move.
    Always,
}

impl Wanted {
    /// As a scene has it.
    pub(super) fn by(scene: &Scene) -> Self {
        let mut walls = scene.boundaries.iter();
        if walls.len() == 0 || !scene.output.formats.contains(&FrameFormat::Vtu) {
            Self::Never
        } else if walls.any(|wall| wall.motion().is_some()) {
            Self::Always
        } else {
            Self::Once
        }
    }

    /// The boundary particles of a world for a frame, if they are wanted with it.
    pub(super) fn take(&mut self, world: &mut World) -> Option<WallFrame> {
        if *self == Self::Never {
            return None;
        }
        if *self == Self::Once {
            *self = Self::Never;
        }
        Some(WallFrame::from_world(world))
    }
}

/// The files of boundary particles.
pub(super) struct WallFiles {
    claims: Arc<Claims>,
    /// The frames of walls that move; `None` for one file of those that stand.
    series: Option<Series>,
}

impl WallFiles {
    /// Files for a scene. A run that resumes has frames until `last` \[s].
    pub(super) fn start(
        root: &Path,
        claims: &Arc<Claims>,
        scene: &Scene,
        last: Option<f64>,
    ) -> Result<Self, Failure> {
        let claims = claims.clone();
        if Wanted::by(scene) != Wanted::Always {
            return Ok(Self {
                claims,
                series: None,
            });
        }
        create_folder(&root.join(BOUNDARY))?;
        let path = claims.claim(BOUNDARY_SERIES).map_err(cannot_write)?;
        let mut series = Series::new(&path);
        if let Some(last) = last.filter(|_| path.is_file()) {
            series = Series::read(path).map_err(|error| Failure::Refused(error.to_string()))?;
            series.withdraw_after(last).map_err(cannot_write)?;
        }
        let series = Some(series);
        Ok(Self { claims, series })
    }

    /// Writes the boundary particles that come with a frame.
    pub(super) fn write(&mut self, number: u64, walls: &WallFrame) -> Result<(), OutputError> {
        let Some(series) = &mut self.series else {
            return walls.write_vtu(&self.claims.claim(BOUNDARY_FILE)?);
        };
        let file = folder::boundary_frame(number);
        walls.write_vtu(&self.claims.claim(&file)?)?;
        series.push(walls.time, &file)
    }

    /// Removes the frames after a time \[s]: of these numbers.
    pub(super) fn withdraw_after(
        &mut self,
        time: f64,
        numbers: std::ops::Range<u64>,
    ) -> Result<(), OutputError> {
        let Some(series) = &mut self.series else {
            return Ok(());
        };
        series.withdraw_after(time)?;
        for number in numbers {
            let path = self.claims.claim(&folder::boundary_frame(number))?;
            match fs::remove_file(&path) {
                Err(error) if is_absent(&error) => {}
                removed => removed.map_err(|source| OutputError::Io { path, source })?,
            }
        }
        Ok(())
    }
}
