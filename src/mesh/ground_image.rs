//! Heights from a grey PNG.

use std::{io::Cursor, path::Path};

use super::{
    error::MeshError,
    ground::{Ground, proper, refuse},
};
use crate::input::read_bytes;

impl Ground {
    /// A grey PNG; heights of black and of white \[m].
    pub(crate) fn image(file: &Path, black: f64, white: f64) -> Result<Self, MeshError> {
        let bytes = read_bytes(file);
        let bytes =
            bytes.map_err(|error| refuse(file, format!("the file cannot be read: {error}")))?;
        let wrong = |error: png::DecodingError| {
            refuse(
                file,
                format!("it is no PNG that can be read ({error}); save it as a grey PNG"),
            )
        };
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        // One byte or two for every point.
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(wrong)?;
        let (kind, depth) = reader.output_color_type();
        if kind != png::ColorType::Grayscale {
            return Err(refuse(
                file,
                format!(
                    "it has colours or transparency ({kind:?}); save it in grey without transparency"
                ),
            ));
        }
        let counts = [reader.info().width as usize, reader.info().height as usize];
        proper(counts).map_err(|message| refuse(file, message))?;
        let mut data = vec![0; reader.output_buffer_size().unwrap_or_default()];
        reader.next_frame(&mut data).map_err(wrong)?;
        let shades: Vec<f64> = match depth {
            png::BitDepth::Sixteen => (data.as_chunks::<2>().0.iter())
                .map(|pair| f64::from(u16::from_be_bytes(*pair)) / f64::from(u16::MAX))
                .collect(),
            _ => (data.iter())
                .map(|shade| f64::from(*shade) / f64::from(u8::MAX))
                .collect(),
        };
        let heights = shades.into_iter().take(counts[0] * counts[1]);
        Ok(Self {
            counts,
            heights: heights
                .map(|shade| black + shade * (white - black))
                .collect(),
        })
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

    fn image(kind: png::ColorType, depth: png::BitDepth, size: [u32; 2], data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(kind);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().expect("a header");
        writer.write_image_data(data).expect("data");
        writer.finish().expect("an end");
        bytes
    }

    /// Grey of 1, 8 and 16 bits is the height between black and white, row by row.
    #[test]
    fn grey_images_are_heights() {
        use png::{BitDepth, ColorType};
        for (depth, data, expected) in [
            (
                BitDepth::One,
                vec![0b0100_0000, 0b1000_0000],
                [0.0, 1.0, 1.0, 0.0],
            ),
            (BitDepth::Eight, vec![0, 255, 51, 102], [0.0, 1.0, 0.2, 0.4]),
            (
                BitDepth::Sixteen,
                vec![0, 0, 255, 255, 51, 51, 102, 102],
                [0.0, 1.0, 0.2, 0.4],
            ),
        ] {
            let bytes = image(ColorType::Grayscale, depth, [2, 2], &data);
            let (_folder, file) = written("h.png", &bytes);
            let ground = Ground::image(&file, -1.0, 3.0).expect("heights");
            assert_eq!(ground.counts, [2, 2]);
            for (height, shade) in ground.heights.iter().zip(expected) {
                assert!((height - (4.0 * shade - 1.0)).abs() < 1e-12, "{height}");
            }
        }
    }

    #[test]
    fn images_without_heights_are_refused_with_their_name() {
        use png::{BitDepth, ColorType};
        let colours = image(ColorType::Rgb, BitDepth::Eight, [2, 2], &[0; 12]);
        let small = image(ColorType::Grayscale, BitDepth::Eight, [4, 1], &[0; 4]);
        let mut cut = image(ColorType::Grayscale, BitDepth::Eight, [20, 20], &[7; 400]);
        cut.truncate(cut.len() - 20);
        for (bytes, expected) in [
            (&b"P5 2 2 255"[..], "save it as a grey PNG"),
            (&colours, "save it in grey"),
            (&small, "4 × 1 points"),
            (&cut, "save it as a grey PNG"),
        ] {
            let (_folder, file) = written("h.png", bytes);
            let error = said(Ground::image(&file, 0.0, 1.0));
            assert!(
                error.contains(expected) && error.contains("h.png"),
                "{error}"
            );
        }
        let none = Path::new("/there/is/none.png");
        assert!(said(Ground::image(none, 0.0, 1.0)).contains("cannot be read"));
    }
}
