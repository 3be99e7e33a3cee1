//! Writes frames and pictures while the next steps are computed.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use bevy_ecs::prelude::World;
use overfall::output::{Frame, OutputError, Series, WallFrame, write_durably};
use overfall::scene::{FrameFormat, Scene};
use overfall::state::Execution;

use super::claims::Claims;
use super::exit::{Failure, cannot_write};
use super::folder::{self, CHECKPOINT, RunFolder};
use super::manifest::is_absent;
use super::picture::Painter;
use super::walls::{WallFiles, Wanted};

/// Writes frames in a thread of its own, one at a time: the next is copied when the one before is written. A slow
/// writer then slows the run down instead of filling the memory, and a second frame in memory would only even that out.
pub(super) struct Recorder {
    sender: Sender<Task>,
    /// Tells of every task that is done.
    done: Receiver<()>,
    /// Tasks that are not done.
    given: usize,
    walls: Wanted,
    writer: JoinHandle<Recorded>,
}

/// A task for the writer.
enum Task {
    /// The boundary particles, if they are wanted with the next frame.
    Walls(WallFrame),
    /// A frame.
    Write(Frame),
    /// The run went back to this time \[s]: frames after it are removed.
    WithdrawAfter(f64),
    /// A checkpoint, to be written after the frames that it counts.
    Checkpoint(Vec<u8>),
}

/// Result of writing the frames.
#[derive(Debug, Default)]
pub(super) struct Recorded {
    /// Frames that are written completely.
    pub(super) frames: u64,
    /// Why writing stopped, if it failed.
    pub(super) failure: Option<String>,
    /// Time spent on files of frames, on pictures, and on checkpoints.
    pub(super) times: [Duration; 3],
}

/// The writer has stopped; [`Recorder::finish`] returns the reason.
#[derive(Debug)]
pub(super) struct GaveUp;

impl Recorder {
    /// Starts the writer for a run of a scene. A run that resumes has frames at these times \[s].
    pub(super) fn start(
        folder: &RunFolder,
        claims: &Arc<Claims>,
        scene: &Scene,
        execution: &Execution,
        written: &[f64],
    ) -> Result<Self, Failure> {
        let (sender, receiver) = channel();
        let (tell, done) = channel();
        let pictures = scene.output.pictures;
        let painter = pictures.then(|| Painter::new(scene, execution.clone()));
        // Before the steps rather than after the first of them.
        let room = painter.as_ref().map(|painter| painter.check_memory(0));
        room.transpose().map_err(cannot_write)?;
        let formats = scene.output.formats.clone();
        let series = if formats.contains(&FrameFormat::Vtu) {
            claims.claim(&folder.series()).map_err(cannot_write)?
        } else {
            folder.path(&folder.series())
        };
        let writer = Writer {
            claims: claims.clone(),
            series: go_on(series, &formats, written)?,
            formats,
            painter,
            walls: WallFiles::start(folder.root(), claims, scene, written.last().copied())?,
            times: written.to_vec(),
            spent: [Duration::ZERO; 3],
        };
        let writer = Builder::new()
            .name("frame writer".to_owned())
            .spawn(move || writer.write_all(&receiver, &tell))
            .map_err(|error| {
                Failure::Failed(format!("cannot start the frame writer's thread: {error}"))
            })?;
        Ok(Self {
            sender,
            done,
            given: 0,
            walls: Wanted::by(scene),
            writer,
        })
    }

    /// Passes the state of a world to the writer, once it has written all earlier ones.
    pub(super) fn record(&mut self, world: &mut World) -> Result<(), GaveUp> {
        self.wait()?;
        if let Some(walls) = self.walls.take(world) {
            self.give(Task::Walls(walls))?;
            // There may be as many of them as of the fluid.
            self.wait()?;
        }
        self.give(Task::Write(Frame::from_world(world)))
    }

    /// Removes the frames after a time \[s], with their files.
    pub(super) fn withdraw_after(&mut self, time: f64) -> Result<(), GaveUp> {
        self.give(Task::WithdrawAfter(time))
    }

    /// Passes the bytes of a checkpoint to the writer.
    pub(super) fn checkpoint(&mut self, bytes: Vec<u8>) -> Result<(), GaveUp> {
        self.give(Task::Checkpoint(bytes))
    }

    fn give(&mut self, task: Task) -> Result<(), GaveUp> {
        self.given += 1;
        self.sender.send(task).map_err(|_| GaveUp)
    }

