//! `overfall surface`: the surfaces of a finished run's frames as meshes and pictures.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
#[cfg(feature = "surface")]
use overfall::output::surface::SurfaceFormat;

#[cfg(not(feature = "surface"))]
use super::exit::{Exit, Failure};
use super::looks::{self, Map};
#[cfg(feature = "surface")]
use super::looks::{Colour, Looks};
use super::{numbers::positive, options::Threads};

/// Options of `overfall surface`.
#[derive(Args, Debug)]
#[cfg_attr(
    not(feature = "surface"),
    allow(dead_code, reason = "the help has all options in every build")
)]
pub(super) struct Surface {
    /// The folder of a run, e.g. out/glass_small.
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(super) folder: PathBuf,
    /// File formats of the meshes.
    #[arg(
        long,
        value_name = "FORMAT,…",
        value_delimiter = ',',
        default_value = "vtu"
    )]
    format: Vec<Format>,
    /// Radius of a particle \[m]; half of the scene's spacing by default.
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(super) particle_radius: Option<f32>,
    /// Smoothing length \[particle radii].
    #[arg(long, value_name = "L", value_parser = positive, default_value = "2")]
    pub(super) smoothing_length: f32,
    /// Edge of the cubes of which the surface is made \[particle radii]; half the edge makes four times the triangles.
    #[arg(long, value_name = "L", value_parser = positive, default_value = "0.5")]
    pub(super) cube_size: f32,
    /// Part of the rest density at which the surface is.
    #[arg(long, value_name = "PART", value_parser = positive, default_value = "0.6")]
    pub(super) threshold: f32,
    /// Passes that smooth the surface; 0 leaves it as it is found.
    #[arg(long, value_name = "N", default_value = "25")]
    #[arg(value_parser = clap::value_parser!(u16).range(..=1000))]
    pub(super) smoothing: u16,
    /// Draw no pictures.
    #[arg(long, conflicts_with = "movie")]
    pub(super) no_pictures: bool,
    /// Width and height of the pictures \[pixels], e.g. 1280x720 or 1920x1080.
    #[arg(long, value_name = "WxH", value_parser = looks::size)]
    size: Option<(u32, u32)>,
    /// Camera that moves: a CSV file with columns t, x, y, z, target_x, target_y, target_z and, if wanted,
    /// field_of_view. By default the scene's.
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub(super) camera: Option<PathBuf>,
    /// Speeds at the two ends of the colours \[m/s], e.g. 0..2; up to free fall through the scene by default.
    #[arg(long, value_name = "LOW..HIGH", value_parser = looks::range, allow_hyphen_values = true)]
    range: Option<(f32, f32)>,
    /// The colours.
    #[arg(long, value_enum, default_value_t, value_name = "MAP")]
    colours: Map,
    /// Draw obstacles that are meshes or surfaces of revolution as glass.
    #[arg(long)]
    pub(super) glass: bool,
    /// Join the pictures to surface.mp4 with ffmpeg; if that is not installed, print the command.
    #[arg(long)]
    pub(super) movie: bool,
    /// Show no progress.
    #[arg(long)]
    pub(super) quiet: bool,
    #[command(flatten)]
    pub(super) threads: Threads,
}

/// [`SurfaceFormat`] in the notation of the command line.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    /// VTK XML unstructured grid with velocities; ParaView opens it, and surface.pvd with all of them.
    Vtu,
    /// Stanford PLY with velocities.
    Ply,
    /// Wavefront OBJ, without velocities.
    Obj,
}

#[cfg(feature = "surface")]
impl Surface {
    /// The formats, each once.
    pub(super) fn formats(&self) -> Vec<SurfaceFormat> {
        let mut formats = Vec::new();
        for format in &self.format {
            let format = match format {
                Format::Vtu => SurfaceFormat::Vtu,
                Format::Ply => SurfaceFormat::Ply,
                Format::Obj => SurfaceFormat::Obj,
            };
            if !formats.contains(&format) {
                formats.push(format);
            }
        }
        formats
    }

    /// How the pictures look.
    pub(super) fn looks(&self) -> Looks {
        Looks {
            size: self.size,
            colour: Colour::Speed,
            range: self.range,
            colours: self.colours,
            camera: None,
        }
    }
}

/// Says what the program lacks.
#[cfg(not(feature = "surface"))]
pub(super) fn refuse(options: &Surface) -> Result<Exit, Failure> {
    let Surface { folder, .. } = options;
    Err(Failure::Refused(format!(
        "{}: this program was built without surfaces; build it with them: cargo build --release --features surface",
        folder.display()
    )))
}
