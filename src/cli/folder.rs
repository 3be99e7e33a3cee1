//! The folder of a run: the names of its files and folders.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use overfall::output::{OutputError, write_atomically};
use overfall::scene::{FrameFormat, Scene};

use super::claims::Claims;
use super::exit::Failure;
use super::manifest::{create_folder, failed, is_absent};
use super::scene_copy::SceneCopy;
use super::writer::Writer;

/// The parent folder of runs and studies without `--out`.
const DEFAULT_PARENT: &str = "out";

/// Names in the folder, relative to it.
pub(super) const HISTORY: &str = "history.csv";
pub(super) const SUMMARY: &str = "summary.json";
pub(super) const CHECKPOINT: &str = "checkpoint.overfall";
pub(super) const CONTACT_SHEET: &str = "contact_sheet.png";
const RESERVE: &str = ".overfall_reserve";
const FRAMES: &str = "frames";
const PICTURES: &str = "pictures";
const GAUGES: &str = "gauges";
pub(super) const BOUNDARY: &str = "boundary";
pub(super) const BOUNDARY_FILE: &str = "boundary.vtu";
pub(super) const BOUNDARY_SERIES: &str = "boundary.pvd";

/// Folders of files with the numbers of frames, and the suffixes of these.
const NUMBERED: [(&str, &str); 4] = [
    (FRAMES, "vtu"),
    (FRAMES, "ply"),
    (PICTURES, "png"),
    (BOUNDARY, "vtu"),
];

/// Disk space that is reserved for the summary in case the disk is full at the end \[bytes]; a summary has about 1500.
const RESERVE_BYTES: usize = 1 << 12;

/// The folder of a run or a study: `out`, or `out/<its name>` by default.
pub(super) fn root(out: Option<&Path>, name: &str) -> PathBuf {
    out.map_or_else(
        || Path::new(DEFAULT_PARENT).join(file_name(name)),
        Path::to_owned,
    )
}

/// The folder of one run:
///
/// ```text
/// out/dam_break/
///   history.csv         one row per step
///   gauges/wall.csv     one row per reading; a chart beside it if there is reference data
///   summary.json        results
///   checkpoint.overfall state to resume from, if requested or if the run was interrupted
///   dam_break.pvd       the frames as one animation
///   boundary.vtu        the boundary particles; where walls move, boundary.pvd and boundary/frame_00000.vtu
///   contact_sheet.png   a dozen pictures on one sheet
///   frames/frame_00000.vtu
///   pictures/frame_00000.png
///   surfaces/, surface_pictures/, surface.pvd   what `overfall surface` wrote
///   scene/              the scene as it ran, overrides applied, and the files that it names
/// ```
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RunFolder {
    root: PathBuf,
    /// The scene's name, made valid as a file name.
    name: String,
}

impl RunFolder {
    /// The folder of a run of a scene: `out`, or `out/<scene name>` by default.
    pub(super) fn new(out: Option<&Path>, scene_name: &str) -> Self {
        Self {
            root: root(out, scene_name),
            name: file_name(scene_name),
        }
    }

    /// The folder of a finished run.
    pub(super) fn open(root: &Path) -> Self {
        Self::new(Some(root), "")
    }

    /// Prepares the folder for a run of a scene, see [`Claims::start`].
    pub(super) fn prepare(
        &mut self,
        writer: &Writer,
        scene: &Scene,
        copy: &SceneCopy,
    ) -> Result<(Claims, Option<PathBuf>), Failure> {
        let mut planned = vec![
            HISTORY.into(),
            SUMMARY.into(),
            RESERVE.into(),
            CHECKPOINT.into(),
            self.series(),
            BOUNDARY_FILE.into(),
            BOUNDARY_SERIES.into(),
        ];
        planned.extend(copy.names().map(str::to_owned));
        if scene.output.pictures {
            planned.push(CONTACT_SHEET.into());
        }
        for name in scene.gauges.iter().map(|gauge| &gauge.name) {
            planned.extend([gauge(name), gauge_chart(name)]);
        }
        // The number of frames is not known yet: no file with the name of a frame may exist.
        for (folder, extension) in NUMBERED {
            for extension in [extension, &format!("{extension}.partial")] {
                let files = numbered_files(&self.root.join(folder), extension)?;
                let names = files
                    .iter()
                    .filter_map(|(_, path)| path.file_name()?.to_str());
                planned.extend(names.map(|name| {
                    let name = name.strip_suffix(".partial").unwrap_or(name);
                    format!("{folder}/{name}")
                }));
            }
        }
        let started = Claims::start(&self.root, writer, &planned)?;
        started.0.root().clone_into(&mut self.root);
        create_folder(&self.frames())?;
        if scene.output.pictures {
            self.create_pictures()?;
        }
        Ok(started)
    }

