//! The surfaces of a run, several frames at the same time.

use std::fs;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use overfall::output::picture::{View, draw_surface};
use overfall::output::surface::{SurfaceError, SurfaceFormat, SurfaceMesh, Surfacing};
use overfall::output::{Frame, OutputError, Series};
use overfall::scene::{Dimension, Scene};
use overfall::state::Execution;

use super::claims::Claims;
use super::console;
use super::exit::{Exit, Failure, cannot_write};
use super::folder::{RunFolder, STEM, numbered_files};
use super::interrupt;
use super::looks;
use super::manifest::{create_folder, failed};
use super::movie::{self, Movie};
use super::picture::{cannot_read, written_frames};
use super::scene_copy::SCENE;
use super::surface::Surface;

/// All surfaces as one animation, and the movie of their pictures.
const SERIES: &str = "surface.pvd";
const MOVIE: &str = "surface.mp4";
const SURFACES: &str = "surfaces";
const SURFACE_PICTURES: &str = "surface_pictures";
/// Time between two lines of progress.
const LINE_INTERVAL: Duration = Duration::from_secs(3);

/// What is done with each frame.
struct Work<'a> {
    surfacing: Surfacing,
    formats: Vec<SurfaceFormat>,
    /// `None` for no pictures.
    view: Option<View>,
    claims: &'a Claims,
}

/// A surface that is written.
struct Written {
    number: u64,
    time: f64,
    triangles: usize,
}

pub(super) fn write(options: &Surface) -> Result<Exit, Failure> {
    let folder = RunFolder::open(&options.folder);
    let claims = Claims::reopen(folder.root())?;
    let scene = Scene::load(&folder.path(SCENE), &[])
        .map_err(|error| Failure::Refused(error.to_string()))?;
    if scene.dimension == Dimension::Two {
        return Err(Failure::Refused(format!(
            "{}: the run is in the plane, and a surface is around fluid in space (`dimension: 3`)",
            folder.root().display()
        )));
    }
    let frames = written_frames(&folder)?;
    if frames.is_empty() {
        return Err(Failure::Refused(format!(
            "{}: there are no frames to find surfaces of",
            folder.frames().display()
        )));
    }
    let surfacing = surfacing(options, &scene);
    surfacing
        .check()
        .map_err(|error| Failure::Refused(error.to_string()))?;
    prepare(&folder, &claims, &frames, !options.no_pictures)?;
    let path = looks::path(options.camera.as_deref())?;
    let view = (!options.no_pictures)
        .then(|| options.looks().of(view_of(options, &scene), &frames))
        .transpose()
        .map_err(cannot_read)?
        .map(|view| View {
            camera_path: path,
            ..view
        });
    let work = Work {
        surfacing,
        formats: options.formats(),
        view,
        claims: &claims,
    };
    let progress = Progress::start(frames.len(), options.quiet);
    interrupt::listen(progress.announcer())?;
    let (written, failed) = work.all(&frames, options.threads.count(), progress);
    // Also of a call that ends early: what is there can be opened.
    let listed = if work.formats.contains(&SurfaceFormat::Vtu) {
        work.list(&written).map_err(cannot_write)
    } else {
        Ok(())
    };
    // On a full disk both fail, and the frame is what failed first.
    failed.map_or(Ok(()), Err)?;
    listed?;
    let is_whole = written.len() == frames.len();
    tell(options, &scene, &folder, &claims, &written, is_whole)?;
    Ok(if is_whole {
        Exit::Done
    } else {
        Exit::Interrupted
    })
}

/// The surface of a frame, relative to the folder.
fn file(number: u64, format: SurfaceFormat) -> String {
    format!("{SURFACES}/{STEM}{number:05}.{}", format.extension())
}

/// The picture of a surface, relative to the folder.
fn picture(number: u64) -> String {
    format!("{SURFACE_PICTURES}/{STEM}{number:05}.png")
}

