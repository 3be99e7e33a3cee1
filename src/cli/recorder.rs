//! Frames and pictures, written beside the steps that follow.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use overfall::output::{Frame, OutputError, Series};
use overfall::scene::{FrameFormat, Scene};

use super::Failure;
use super::folder::RunFolder;
use super::picture::Painter;

/// Frames that may wait to be written. One is enough to overlap writing with computing; a writer that cannot keep
/// up then slows the run down instead of filling the memory.
const WAITING: usize = 1;

/// Writes the frames it is given, in a thread of its own.
pub(super) struct Recorder {
    sender: SyncSender<Frame>,
    writer: JoinHandle<Recorded>,
}

/// What came of the frames.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    /// Frames that are written completely.
    pub(super) frames: u64,
    /// Why there are no more of them.
    pub(super) failure: Option<String>,
}

/// The writer has given up; [`Recorder::finish`] knows why.
#[derive(Debug)]
pub(super) struct GaveUp;

impl Recorder {
    /// Starts the writer for a run of a scene.
    pub(super) fn start(folder: &RunFolder, scene: &Scene) -> Result<Self, Failure> {
        let (sender, receiver) = sync_channel(WAITING);
        let writer = Writer {
            folder: folder.clone(),
            formats: scene.output.formats.clone(),
            series: Series::new(folder.series()),
            painter: scene.output.pictures.then(|| Painter::new(scene)),
        };
        let writer = Builder::new()
            .name("frame writer".to_owned())
            .spawn(move || writer.write_all(&receiver))
            .map_err(|error| {
                Failure::Failed(format!("cannot start the frame writer's thread: {error}"))
            })?;
        Ok(Self { sender, writer })
    }

    /// Hands over a frame; waits while an earlier one is still waiting.
    pub(super) fn record(&self, frame: Frame) -> Result<(), GaveUp> {
        self.sender.send(frame).map_err(|_| GaveUp)
    }

    /// Waits until all frames are written.
    pub(super) fn finish(self) -> Recorded {
        drop(self.sender);
        self.writer.join().unwrap_or_else(|_| Recorded {
            frames: 0,
            failure: Some("the frame writer broke down".to_owned()),
        })
    }
}

/// What the writer's thread works with.
struct Writer {
    folder: RunFolder,
    formats: Vec<FrameFormat>,
    series: Series,
    painter: Option<Painter>,
}

impl Writer {
    fn write_all(mut self, frames: &Receiver<Frame>) -> Recorded {
        let mut recorded = Recorded::default();
        // Returning drops the receiver, which tells the run that there is no use in going on.
        while let Ok(frame) = frames.recv() {
            if let Err(error) = self.write(recorded.frames, &frame) {
                recorded.failure = Some(format!("cannot write {error}"));
                break;
            }
            recorded.frames += 1;
        }
        recorded
    }

    fn write(&mut self, number: u64, frame: &Frame) -> Result<(), OutputError> {
        for &format in &self.formats {
            let file = self.folder.frame(number, format);
            frame.write(&self.folder.root().join(&file), format)?;
            // The series is of VTK files only: its reader, ParaView, takes no others.
            if format == FrameFormat::Vtu {
                self.series.push(frame.time, &file)?;
            }
        }
        match &self.painter {
            Some(painter) => painter.paint(frame, &self.folder.picture(number)),
            None => Ok(()),
        }
    }
}