    /// Prepares the folder for a run that resumes after this number of frames: later frames are removed.
    pub(super) fn reopen(
        &self,
        writer: &Writer,
        scene: &Scene,
        frames: usize,
    ) -> Result<Claims, Failure> {
        let claims = Claims::go_on(&self.root, writer)?;
        for (folder, extension) in NUMBERED {
            for (number, path) in numbered_files(&self.root.join(folder), extension)? {
                let name = format!("{folder}/{STEM}{number:05}.{extension}");
                if number >= frames as u64 && claims.is_ours(&name) {
                    fs::remove_file(&path)
                        .map_err(|error| failed("cannot remove the later", &path, &error))?;
                }
            }
        }
        create_folder(&self.frames())?;
        if scene.output.pictures {
            self.create_pictures()?;
        }
        Ok(claims)
    }

    /// Puts the results of a run that is done where they belong, see [`Claims::complete`].
    pub(super) fn complete(&mut self, claims: &Claims) -> Result<(), Failure> {
        claims.complete()?;
        self.root = claims.place(&self.root);
        Ok(())
    }

    /// Creates the folder of the pictures, if it does not exist.
    pub(super) fn create_pictures(&self) -> Result<(), Failure> {
        create_folder(&self.pictures())
    }

    /// The existing frames in a format, by number.
    pub(super) fn written_frames(
        &self,
        format: FrameFormat,
    ) -> Result<Vec<(u64, PathBuf)>, Failure> {
        numbered_files(&self.frames(), format.extension())
    }

    /// The folder itself.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// A file of the folder, by its name relative to it.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// The frames as one animation, relative to the folder.
    pub(super) fn series(&self) -> String {
        format!("{}.pvd", self.name)
    }

    /// The folder of the frames.
    pub(super) fn frames(&self) -> PathBuf {
        self.root.join(FRAMES)
    }

    /// The folder of the gauges' files.
    pub(super) fn gauges(&self) -> PathBuf {
        self.root.join(GAUGES)
    }

    /// The folder of the pictures.
    pub(super) fn pictures(&self) -> PathBuf {
        self.root.join(PICTURES)
    }
}

/// A frame, relative to the folder.
pub(super) fn frame(number: u64, format: FrameFormat) -> String {
    format!("{FRAMES}/{STEM}{number:05}.{}", format.extension())
}

/// The boundary particles at the time of a frame, relative to the folder.
pub(super) fn boundary_frame(number: u64) -> String {
    format!("{BOUNDARY}/{STEM}{number:05}.vtu")
}

/// The picture of a frame, relative to the folder.
pub(super) fn picture(number: u64) -> String {
    format!("{PICTURES}/{STEM}{number:05}.png")
}

/// The readings of a gauge, relative to the folder.
pub(super) fn gauge(name: &str) -> String {
    format!("{GAUGES}/{name}.csv")
}

/// The chart of a gauge, relative to the folder.
pub(super) fn gauge_chart(name: &str) -> String {
    format!("{GAUGES}/{name}.svg")
}

/// Disk space reserved for the summary, which is needed most when the disk is full.
pub(super) struct Reserve(PathBuf);

impl Reserve {
    /// Reserves the space.
    pub(super) fn take(claims: &Claims) -> Result<Self, OutputError> {
        let path = claims.claim(RESERVE)?;
        // A file of zeros might be stored as a hole, without space.
        write_atomically(&path, |out| {
            io::Write::write_all(out, &[b'-'; RESERVE_BYTES])
        })?;
        Ok(Self(path))
    }