/// Creates the folders of the surfaces. Those of frames that a resumed run has no longer are removed.
fn prepare(
    folder: &RunFolder,
    claims: &Claims,
    frames: &[(u64, PathBuf)],
    pictures: bool,
) -> Result<(), Failure> {
    let meshes = ["vtu", "ply", "obj"].map(|extension| (SURFACES, extension));
    for (part, extension) in meshes.into_iter().chain([(SURFACE_PICTURES, "png")]) {
        for (number, path) in numbered_files(&folder.path(part), extension)? {
            let name = format!("{part}/{STEM}{number:05}.{extension}");
            let is_stale = frames.iter().all(|(frame, _)| *frame != number);
            if is_stale && claims.is_ours(&name) {
                fs::remove_file(&path)
                    .map_err(|error| failed("cannot remove the older", &path, &error))?;
            }
        }
    }
    create_folder(&folder.path(SURFACES))?;
    if pictures {
        create_folder(&folder.path(SURFACE_PICTURES))?;
    }
    Ok(())
}

fn view_of(options: &Surface, scene: &Scene) -> View {
    let view = View::from_scene(scene);
    if options.glass {
        view.with_glass()
    } else {
        view
    }
}

/// The library's recommendation for the scene's spacing, with the options of the command.
fn surfacing(options: &Surface, scene: &Scene) -> Surfacing {
    let recommended = Surfacing::for_spacing(scene.spacing);
    Surfacing {
        particle_radius: options
            .particle_radius
            .unwrap_or(recommended.particle_radius),
        smoothing_length: options.smoothing_length,
        cube_size: options.cube_size,
        threshold: options.threshold,
        smoothing: options.smoothing.into(),
        ..recommended
    }
}

/// Prints where everything is.
fn tell(
    options: &Surface,
    scene: &Scene,
    folder: &RunFolder,
    claims: &Claims,
    written: &[Written],
    is_whole: bool,
) -> Result<(), Failure> {
    if options.movie && is_whole {
        let to = claims.claim(MOVIE).map_err(cannot_write)?;
        let pictures = folder.path(SURFACE_PICTURES);
        match movie::write(&pictures, &to, scene.output.frames_per_second)? {
            Movie::Written => console::print(&format!("the movie is {}\n", to.display()))?,
            Movie::Command(command) => console::note(&format!(
                "there is no ffmpeg on the path, so no movie; with it: {command}"
            )),
        }
    }
    let most = written.iter().map(|surface| surface.triangles).max();
    console::print(&format!(
        "{} surfaces of up to {} triangles in {}\n",
        written.len(),
        most.unwrap_or_default(),
        folder.path(SURFACES).display()
    ))?;
    if !options.no_pictures {
        let pictures = folder.path(SURFACE_PICTURES);
        console::print(&format!("their pictures in {}\n", pictures.display()))?;
    }
    Ok(())
}

