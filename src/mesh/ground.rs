//! Heights on a grid: from a grey PNG, a CSV file, or a formula.

use std::{f64::consts::TAU, path::Path};

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{error::MeshError, random::split_mix};
use crate::input::read_text;

/// Most points of a grid: two triangles for each can be read as a mesh.
const MOST_POINTS: usize = 2_500_000;

/// Heights on a grid of points, evenly over a rectangle.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ground {
    /// Points along x and z.
    pub(super) counts: [usize; 2],
    /// Heights \[m], along x first.
    pub(super) heights: Vec<f64>,
}

/// Ground by a formula, on a grid of points `cell` apart: from the middle of the rectangle, the height at (x, z) is
///
/// `h = Σ_k amplitude 2⁻ᵏ N_k(2ᵏ x / wavelength, 2ᵏ z / wavelength) − depth exp(−(2 (z − c) / width)⁴)`
///
/// for k from 0 to `octaves` − 1. `N_k` is value noise: at points with whole coordinates a random number from −1 to 1
/// that follows from the seed, between them the mean weighted with `6 t⁵ − 15 t⁴ + 10 t³` of the distance along each
/// axis. The second term is the bed of the `channel`, whose middle is at `c = meander sin(2π x / meander_length)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rolling {
    /// Seed of the noise.
    #[serde(default)]
    pub seed: u64,
    /// Greatest distance of two points of the grid \[m].
    pub cell: f64,
    /// Height of the largest hills above the mean \[m].
    #[serde(default)]
    pub amplitude: f64,
    /// Distance of the largest hills \[m].
    #[serde(default = "one")]
    pub wavelength: f64,
    /// Number of terms, each with half the height and half the wavelength of the one before.
    #[serde(default = "four")]
    pub octaves: u32,
    /// The bed of a river along x; none if absent.
    #[serde(default)]
    pub channel: Option<Channel>,
}

/// A bed along x in a ground.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Depth of its middle below its banks \[m].
    pub depth: f64,
    /// Width where it has e⁻¹ of its depth \[m].
    pub width: f64,
    /// How far it swings to either side \[m].
    #[serde(default)]
    pub meander: f64,
    /// Length of one swing along x \[m].
    #[serde(default = "one")]
    pub meander_length: f64,
}

fn one() -> f64 {
    1.0
}

fn four() -> u32 {
    4
}

pub(super) fn refuse(file: &Path, message: impl Into<String>) -> MeshError {
    MeshError::Heights {
        file: file.to_owned(),
        message: message.into(),
    }
}

/// Refuses a grid that is none, or too large, before its heights are taken in.
pub(super) fn proper([x, z]: [usize; 2]) -> Result<(), String> {
    if x < 2 || z < 2 {
        return Err(format!(
            "it has {x} × {z} points; at least 2 × 2 make a surface"
        ));
    }
    let fits = x.checked_mul(z).is_some_and(|all| all <= MOST_POINTS);
    if fits {
        return Ok(());
    }
    Err(format!(
        "it has {x} × {z} points, and at most {:.1} million are read; reduce it (its points need not be nearer than \
         the spacing)",
        MOST_POINTS as f64 / 1e6
    ))
}

impl Ground {
    /// A grey PNG, which a program without the feature does not read.
    #[cfg(not(feature = "images"))]
    pub(crate) fn image(file: &Path, _: f64, _: f64) -> Result<Self, MeshError> {
        let message = "this program was built without the feature `images`; build it with that, or write the heights \
                       as CSV";
        Err(refuse(file, message))
    }

    /// A CSV file of heights alone; metres in a unit of it.
    pub(crate) fn grid(file: &Path, scale: f64) -> Result<Self, MeshError> {
        let text = read_text(file);
        let text =
            text.map_err(|error| refuse(file, format!("the file cannot be read: {error}")))?;
        let mut heights = Vec::new();
        let mut counts = [0, 0];
        for (number, line) in (1..).zip(text.lines()) {
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let mut columns = 0;
            for field in line.split(',') {
                let height = field.trim().parse().ok();
                let height = height.filter(|height: &f64| height.is_finite());
                heights.push(scale * height.ok_or_else(|| {
                    let field = field.trim();
                    let message = format!(
                        "line {number}: `{field}` is not a height; write numbers with decimal points, separated by \
                         commas, and no names"
                    );
                    refuse(file, message)
                })?);
                columns += 1;
            }
            if counts[1] == 0 {
                counts[0] = columns;
            }
            if columns != counts[0] {
                let message = format!(
                    "line {number} has {columns} heights and the lines before it {}; every line is one z with the \
                     heights of all x",
                    counts[0]
                );
                return Err(refuse(file, message));
            }
            counts[1] += 1;
        }
        proper(counts).map_err(|message| refuse(file, message))?;
        Ok(Self { counts, heights })
    }

