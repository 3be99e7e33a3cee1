//! A movie of the pictures of a run, by ffmpeg, where it is installed.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

use super::exit::Failure;

/// Name of the movie in the folder of the run.
pub(super) const MOVIE: &str = "movie.mp4";

/// Outcome of a movie.
pub(super) enum Movie {
    /// It was written.
    Written,
    /// There is no ffmpeg on the path; this command would write it.
    Command(String),
}

/// Joins the pictures in a folder to a movie \[frames a second].
pub(super) fn write(pictures: &Path, to: &Path, rate: f32) -> Result<Movie, Failure> {
    let pictures = pictures.join("frame_%05d.png");
    let rate = if rate > 0.0 { rate } else { 25.0 };
    let arguments = [
        "-y",
        "-loglevel",
        "error",
        "-framerate",
        &rate.to_string(),
        "-i",
        &pictures.display().to_string(),
        // Even sizes, and colours that every player shows.
        "-vf",
        "pad=ceil(iw/2)*2:ceil(ih/2)*2",
        "-pix_fmt",
        "yuv420p",
        &to.display().to_string(),
    ]
    .map(str::to_owned);
    let made = Command::new("ffmpeg")
        .args(&arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .output();
    match made {
        Ok(output) if output.status.success() => Ok(Movie::Written),
        Ok(output) => Err(Failure::Failed(format!(
            "ffmpeg could not write {}: {}",
            to.display(),
            String::from_utf8_lossy(&output.stderr).trim()
        ))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let quoted = arguments.map(|word| match word.contains(['(', ' ', '%']) {
                true => format!("'{word}'"),
                false => word,
            });
            Ok(Movie::Command(format!("ffmpeg {}", quoted.join(" "))))
        }
        Err(error) => Err(Failure::Failed(format!("cannot start ffmpeg: {error}"))),
    }
}