impl Work<'_> {
    /// Writes the surfaces of all frames, or of some if that fails or is interrupted. Returns those that are written,
    /// in the order of their frames, and the failure of the first frame that failed.
    ///
    /// A surface is found by one thread, so each thread has frames of its own.
    fn all(
        &self,
        frames: &[(u64, PathBuf)],
        threads: usize,
        mut progress: Progress,
    ) -> (Vec<Written>, Option<Failure>) {
        let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        let (sender, receiver) = channel();
        let mut written: Vec<Option<Written>> = frames.iter().map(|_| None).collect();
        let mut failed: Option<(usize, Failure)> = None;
        thread::scope(|scope| {
            for _ in 0..threads.clamp(1, frames.len()) {
                let (sender, next, stopped) = (sender.clone(), &next, &stopped);
                let started = Builder::new()
                    .name("surface".to_owned())
                    .spawn_scoped(scope, move || self.several(frames, next, stopped, &sender));
                if let Err(error) = started {
                    stopped.store(true, Ordering::Relaxed);
                    let failure = Failure::Failed(format!("cannot start a thread: {error}"));
                    failed = Some((0, failure));
                    break;
                }
            }
            drop(sender);
            for (index, done) in receiver {
                match done {
                    Ok(surface) => {
                        written[index] = Some(surface);
                        progress.one_more();
                    }
                    Err(failure) => {
                        stopped.store(true, Ordering::Relaxed);
                        if failed.as_ref().is_none_or(|(first, _)| index < *first) {
                            failed = Some((index, failure));
                        }
                    }
                }
            }
        });
        progress.finish();
        let written = written.into_iter().flatten().collect();
        (written, failed.map(|(_, failure)| failure))
    }

    /// Writes surfaces until there are no more frames, something failed, or the user interrupts.
    fn several(
        &self,
        frames: &[(u64, PathBuf)],
        next: &AtomicUsize,
        stopped: &AtomicBool,
        done: &Sender<(usize, Result<Written, Failure>)>,
    ) {
        while !stopped.load(Ordering::Relaxed) && !interrupt::asked() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((number, path)) = frames.get(index) else {
                return;
            };
            if done.send((index, self.one(*number, path))).is_err() {
                return;
            }
        }
    }

    fn one(&self, number: u64, path: &Path) -> Result<Written, Failure> {
        let frame = Frame::read(path).map_err(cannot_read)?;
        let surface = self.surfacing.of(&frame).map_err(|error| match error {
            SurfaceError::Thread(_) => Failure::Failed(error.to_string()),
            _ => Failure::Failed(format!("{}: {error}", path.display())),
        })?;
        for &format in &self.formats {
            (self.claims.claim(&file(number, format)))
                .and_then(|path| surface.write(&path, format))
                .map_err(cannot_write)?;
        }
        if let Some(view) = &self.view {
            self.draw(&surface, view, number)?;
        }
        Ok(Written {
            number,
            time: surface.time,
            triangles: surface.triangles.len(),
        })
    }

    fn draw(&self, surface: &SurfaceMesh, view: &View, number: u64) -> Result<(), Failure> {
        // The other threads have other frames.
        let execution = Execution::new(1).map_err(|error| {
            Failure::Failed(format!("cannot start a thread to draw with: {error}"))
        })?;
        view.check_memory(surface.triangles.len())
            .map_err(cannot_write)?;
        let drawn = execution.install(|| draw_surface(surface, view));
        (self.claims.claim(&picture(number)))
            .and_then(|path| drawn.write_png(&path))
            .map_err(cannot_write)
    }

    /// Lists the surfaces as one animation.
    fn list(&self, written: &[Written]) -> Result<(), OutputError> {
        if written.is_empty() {
            return Ok(());
        }
        let mut series = Series::new(self.claims.claim(SERIES)?);
        for surface in written {
            series.push(surface.time, &file(surface.number, SurfaceFormat::Vtu))?;
        }
        Ok(())
    }
}

/// How many frames are done: a bar on a terminal, lines elsewhere.
struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    done: usize,
    all: usize,
    shown: Instant,
}

impl Progress {
    fn start(all: usize, quiet: bool) -> Self {
        let on_terminal = !quiet && std::io::stderr().is_terminal();
        let style = ProgressStyle::with_template("surfaces {wide_bar} {pos} of {len}, {eta} left");
        let bar = on_terminal.then(|| {
            let bar = ProgressBar::new(all as u64);
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self {
            bar,
            quiet,
            done: 0,
            all,
            shown: Instant::now(),
        }
    }

    /// Tells the user what an interruption does.
    fn announcer(&self) -> impl Fn(&str) + Send + 'static {
        let bar = self.bar.clone();
        move |_| {
            let say = || {
                console::note(
                    "interrupted: finishing the frames that are begun; again to leave at once",
                );
            };
            match &bar {
                Some(bar) => bar.suspend(say),
                None => say(),
            }
        }
    }

    fn one_more(&mut self) {
        self.done += 1;
        if let Some(bar) = &self.bar {
            bar.inc(1);
        } else if !self.quiet && self.shown.elapsed() >= LINE_INTERVAL {
            self.shown = Instant::now();
            console::note(&format!("{} of {} surfaces", self.done, self.all));
        }
    }

    fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