    /// The formula on a rectangle \[m].
    pub(crate) fn generated(rolling: &Rolling, size: [f32; 2]) -> Result<Self, MeshError> {
        let written = size;
        let size = size.map(f64::from);
        let points = size.map(|size| (size / rolling.cell).ceil().max(1.0) + 1.0);
        let all = points[0] * points[1];
        if all > MOST_POINTS as f64 {
            let better = rolling.cell * (1.05 * all / MOST_POINTS as f64).sqrt();
            return Err(MeshError::Surface(format!(
                "a `cell` of {} m makes {:.1} million points of {} × {} m, and at most {:.1} million are possible; \
                 {better:.2e} m would do",
                rolling.cell,
                all / 1e6,
                written[0],
                written[1],
                MOST_POINTS as f64 / 1e6
            )));
        }
        let counts = points.map(|points| points as usize);
        let at = |axis: usize, k: usize| size[axis] * (k as f64 / (counts[axis] - 1) as f64 - 0.5);
        let height = |k: usize| rolling.height(at(0, k % counts[0]), at(1, k / counts[0]));
        Ok(Self {
            counts,
            heights: (0..counts[0] * counts[1]).map(height).collect(),
        })
    }
}

impl Rolling {
    /// Height at a place \[m].
    pub fn height(&self, x: f64, z: f64) -> f64 {
        let hills: f64 = (0..self.octaves)
            .map(|k| {
                let finer = f64::from(k).exp2();
                let place = DVec2::new(x, z) * (finer / self.wavelength);
                self.amplitude / finer * self.noise(k, place)
            })
            .sum();
        let bed = self.channel.map_or(0.0, |channel| {
            let middle = channel.meander * (TAU * x / channel.meander_length).sin();
            let aside = 2.0 * (z - middle) / channel.width;
            channel.depth * (-aside.powi(4)).exp()
        });
        hills - bed
    }

    fn noise(&self, octave: u32, place: DVec2) -> f64 {
        let low = place.floor();
        let t = place - low;
        let part = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let value = |i: f64, j: f64| {
            let mut state = self.seed;
            for number in [f64::from(octave), low.x + i, low.y + j] {
                state = split_mix(&mut state) ^ (number as i64 as u64);
            }
            2.0 * (split_mix(&mut state) >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
        };
        let row = |j: f64| value(0.0, j) + part.x * (value(1.0, j) - value(0.0, j));
        row(0.0) + part.y * (row(1.0) - row(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said<T: std::fmt::Debug>(result: Result<T, MeshError>) -> String {
        result.expect_err("refused").to_string()
    }

    fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).expect("a file");
        (folder, file)
    }

    #[test]
    fn a_grid_is_read_line_by_line() {
        let (_folder, file) = written("h.csv", b"# heights\n1, 2,3\n\n4,5,6\n");
        let ground = Ground::grid(&file, 0.5).expect("heights");
        assert_eq!(ground.counts, [3, 2]);
        assert_eq!(ground.heights, [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
    }

    #[test]
    fn what_holds_no_heights_is_refused_with_its_place() {
        for (text, expected) in [
            ("1,2\n3\n", "line 2 has 1 heights and the lines before it 2"),
            ("1,2\n# a\n3,x\n", "line 3: `x` is not a height"),
            ("x,z\n1,2\n", "line 1: `x`"),
            ("1,2\n3,inf\n", "line 2: `inf`"),
            ("1,2,3\n", "3 × 1 points; at least 2 × 2"),
            ("", "0 × 0 points"),
        ] {
            let (_folder, file) = written("h.csv", text.as_bytes());
            let error = said(Ground::grid(&file, 1.0));
            assert!(
                error.contains(expected) && error.contains("h.csv"),
                "{error}"
            );
        }
    }

    fn rolling() -> Rolling {
        Rolling {
            seed: 7,
            cell: 0.5,
            amplitude: 2.0,
            wavelength: 20.0,
            octaves: 4,
            channel: None,
        }
    }

    /// The noise is smooth, stays within the sum of its terms, and follows from the seed.
    #[test]
    fn the_formula_is_what_it_says() {
        let ground = rolling();
        let step = 1e-4;
        let mut spread = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..4000 {
            let (x, z) = (0.37 * f64::from(k) - 400.0, 0.11 * f64::from(k % 997));
            let height = ground.height(x, z);
            spread = (spread.0.min(height), spread.1.max(height));
            assert!(height.abs() < 4.0);
            assert!((ground.height(x + step, z) - height).abs() < 20.0 * step);
        }
        assert!(spread.1 - spread.0 > 2.0, "{spread:?}");
        let other = Rolling { seed: 8, ..ground };
        assert!((other.height(3.0, 4.0) - ground.height(3.0, 4.0)).abs() > 1e-3);
        let channel = Channel {
            depth: 3.0,
            width: 4.0,
            meander: 5.0,
            meander_length: 40.0,
        };
        let river = Rolling {
            amplitude: 0.0,
            channel: Some(channel),
            ..ground
        };
        assert_eq!(river.height(0.0, 0.0), -3.0);
        assert!((river.height(10.0, 5.0) + 3.0).abs() < 1e-12);
        assert!((river.height(0.0, 2.0) + 3.0 / std::f64::consts::E).abs() < 1e-12);
        let fine = Rolling {
            cell: 1e-3,
            ..ground
        };
        assert!(said(Ground::generated(&fine, [100.0, 100.0])).contains("would do"));
    }
}
