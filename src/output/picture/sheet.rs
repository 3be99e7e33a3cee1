//! A contact sheet of a run's pictures.

use super::image::Image;

/// Largest width of a sheet \[pixels]; larger pictures are scaled down.
const MAX_WIDTH: usize = 1920;
/// Space between pictures \[pixels].
const GAP: usize = 4;

/// Arranges pictures in rows, in cells with the aspect ratio of the first. All are scaled down so that the sheet is at
/// most 1920 pixels wide; pictures that are drawn at the size of a cell keep their text sharp. Without pictures the
/// image is empty.
pub fn contact_sheet(images: &[Image], columns: usize) -> Image {
    let columns = columns.clamp(1, images.len().max(1));
    let Some(first) = images.first().filter(|i| i.width > 0 && i.height > 0) else {
        return Image::filled(0, 0, [0; 3]);
    };
    let most = (MAX_WIDTH - GAP).saturating_sub(columns * GAP) / columns;
    let width = first.width.min(most.max(1));
    let height = (first.height * width / first.width).max(1);
    let rows = images.len().div_ceil(columns);

    let mut sheet = Image::filled(
        GAP + columns * (width + GAP),
        GAP + rows * (height + GAP),
        [255; 3],
    );
    for (i, image) in images.iter().enumerate() {
        let left = GAP + (i % columns) * (width + GAP);
        let top = GAP + (i / columns) * (height + GAP);
        let fits = (image.width, image.height) == (width, height);
        let small = (!fits).then(|| image.shrunk(width, height));
        let cell = small.as_ref().unwrap_or(image);
        for (y, row) in cell.rgb.chunks_exact(3 * width).enumerate() {
            let start = 3 * ((top + y) * sheet.width + left);
            sheet.rgb[start..start + row.len()].copy_from_slice(row);
        }
    }
    sheet
}

/// At most `count` evenly spaced indices of `0..total`, including the first and the last.
pub fn evenly_spaced(total: usize, count: usize) -> Vec<usize> {
    if total <= count || count < 2 {
        return (0..total.min(count)).collect();
    }
    (0..count)
        .map(|i| (i * (total - 1) + (count - 1) / 2) / (count - 1))
        .collect()
}
