//! Pictures of frames, and `overfall picture`, which draws those of a finished run again.

use std::path::{Path, PathBuf};

use overfall::output::picture::{Image, View, contact_sheet, draw, evenly_spaced};
use overfall::output::{Frame, OutputError};
use overfall::scene::{FrameFormat, Scene};
use overfall::state::Execution;

use super::claims::Claims;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{self, CONTACT_SHEET, RunFolder};
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
        self.draw(frame).write_png(path)
    }

    fn draw(&self, frame: &Frame) -> Image {
        self.execution.install(|| draw(frame, &self.view))
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
    let painter = Painter::new(&scene, execution.clone());
    for (number, path) in &frames {
        let frame = Frame::read(path).map_err(cannot_read)?;
        (claims.claim(&folder::picture(*number)))
            .and_then(|path| painter.paint(&frame, &path))
            .map_err(cannot_write)?;
    }
    write_contact_sheet(&scene, &folder, &claims, &execution)?;
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
    let painter = Painter::new(scene, execution.clone()).with_size(SHEET_PICTURE);
    let images = evenly_spaced(frames.len(), SHEET_PICTURES)
        .into_iter()
        .map(|index| Frame::read(&frames[index].1).map(|frame| painter.draw(&frame)))
        .collect::<Result<Vec<_>, _>>()
        .map_err(cannot_read)?;
    let sheet = contact_sheet(&images, SHEET_COLUMNS);
    claims
        .claim(CONTACT_SHEET)
        .and_then(|path| sheet.write_png(&path))
        .map_err(cannot_write)
}

/// The frames of a run by number, in any format that it wrote.
fn written_frames(folder: &RunFolder) -> Result<Vec<(u64, PathBuf)>, Failure> {
    let frames = folder.written_frames(FrameFormat::Vtu)?;
    if frames.is_empty() {
        return folder.written_frames(FrameFormat::Ply);
    }
    Ok(frames)
}

fn cannot_read(error: OutputError) -> Failure {
    Failure::Failed(format!("cannot read {error}"))
}
