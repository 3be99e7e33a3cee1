//! Memory that a picture takes while it is drawn: asked for as a whole before, because a process that finds none in the
//! middle is ended.

use super::image::Image;
use super::raster::SAMPLES;
use super::view::View;
use crate::memory::{in_words, is_left};
use crate::output::OutputError;

/// Depth and surface of a sample \[bytes].
const SAMPLE: usize = 8;
/// A pixel in linear light, its red, green and blue, and as much once more in the file \[bytes].
const PIXEL: usize = 12 + 3 + 3;
/// The first depth of a pixel, for occlusion \[bytes].
const DEPTH: usize = 4;
/// Bands of rows that a particle touches, at most and on average.
const MOST_BANDS: f64 = 4.0;
const BANDS: f64 = 1.2;
/// What the encoder, colours, text and the threads hold besides, and steps that go on meanwhile \[bytes].
const BESIDE: usize = 16 << 20;

impl View {
    /// Memory that drawing a picture takes, whatever is on it \[bytes].
    fn bytes_of_pixels(&self) -> f64 {
        let (width, height) = self.size();
        let pixels = width as f64 * height as f64;
        let lit = self
            .shadow_projection()
            .map_or(0.0, |(_, size)| (size * size) as f64);
        let samples = pixels * (SAMPLES * SAMPLES) as f64 + lit;
        samples * SAMPLE as f64 + pixels * (PIXEL + DEPTH) as f64
    }

    /// Memory that a picture of so many particles takes while it is drawn \[bytes].
    pub(in crate::output) fn expected_bytes(&self, particles: f64) -> f64 {
        // The bands of one layer are gone before the next is drawn; the colours are there all the time.
        let particle = BANDS * size_of::<u32>() as f64 + size_of::<f32>() as f64;
        self.bytes_of_pixels() + particles * particle
    }

    /// Fails if the process cannot have the memory that a picture of so many particles, or triangles of a surface,
    /// takes while it is drawn.
    ///
    /// # Errors
    /// [`OutputError::NoMemory`]
    pub fn check_memory(&self, particles: usize) -> Result<(), OutputError> {
        let particle = MOST_BANDS * size_of::<u32>() as f64 + size_of::<f32>() as f64;
        let bytes = self.bytes_of_pixels() + particles as f64 * particle;
        // The cast of what is too large is the largest number.
        check(self.size(), (bytes as usize).saturating_add(BESIDE))
    }
}

impl Image {
    /// The same for as many pictures as large as this on one sheet.
    ///
    /// # Errors
    /// [`OutputError::NoMemory`]
    pub fn check_memory_of_sheet(&self, pictures: usize) -> Result<(), OutputError> {
        // The sheet, and its file.
        let bytes = self.rgb.len().saturating_mul(2 * pictures);
        check((self.width, self.height), bytes.saturating_add(BESIDE))
    }
}

fn check((width, height): (usize, usize), bytes: usize) -> Result<(), OutputError> {
    if is_left(bytes) {
        return Ok(());
    }
    Err(OutputError::NoMemory {
        width,
        height,
        needed: in_words(bytes as f64),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn a_picture_beyond_all_memory_is_refused_in_words() {
        for dimension in [2, 3] {
            let text = format!(
                "(name: \"a\", dimension: {dimension}, spacing: 0.1,
                  bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))])"
            );
            let scene = Scene::parse(&text, "a.ron", &[]).expect("a scene");
            let view = View::from_scene(&scene);
            view.check_memory(1000).expect("memory for a small picture");
            for (size, particles) in [((u32::MAX, u32::MAX), 0), ((960, 540), usize::MAX / 64)] {
                let large = view.clone().with_size(size.0, size.1);
                let error = large.check_memory(particles).expect_err("no memory");
                assert!(error.to_string().contains("GB"), "{error}");
            }
        }
    }
}
