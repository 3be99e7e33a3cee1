//! Pictures of frames, and `overfall picture`, which draws those of a finished run again.

use std::path::{Path, PathBuf};

use overfall::output::picture::{Image, View, contact_sheet, draw_after, evenly_spaced};
use overfall::output::{Frame, OutputError};
use overfall::scene::{FrameFormat, Scene};
use overfall::state::Execution;

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{self, CONTACT_SHEET, RunFolder};
use super::looks::{self, Looks};
use super::movie::{self, MOVIE, Movie};
use super::scene_copy::SCENE;
use super::{console, options};

/// Number of pictures on the contact sheet, and number per row.
const SHEET_PICTURES: usize = 12;
const SHEET_COLUMNS: usize = 4;
/// Size of a picture on the sheet \[pixels], half of the normal size: drawn at this size its text is sharp.
const SHEET_PICTURE: (u32, u32) = (480, 270);

/// Draws the frames of a scene, all from the same viewpoint and with the same colours.
pub(super) struct Painter {
    view: View,
    /// The threads that draw.
    execution: Execution,
}

impl Painter {
    /// A painter for a scene, with these threads.
    pub(super) fn new(scene: &Scene, execution: Execution) -> Self {
        let view = View::from_scene(scene);
        Self { view, execution }
    }

    /// Draws a frame into a PNG file.
    pub(super) fn paint(&self, frame: &Frame, path: &Path) -> Result<(), OutputError> {
        self.draw(frame, None)?.write_png(path)
    }

    /// Fails if there is no memory to draw a frame of so many particles.
    pub(super) fn check_memory(&self, particles: usize) -> Result<(), OutputError> {
        self.view.check_memory(particles)
    }

    fn needs_the_frame_before(&self) -> bool {
        self.view.quantity.needs_the_frame_before()
    }

    /// Draws a frame; some colours need the frame before.
    fn draw(&self, frame: &Frame, before: Option<&Frame>) -> Result<Image, OutputError> {
        self.check_memory(frame.positions.len())?;
        Ok((self.execution).install(|| draw_after(frame, before, &self.view)))
    }

    /// The same painter with other looks, for these frames.
    fn looking(mut self, looks: &Looks, frames: &[(u64, PathBuf)]) -> Result<Self, OutputError> {
        self.view = looks.of(self.view, frames)?;
        Ok(self)
    }

    /// The same painter with another size.
    fn with_size(mut self, (width, height): (u32, u32)) -> Self {
        self.view = self.view.with_size(width, height);
        self
    }
}

/// Draws the pictures of a run again.
pub(super) fn picture(options: &options::Picture) -> Result<Exit, Failure> {
    let folder = RunFolder::open(&options.folder);
    let claims = Claims::reopen(folder.root())?;
    let scene = Scene::load(&folder.path(SCENE), &[])
        .map_err(|error| Failure::Refused(error.to_string()))?;
    let frames = written_frames(&folder)?;
    if frames.is_empty() {
        return Err(Failure::Refused(format!(
            "{}: there are no frames to draw",
            folder.frames().display()
        )));
    }
    folder.create_pictures()?;
    let execution = Execution::new(options.threads.count())
        .map_err(|error| Failure::Failed(format!("cannot start threads to draw with: {error}")))?;
    let path = looks::path(options.looks.camera.as_deref())?;
    let looking = |painter: Painter| {
        painter
            .looking(&options.looks, &frames)
            .map_err(cannot_read)
    };
    let mut painter = looking(Painter::new(&scene, execution))?;
    painter.view.camera_path = path;
    let mut before: Option<Frame> = None;
    for (number, path) in &frames {
        let frame = Frame::read(path).map_err(cannot_read)?;
        (claims.claim(&folder::picture(*number)))
            .and_then(|path| painter.draw(&frame, before.as_ref())?.write_png(&path))
            .map_err(cannot_write)?;
        before = painter.needs_the_frame_before().then_some(frame);
    }
    sheet(painter, &frames, &claims)?;
    if options.movie {
        let to = claims.claim(MOVIE).map_err(cannot_write)?;
        match movie::write(&folder.pictures(), &to, scene.output.frames_per_second)? {
            Movie::Written => console::print(&format!("the movie is {}\n", to.display()))?,
            Movie::Command(command) => console::note(&format!(
                "there is no ffmpeg on the path, so no movie; with it: {command}"
            )),
        }
    }
    console::print(&format!(
        "{} pictures in {}, all in one: {}\n",
        frames.len(),
        folder.pictures().display(),
        folder.path(CONTACT_SHEET).display()
    ))?;
    Ok(Exit::Done)
}

/// Draws about a dozen evenly spaced frames of a run on one sheet. Without frames there is no sheet.
///
/// The frames are read from their files: keeping a dozen in memory would cost as much as the run itself, and which
/// frames are needed is known only at the end.
pub(super) fn write_contact_sheet(
    scene: &Scene,
    folder: &RunFolder,
    claims: &Claims,
    execution: &Execution,
) -> Result<(), Failure> {
    let frames = written_frames(folder)?;
    if frames.is_empty() {
        return Ok(());
    }
    sheet(Painter::new(scene, execution.clone()), &frames, claims)
}

fn sheet(painter: Painter, frames: &[(u64, PathBuf)], claims: &Claims) -> Result<(), Failure> {
    let painter = painter.with_size(SHEET_PICTURE);
    let picture = |index: usize| {
        let frame = Frame::read(&frames[index].1)?;
        let before = index
            .checked_sub(1)
            .filter(|_| painter.needs_the_frame_before())
            .map(|before| Frame::read(&frames[before].1));
        painter.draw(&frame, before.transpose()?.as_ref())
    };
    let images = evenly_spaced(frames.len(), SHEET_PICTURES)
        .into_iter()
        .map(picture)
        .collect::<Result<Vec<_>, _>>()
        .map_err(cannot_read)?;
    if let Some(first) = images.first() {
        first
            .check_memory_of_sheet(images.len())
            .map_err(cannot_write)?;
    }
    let sheet = contact_sheet(&images, SHEET_COLUMNS);
    claims
        .claim(CONTACT_SHEET)
        .and_then(|path| sheet.write_png(&path))
        .map_err(cannot_write)
}

/// The frames of a run by number, in any format that it wrote.
pub(super) fn written_frames(folder: &RunFolder) -> Result<Vec<(u64, PathBuf)>, Failure> {
    let frames = folder.written_frames(FrameFormat::Vtu)?;
    if frames.is_empty() {
        return folder.written_frames(FrameFormat::Ply);
    }
    Ok(frames)
}

pub(super) fn cannot_read(error: OutputError) -> Failure {
    Failure::Failed(format!("cannot read {error}"))
}
