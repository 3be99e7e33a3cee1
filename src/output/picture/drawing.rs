//! The passes of a picture, one after the other.

use super::image::Image;
use super::raster::{Layer, SAMPLES, Spheres};
use super::view::View;
use super::{legend, shade};
use crate::output::Frame;

/// Draws a frame. Particles without a finite position are left out.
pub fn draw(frame: &Frame, view: &View) -> Image {
    draw_after(frame, None, view)
}

/// Draws a frame; `before` is the frame before it, which the colours of accelerations need.
pub fn draw_after(frame: &Frame, before: Option<&Frame>, view: &View) -> Image {
    let values = view.quantity.values(frame, before);
    let (width, height) = view.size();
    let projection = view.projection();
    let spheres = Spheres {
        positions: &frame.positions,
        radius: view.particle_radius,
    };
    let samples = projection.magnified(SAMPLES as f32);
    let layer = Layer::draw(
        &samples,
        (width * SAMPLES, height * SAMPLES),
        &spheres,
        &view.solids,
        view.floor,
    );
    let shadow = view.shadow_projection().map(|(projection, size)| {
        let layer = Layer::draw(&projection, (size, size), &spheres, &view.solids, None);
        shade::Shadow { projection, layer }
    });

    let mut canvas = shade::shade(&values, view, &samples, &layer, shadow.as_ref());
    for &ends in &view.edges {
        canvas.edge(&projection, &layer, ends, view);
    }
    legend::draw(&mut canvas, frame, view);
    canvas.encode()
}