    /// Frees the space.
    pub(super) fn release(self) {
        // If it cannot be removed, no space is gained, and writing the summary reports the error.
        let _ = fs::remove_file(self.0);
    }
}

/// Prefix of the names of frames and pictures.
pub(super) const STEM: &str = "frame_";

/// The number in the name of a frame or a picture; `None` if the name has another form.
fn number(name: &str, extension: &str) -> Option<u64> {
    let digits = name
        .strip_prefix(STEM)?
        .strip_suffix(extension)?
        .strip_suffix('.')?;
    let is_ours = digits.len() >= 5 && digits.bytes().all(|byte| byte.is_ascii_digit());
    is_ours.then(|| digits.parse().ok()).flatten()
}

/// The files named like ours in a folder, by number. A missing folder has none.
pub(super) fn numbered_files(
    folder: &Path,
    extension: &str,
) -> Result<Vec<(u64, PathBuf)>, Failure> {
    let read = || -> io::Result<Vec<(u64, PathBuf)>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            if let Some(number) = name.and_then(|name| number(name, extension)) {
                files.push((number, path));
            }
        }
        files.sort();
        Ok(files)
    };
    match read() {
        Err(error) if is_absent(&error) => Ok(Vec::new()),
        files => files.map_err(|error| failed("cannot read the folder", folder, &error)),
    }
}

/// Longest folder name that is derived from the name of a scene or a study \[bytes]. File systems allow 255, suffixes
/// included.
const LONGEST_NAME: usize = 120;

/// The name of a scene or a study as a file name: characters that could leave the folder or have a meaning in a shell
/// become `_`. Changed names get a number computed from the original, so that different names keep different folders.
fn file_name(name: &str) -> String {
    let mut plain: String = name
        .chars()
        .map(|c| match c {
            '-' | '_' | '.' => c,
            c if c.is_alphanumeric() => c,
            _ => '_',
        })
        .collect();
    plain.truncate(plain.floor_char_boundary(LONGEST_NAME));
    let plain = plain.trim_start_matches('.');
    if plain == name && !plain.is_empty() {
        return plain.to_owned();
    }
    // FNV-1a hash: the same on every machine and in every version.
    let number = name.bytes().fold(0x811c_9dc5_u32, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    });
    let plain = if plain.is_empty() { "scene" } else { plain };
    format!("{plain}-{number:08x}")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::manifest::stays_inside;
    use super::*;

    #[test]
    fn only_names_of_our_own_have_a_number() {
        assert_eq!(number("frame_00012.vtu.partial", "vtu.partial"), Some(12));
        let number = |name: &str| number(name, "vtu");
        assert_eq!(number("frame_00012.vtu"), Some(12));
        assert_eq!(number("frame_123456.vtu"), Some(123_456));
        for foreign in [
            "frame_12.vtu",
            "frame_00012.ply",
            "frame_00012.vtu.bak",
            "frame_0001a.vtu",
            "frame_+0001.vtu",
            "my_frame_00012.vtu",
            "frame_.vtu",
        ] {
            assert_eq!(number(foreign), None, "{foreign}");
        }
    }

    #[test]
    fn names_stay_inside_and_are_told_apart() {
        for name in ["dam_break", "Überfall-2.5", "a.b"] {
            assert_eq!(file_name(name), name);
        }
        let long = "x".repeat(1000);
        let longer = "x".repeat(1001);
        let names = [
            "a b",
            "a_b",
            "a\u{1b}b",
            "a/b",
            "..",
            "",
            ".",
            "../../etc",
            &long,
            &longer,
        ];
        let files: BTreeSet<_> = names.iter().map(|name| file_name(name)).collect();
        assert_eq!(files.len(), names.len(), "{files:?}");
        for file in &files {
            assert!(stays_inside(file) && file.len() < 200, "{file}");
            assert!(
                !file.starts_with('.') && !file.contains(char::is_control),
                "{file}"
            );
        }
    }
}
