//! The options of every command, and how they change the scene of a scene file.

use std::num::NonZero;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use overfall::step::InstallError;
use overfall::{
    loading::Override,
    scene::{FrameFormat, Place, Scene, SceneError},
    validate::{METHODS, Method},
};

use super::caret;
use super::checkpoints::Every;
use super::exit::Failure;
use super::kinds::{Kind, with_kind};
use super::looks::Looks;
use super::numbers::{not_negative, percent, positive, resolution, threads, whole_number};

/// The scene file, and overrides of its values.
#[derive(Args, Debug)]
pub(super) struct SceneOptions {
    /// The scene file (RON).
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(super) scene: PathBuf,
    #[command(flatten)]
    set: Set,
    #[command(flatten)]
    threads: Threads,
}

/// Overrides of a scene.
#[derive(Args, Debug)]
pub(super) struct Set {
    /// Replace a value of the scene, e.g. --set spacing=0.01; may be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
}

/// What is printed.
#[derive(Args, Debug, Clone, Copy)]
pub(super) struct Reporting {
    /// Print the result on standard output as JSON.
    #[arg(long)]
    pub(super) json: bool,
    /// Show no progress.
    #[arg(long)]
    pub(super) quiet: bool,
}

/// Number of threads.
#[derive(Args, Debug)]
pub(super) struct Threads {
    /// Number of threads that compute and draw; all cores by default.
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    threads: Option<u64>,
}

/// Options of `overfall run`.
#[derive(Args, Debug)]
pub(super) struct Run {
    #[command(flatten)]
    pub(super) scene: SceneOptions,
    /// Simulated time \[s] instead of the scene's.
    #[arg(long, value_name = "S", value_parser = positive, conflicts_with = "steps", allow_negative_numbers = true)]
    duration: Option<f32>,
    /// Take exactly this number of steps, whatever the duration.
    #[arg(long, value_name = "N", value_parser = whole_number, allow_negative_numbers = true)]
    pub(super) steps: Option<u64>,
    /// Output folder; out/<scene name> by default. An older run in it is moved into a subfolder older_1, older_2, …
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) out: Option<PathBuf>,
    /// Replace an older run of the scene instead of moving it aside, when the new one is done.
    #[arg(long)]
    pub(super) force: bool,
    /// Frames per simulated second; 0 writes the first and the last only.
    #[arg(long, value_name = "F", value_parser = not_negative, allow_negative_numbers = true)]
    frames_per_second: Option<f32>,
    /// Shorten steps so that frames are at multiples of their interval exactly, not at the step ends nearest to them.
    #[arg(long)]
    exact_times: bool,
    /// File formats of the frames.
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',')]
    format: Option<Vec<Format>>,
    /// Draw a picture of every frame.
    #[arg(
        long,
        value_name = "BOOL",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "true",
        overrides_with = "no_pictures"
    )]
    pictures: Option<bool>,
    /// Draw no pictures.
    #[arg(long, overrides_with = "pictures")]
    no_pictures: bool,
    /// Write a checkpoint every number of steps (30), simulated time (0.5s) or wall time (10min, 2h). Ctrl-C always
    /// writes one.
    #[arg(long, value_name = "EVERY")]
    pub(super) checkpoint: Option<Every>,
    /// Resume from a checkpoint file or from a run's folder; output continues in that folder unless --out is given.
    #[arg(long, value_name = "DIR|FILE", value_hint = ValueHint::AnyPath, conflicts_with = "force")]
    pub(super) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(super) reporting: Reporting,
}

/// Options of `overfall check`.
#[derive(Args, Debug)]
pub(super) struct Check {
    #[command(flatten)]
    pub(super) run: Run,
    /// Run a few steps (20, or --steps) and print what every part costs; run simpler scenes beside it and print what
    /// could go.
    #[arg(long)]
    pub(super) cost: bool,
    /// Change of the result that is no change, in per cent of the particles' ways.
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "1%", requires = "cost")]
    pub(super) error: f64,
}

/// Options of `overfall advise`.
#[derive(Args, Debug)]
pub(super) struct Advise {
    #[command(flatten)]
    pub(super) scene: SceneOptions,
    /// Largest error that is allowed, in per cent of the range of the measure.
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "1%")]
    pub(super) error: f64,
    /// What the error is of: `energy` (kinetic), `centre_x`, `centre_y`, `centre_z` (centre of mass), or a gauge of the
    /// scene.
    #[arg(long, value_name = "NAME", default_value = "energy")]
    pub(super) measure: String,
    /// Simulated time of a trial \[s]; a fall through the fluid's height by default.
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true)]
    pub(super) time: Option<f32>,
    #[command(flatten)]
    pub(super) reporting: Reporting,
}

/// Options of `overfall fields`.
#[derive(Args, Debug)]
pub(super) struct Fields {
    /// Show these alone: fields and variants whose path holds one of the words, e.g. `motion` or `time_step`.
    #[arg(value_name = "WORD")]
    pub(super) words: Vec<String>,
    /// Print the JSON schema instead, as `overfall schema` does.
    #[arg(long)]
    pub(super) json: bool,
}

/// Options of `overfall completions`.
#[derive(Args, Debug)]
pub(super) struct Completions {
    /// The shell.
    #[arg(value_name = "SHELL")]
    pub(super) shell: clap_complete::Shell,
}

/// Options of `overfall picture`.
#[derive(Args, Debug)]
pub(super) struct Picture {
    /// The folder of a run, e.g. out/dam_break.
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) folder: PathBuf,
    #[command(flatten)]
    pub(super) looks: Looks,
    /// Join the pictures to movie.mp4 with ffmpeg; if that is not installed, print the command.
    #[arg(long)]
    pub(super) movie: bool,
    #[command(flatten)]
    pub(super) threads: Threads,
}

