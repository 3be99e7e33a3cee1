//! Pictures of frames, and `overfall picture`, which draws those of a run again.

use std::path::{Path, PathBuf};

use overfall::output::picture::{View, contact_sheet, draw, evenly_spaced};
use overfall::output::{Frame, OutputError};
use overfall::scene::{FrameFormat, Scene};

use super::folder::RunFolder;
use super::{Exit, Failure, cannot_write, console, options};

/// Pictures on the contact sheet, and how many of them stand side by side.
const SHEET_PICTURES: usize = 12;
const SHEET_COLUMNS: usize = 4;
/// Size of a picture on the sheet [pixels], half of one that stands alone: drawn at this size its text is sharp.
const SHEET_PICTURE: (u32, u32) = (480, 270);

/// Draws the frames of a scene, all as seen from the same place and in the same colours.
pub(super) struct Painter {
    view: View,
}

impl Painter {
    /// A painter for a scene.
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            view: View::from_scene(scene),
        }
    }

    /// Draws a frame into a PNG file.
    pub(super) fn paint(&self, frame: &Frame, path: &Path) -> Result<(), OutputError> {
        draw(frame, &self.view).write_png(path)
    }
}

/// Draws the pictures of a run again.
pub(super) fn picture(options: &options::Picture) -> Result<Exit, Failure> {
    let folder = RunFolder::open(&options.folder);
    let scene =
        Scene::load(&folder.scene(), &[]).map_err(|error| Failure::Refused(error.to_string()))?;
    let frames = written_frames(&folder)?;
    if frames.is_empty() {
        return Err(Failure::Refused(format!(
            "{}: there are no frames to draw",
            folder.frames().display()
        )));
    }
    folder.create_pictures()?;
    let painter = Painter::new(&scene);
    for (number, path) in &frames {
        let frame = Frame::read(path).map_err(cannot_read)?;
        painter
            .paint(&frame, &folder.picture(*number))
            .map_err(cannot_write)?;
    }
    write_contact_sheet(&scene, &folder)?;
    console::print(&format!(
        "{} pictures in {}, all in one: {}\n",
        frames.len(),
        folder.pictures().display(),
        folder.contact_sheet().display()
    ))?;
    Ok(Exit::Done)
}

/// Puts about a dozen frames of a run, evenly chosen, on one sheet. Without frames there is none.
///
/// The frames are read back from their files: to keep a dozen in memory would cost as much as the run itself, and
/// which dozen it is shows at the end only.
pub(super) fn write_contact_sheet(scene: &Scene, folder: &RunFolder) -> Result<(), Failure> {
    let frames = written_frames(folder)?;
    if frames.is_empty() {
        return Ok(());
    }
    let (width, height) = SHEET_PICTURE;
    let view = View::from_scene(scene).with_size(width, height);
    let images = evenly_spaced(frames.len(), SHEET_PICTURES)
        .into_iter()
        .map(|index| Frame::read(&frames[index].1).map(|frame| draw(&frame, &view)))
        .collect::<Result<Vec<_>, _>>()
        .map_err(cannot_read)?;
    contact_sheet(&images, SHEET_COLUMNS)
        .write_png(&folder.contact_sheet())
        .map_err(cannot_write)
}

/// The frames of a run by number, in whichever format it wrote.
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
