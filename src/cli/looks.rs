//! How pictures of a run look: size, what colours show, range, colours.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum, ValueHint};
use overfall::output::picture::{CameraPath, ColourMap, Quantity, View};
use overfall::output::{Frame, OutputError};

use super::exit::Failure;

/// Options of pictures.
#[derive(Args, Debug)]
pub(super) struct Looks {
    /// Width and height \[pixels], e.g. 1280x720 or 1920x1080.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// What colours show.
    #[arg(long, value_enum, default_value_t, value_name = "QUANTITY")]
    pub(super) colour: Colour,
    /// Values at the two ends of the colours, e.g. 0..20, in the unit of the quantity. By default those of the frames
    /// (of speed: free fall through the scene).
    #[arg(long, value_name = "LOW..HIGH", value_parser = range, allow_hyphen_values = true)]
    pub(super) range: Option<(f32, f32)>,
    /// The colours.
    #[arg(long, value_enum, default_value_t, value_name = "MAP")]
    pub(super) colours: Map,
    /// Camera that moves: a CSV file with columns t, x, y, z, target_x, target_y, target_z and, if wanted,
    /// field_of_view. By default the scene's.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(super) camera: Option<PathBuf>,
}

/// What colours show.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Colour {
    /// Speed \[m/s].
    #[default]
    Speed,
    /// Mean acceleration since the frame before \[m/s²].
    Acceleration,
    /// Pressure \[Pa].
    Pressure,
    /// Density \[kg/m³].
    Density,
    /// Permanent number.
    Id,
    /// Place in memory: neighbours in space of like colour are neighbours in memory.
    Row,
}

/// Colours along the range.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Map {
    /// Blue to white.
    #[default]
    Water,
    /// Dark red to pale yellow.
    Fire,
    /// Violet to red, through all hues.
    Spectrum,
    /// Dark to light.
    Grey,
    /// Dark red to rose.
    Wine,
}

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let sizes = text.split_once(['x', 'X', '×']);
    let sizes = sizes.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match sizes {
        Some((width, height)) if (16..=8192).contains(&width) && (16..=8192).contains(&height) => {
            Ok((width, height))
        }
        Some(_) => Err("each edge must be from 16 to 8192 pixels".to_owned()),
        None => Err("write width and height with an x between, such as 1280x720".to_owned()),
    }
}

pub(super) fn range(text: &str) -> Result<(f32, f32), String> {
    let ends = text.split_once("..");
    let ends = ends.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    let ends = ends.filter(|(low, high): &(f32, f32)| low.is_finite() && high.is_finite());
    match ends {
        Some((low, high)) if low < high => Ok((low, high)),
        Some(_) => Err("the first value must be below the second".to_owned()),
        None => Err("write two numbers with two dots between, such as 0..20".to_owned()),
    }
}

/// The path of a camera in a file, if there is one.
pub(super) fn path(file: Option<&Path>) -> Result<Option<Arc<CameraPath>>, Failure> {
    let path = file.map(CameraPath::load).transpose();
    let path = path.map_err(|error| Failure::Refused(format!("--camera: {error}")))?;
    Ok(path.map(Arc::new))
}

impl Looks {
    /// The view with these looks. The frames are read once for the range, unless it is given or known without them.
    pub(super) fn of(&self, view: View, frames: &[(u64, PathBuf)]) -> Result<View, OutputError> {
        let quantity = match self.colour {
            Colour::Speed => Quantity::Speed,
            Colour::Acceleration => Quantity::Acceleration,
            Colour::Pressure => Quantity::Pressure,
            Colour::Density => Quantity::Density,
            Colour::Id => Quantity::Id,
            Colour::Row => Quantity::Row,
        };
        let colours = match self.colours {
            Map::Water => ColourMap::Water,
            Map::Fire => ColourMap::Fire,
            Map::Spectrum => ColourMap::Spectrum,
            Map::Grey => ColourMap::Grey,
            Map::Wine => ColourMap::Wine,
        };
        let (low, high) = match (self.range, quantity) {
            (Some(range), _) => range,
            (None, Quantity::Speed) => view.range,
            (None, _) => range_of(quantity, frames)?,
        };
        let (width, height) = self.size.unwrap_or((view.width, view.height));
        let view = view.of(quantity, colours).with_range(low, high);
        Ok(view.with_size(width, height))
    }
}

/// Between which values nearly all particles of all frames are: a few of each frame may be beyond.
fn range_of(quantity: Quantity, frames: &[(u64, PathBuf)]) -> Result<(f32, f32), OutputError> {
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    let mut before: Option<Frame> = None;
    for (_, path) in frames {
        let frame = Frame::read(path)?;
        let mut values = quantity.values(&frame, before.as_ref());
        before = Some(frame);
        values.retain(|value| value.is_finite());
        if values.is_empty() {
            continue;
        }
        values.sort_by(f32::total_cmp);
        let beyond = match quantity {
            Quantity::Id | Quantity::Row => 0,
            _ => values.len() / 100,
        };
        low = low.min(values[beyond]);
        high = high.max(values[values.len() - 1 - beyond]);
    }
    Ok(if low < high { (low, high) } else { (0.0, 1.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_ranges_are_read_or_refused() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        assert_eq!(range("-1.5..20"), Ok((-1.5, 20.0)));
        for wrong in ["1280", "ax2", "0x720", "99999x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
        for wrong in ["1", "2..1", "a..b", "0..inf", "NaN..1"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