/// Options of `overfall study`.
#[derive(Args, Debug)]
pub(super) struct Study {
    /// The study file (RON), e.g. assets/studies/table_1.ron.
    #[arg(value_name = "STUDY", value_hint = ValueHint::FilePath)]
    pub(super) study: PathBuf,
    /// Overrides of the study's scene, before those of its cases and variants.
    #[command(flatten)]
    pub(super) set: Set,
    /// Output folder; out/<study name> by default. An older table in it is moved into a subfolder older_1, older_2, …
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) out: Option<PathBuf>,
    /// Replace older results of the study instead of moving them aside, when the new ones are complete.
    #[arg(long)]
    pub(super) force: bool,
    /// Go on where an interrupted study stopped, in its folder; what it had finished is not repeated.
    #[arg(long, conflicts_with = "force")]
    pub(super) resume: bool,
    /// Run only the variant with this name; may be repeated (studies of kind Stability or Frontier).
    #[arg(long, value_name = "VARIANT")]
    pub(super) only: Vec<String>,
    /// Run all points again, those too that an older run in the output folder has finished (studies of kind Stability
    /// or Frontier).
    #[arg(long)]
    pub(super) fresh: bool,
    #[command(flatten)]
    pub(super) reporting: Reporting,
    #[command(flatten)]
    pub(super) threads: Threads,
}

/// Options of `overfall validate`.
#[derive(Args, Debug)]
pub(super) struct Validate {
    /// Cases by name or by its beginning, e.g. hydrostatic; all by default.
    #[arg(value_name = "CASE")]
    pub(super) cases: Vec<String>,
    /// A method to run; may be repeated. All by default.
    #[arg(long = "method", value_name = "METHOD", value_parser = method)]
    pub(super) methods: Vec<&'static Method>,
    /// Particles over the characteristic length of each case, instead of the case's own number (see --list).
    #[arg(long, value_name = "N", conflicts_with = "convergence")]
    #[arg(value_parser = resolution, allow_negative_numbers = true)]
    pub(super) resolution: Option<u32>,
    /// Run every case at three resolutions and fit the order of its errors.
    #[arg(long)]
    pub(super) convergence: bool,
    /// Output folder; out/validation by default. An older page in it is moved into a subfolder older_1, older_2, …
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) out: Option<PathBuf>,
    /// Replace an older page instead of moving it aside, when the new one is complete.
    #[arg(long)]
    pub(super) force: bool,
    /// List the cases and the methods; run nothing.
    #[arg(long)]
    pub(super) list: bool,
    #[command(flatten)]
    pub(super) reporting: Reporting,
    #[command(flatten)]
    pub(super) threads: Threads,
}

fn method(text: &str) -> Result<&'static Method, String> {
    let known = METHODS.iter().find(|method| method.key == text);
    known.ok_or_else(|| {
        let keys = METHODS.map(|method| method.key);
        format!("the methods are {}", keys.join(", "))
    })
}

/// [`FrameFormat`] in the notation of the command line.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    /// VTK XML unstructured grid; ParaView opens it.
    Vtu,
    /// Stanford PLY.
    Ply,
}

impl From<Format> for FrameFormat {
    fn from(format: Format) -> Self {
        match format {
            Format::Vtu => Self::Vtu,
            Format::Ply => Self::Ply,
        }
    }
}

impl SceneOptions {
    /// The scene of the file with `--set` applied.
    pub(super) fn load(&self) -> Result<Scene, Failure> {
        self.set
            .parse()
            .and_then(|overrides| Scene::load(&self.scene, &overrides))
            .map_err(|error| match error {
                SceneError::Syntax {
                    place: Place::File { .. },
                    ..
                } => Failure::Refused(with_kind(caret::of_scene(&error), &self.scene, Kind::Scene)),
                error => refused(error),
            })
    }

    /// The engine's refusal of the scene, in words for the user.
    pub(super) fn refuse(&self, error: &InstallError) -> Failure {
        Failure::Refused(format!("{}: {error}", self.scene.display()))
    }

    /// The requested number of threads, or the number of cores.
    pub(super) fn threads(&self) -> usize {
        self.threads.count()
    }
}

impl Set {
    /// The overrides.
    pub(super) fn parse(&self) -> Result<Vec<Override>, SceneError> {
        let texts = self.overrides.iter();
        texts.map(|text| Override::parse(text)).collect()
    }
}

impl Threads {
    /// The requested number of threads, or the number of cores.
    pub(super) fn count(&self) -> usize {
        self.threads
            .and_then(|threads| usize::try_from(threads).ok())
            .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, NonZero::get))
    }
}

impl Run {
    /// The scene that will run: the file's, with `--set` and the options that replace one of its fields.
    pub(super) fn effective_scene(&self) -> Result<Scene, Failure> {
        let mut scene = self.scene.load()?;
        if let Some(duration) = self.duration {
            scene.duration = duration;
        }
        if let Some(frames_per_second) = self.frames_per_second {
            scene.output.frames_per_second = frames_per_second;
        }
        scene.output.exact_times |= self.exact_times;
        if let Some(formats) = &self.format {
            scene.output.formats.clear();
            for &format in formats {
                let format = format.into();
                if !scene.output.formats.contains(&format) {
                    scene.output.formats.push(format);
                }
            }
        }
        if let Some(pictures) = self.pictures {
            scene.output.pictures = pictures;
        }
        if self.no_pictures {
            scene.output.pictures = false;
        }
        scene.check().map_err(refused)?;
        Ok(scene)
    }
}

fn refused(error: SceneError) -> Failure {
    Failure::Refused(caret::of_scene(&error))
}
