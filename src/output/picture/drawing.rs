//! The passes of a picture, one after the other.

use super::image::Image;
use super::quantity::Quantity;
use super::raster::{Fluid, Layer, SAMPLES, Spheres};
use super::view::View;
use super::{legend, shade};
use crate::output::Frame;
use crate::output::surface::SurfaceMesh;

/// Draws a frame. Particles without a finite position are left out.
pub fn draw(frame: &Frame, view: &View) -> Image {
    draw_after(frame, None, view)
}

/// Draws a frame; `before` is the frame before it, which the colours of accelerations need.
pub fn draw_after(frame: &Frame, before: Option<&Frame>, view: &View) -> Image {
    let values = view.quantity.values(frame, before);
    let spheres = Spheres {
        positions: &frame.positions,
        radius: view.particle_radius,
    };
    draw_fluid(Fluid::Spheres(spheres), &values, frame.time, view)
}

/// Draws a surface. Its colours show the speed, whatever the quantity of the view.
pub fn draw_surface(mesh: &SurfaceMesh, view: &View) -> Image {
    let speeds: Vec<f32> = mesh.velocities.iter().map(|v| v.length()).collect();
    let view = view.clone().of(Quantity::Speed, view.colours);
    draw_fluid(Fluid::Surface(mesh), &speeds, mesh.time, &view)
}

fn draw_fluid(fluid: Fluid<'_>, values: &[f32], time: f64, view: &View) -> Image {
    let on_path = view.camera_path.as_ref().map(|path| View {
        camera: path.at(time),
        camera_path: None,
        ..view.clone()
    });
    let view = on_path.as_ref().unwrap_or(view);
    let (width, height) = view.size();
    let projection = view.projection();
    let samples = projection.magnified(SAMPLES as f32);
    let layer = Layer::draw(
        &samples,
        (width * SAMPLES, height * SAMPLES),
        fluid,
        &view.solids,
        view.floor,
    );
    let shadow = view.shadow_projection().map(|(projection, size)| {
        let layer = Layer::draw(&projection, (size, size), fluid, &view.solids, None);
        shade::Shadow { projection, layer }
    });

    let mut canvas = shade::shade((fluid, values), view, &samples, &layer, shadow.as_ref());
    for &ends in &view.edges {
        canvas.edge(&projection, &layer, ends, view);
    }
    legend::draw(&mut canvas, time, view);
    canvas.encode()
}
