//! A finished picture.

use std::path::Path;

use crate::output::OutputError;
use crate::output::atomic::write_atomically;

/// A picture of 8-bit sRGB pixels, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Red, green, blue of every pixel.
    pub(super) rgb: Vec<u8>,
}

impl Image {
    pub(super) fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self {
            width,
            height,
            rgb: colour.repeat(width * height),
        }
    }

    /// Width \[pixels].
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height \[pixels].
    pub fn height(&self) -> usize {
        self.height
    }

    /// Red, green and blue of a pixel, counted from the top left; `None` outside.
    pub fn pixel(&self, x: usize, y: usize) -> Option<[u8; 3]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let at = 3 * (y * self.width + x);
        Some([self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]])
    }

    /// Red, green, blue of every pixel, rows from the top.
    pub fn as_rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// Writes a PNG file, atomically.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn write_png(&self, path: &Path) -> Result<(), OutputError> {
        write_atomically(path, |out| {
            // Sizes come from `u32` (see `View::with_size`) or are those of a sheet in memory.
            let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&self.rgb)?;
            writer.finish()?;
            Ok(())
        })
    }

    /// The picture at a smaller size: every pixel is the mean of those it covers.
    pub(super) fn shrunk(&self, width: usize, height: usize) -> Self {
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let rows = span(y, height, self.height);
            for x in 0..width {
                let columns = span(x, width, self.width);
                let count = (rows.len() * columns.len()) as u32;
                let mut sum = [count / 2; 3];
                for row in rows.clone() {
                    for column in columns.clone() {
                        let at = 3 * (row * self.width + column);
                        for (sum, value) in sum.iter_mut().zip(&self.rgb[at..at + 3]) {
                            *sum += u32::from(*value);
                        }
                    }
                }
                rgb.extend(sum.map(|sum| (sum / count) as u8));
            }
        }
        Self { width, height, rgb }
    }
}

/// The pixels of a row of `from` pixels that pixel `i` of `to` covers, at least one.
fn span(i: usize, to: usize, from: usize) -> std::ops::Range<usize> {
    let start = i * from / to;
    start..((i + 1) * from / to).max(start + 1)
}