    /// Waits until everything is written.
    pub(super) fn wait(&mut self) -> Result<(), GaveUp> {
        while self.given > 0 {
            self.done.recv().map_err(|_| GaveUp)?;
            self.given -= 1;
        }
        Ok(())
    }

    /// Waits until all frames are written.
    pub(super) fn finish(self) -> Recorded {
        drop(self.sender);
        self.writer.join().unwrap_or_else(|_| Recorded {
            failure: Some("the frame writer broke down".to_owned()),
            ..Recorded::default()
        })
    }
}

/// The series of those frames at these times \[s] whose files exist in the folder.
fn go_on(path: PathBuf, formats: &[FrameFormat], written: &[f64]) -> Result<Series, Failure> {
    if written.is_empty() || !formats.contains(&FrameFormat::Vtu) || !path.is_file() {
        return Ok(Series::new(path));
    }
    let mut series = Series::read(path).map_err(|error| Failure::Refused(error.to_string()))?;
    let last = written.last().copied().unwrap_or(0.0);
    series.withdraw_after(last).map_err(cannot_write)?;
    Ok(series)
}

/// The state of the writer's thread.
struct Writer {
    claims: Arc<Claims>,
    formats: Vec<FrameFormat>,
    series: Series,
    painter: Option<Painter>,
    walls: WallFiles,
    /// Times of the written frames \[s], by number.
    times: Vec<f64>,
    /// Time spent on files of frames, on pictures, and on checkpoints.
    spent: [Duration; 3],
}

impl Writer {
    fn write_all(mut self, tasks: &Receiver<Task>, tell: &Sender<()>) -> Recorded {
        let mut failure = None;
        // Returning drops the receiver, which tells the run to stop.
        while let Ok(task) = tasks.recv() {
            let done = match task {
                Task::Walls(walls) => self.write_walls(&walls),
                Task::Write(frame) => self.write(&frame),
                Task::WithdrawAfter(time) => self.withdraw_after(time),
                Task::Checkpoint(bytes) => {
                    let started = Instant::now();
                    let written = (self.claims.claim(CHECKPOINT))
                        .and_then(|path| write_durably(&path, &bytes));
                    self.spent[2] += started.elapsed();
                    written
                }
            };
            if let Err(error) = done {
                failure = Some(format!("cannot write {error}"));
                break;
            }
            // Nobody listens when the run has ended.
            tell.send(()).ok();
        }
        Recorded {
            frames: self.times.len() as u64,
            failure,
            times: self.spent,
        }
    }

    fn withdraw_after(&mut self, time: f64) -> Result<(), OutputError> {
        self.series.withdraw_after(time)?;
        let frames = self.times.len() as u64;
        while self.times.pop_if(|last| *last > time).is_some() {
            let number = self.times.len() as u64;
            let frames = (self.formats.iter()).map(|&format| folder::frame(number, format));
            let picture = self.painter.iter().map(|_| folder::picture(number));
            for name in frames.chain(picture) {
                let path = self.claims.claim(&name)?;
                match fs::remove_file(&path) {
                    // A run that resumes in a folder of its own has its older frames elsewhere.
                    Err(error) if is_absent(&error) => {}
                    removed => removed.map_err(|source| OutputError::Io { path, source })?,
                }
            }
        }
        let gone = self.times.len() as u64..frames;
        self.walls.withdraw_after(time, gone)
    }

    fn write_walls(&mut self, walls: &WallFrame) -> Result<(), OutputError> {
        let started = Instant::now();
        self.walls.write(self.times.len() as u64, walls)?;
        self.spent[0] += started.elapsed();
        Ok(())
    }

    fn write(&mut self, frame: &Frame) -> Result<(), OutputError> {
        let number = self.times.len() as u64;
        let started = Instant::now();
        for &format in &self.formats {
            let file = folder::frame(number, format);
            frame.write(&self.claims.claim(&file)?, format)?;
            // The series lists only VTK files, because ParaView supports no others in it.
            if format == FrameFormat::Vtu {
                self.series.push(frame.time, &file)?;
            }
        }
        let painting = Instant::now();
        self.spent[0] += painting - started;
        if let Some(painter) = &self.painter {
            painter.paint(frame, &self.claims.claim(&folder::picture(number))?)?;
        }
        self.spent[1] += painting.elapsed();
        self.times.push(frame.time);
        Ok(())
    }
}
