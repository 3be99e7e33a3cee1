//! The lattice of one shape.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::scene::{Dimension, FluidBody, Frame, Shape};

/// Largest difference of two neighbouring coordinates in single precision \[spacings]; coarser ones are refused.
pub(crate) const RESOLUTION: f64 = 0.01;

/// Tolerance of counts and distances \[spacings], for the rounding of the file's numbers to f32. It grows with the
/// ratio of the largest number \[m] to the spacing.
pub(crate) fn tolerance(largest: f64, spacing: f64) -> f64 {
    1e-3 + (f64::from(f32::EPSILON) * largest / spacing).min(RESOLUTION)
}

/// Two axes that form an orthonormal frame with the unit vector `axis`; along coordinate axes if possible.
pub(super) fn frame(axis: DVec3) -> (DVec3, DVec3) {
    let size = axis.abs();
    let helper = if size.z >= size.x && size.z >= size.y {
        DVec3::Y
    } else if size.y >= size.x {
        DVec3::X
    } else {
        DVec3::Z
    };
    let first = helper.cross(axis).normalize();
    (first, axis.cross(first))
}

/// Largest coordinate of the two ends of a shape \[m].
fn largest(shape: &Shape) -> f64 {
    let ends = match *shape {
        Shape::Box { min, max } => [min, max],
        Shape::Sphere { .. } | Shape::Mesh(_) | Shape::Particles(_) => [Vec3::ZERO; 2],
        Shape::Cylinder { start, end, .. } => [start, end],
    };
    f64::from(ends[0].abs().max(ends[1].abs()).max_element())
}

/// The lattice of one shape, before jitter.
///
/// - A box has its points at `min + (i + ½) spacing`. So a box of n spacings has exactly n particles per axis, and its
///   outermost particles are half a spacing from a wall that touches it. A remainder at the upper side that is smaller
///   than a spacing stays empty.
/// - A sphere (a disc in 2-D) has its points at `center + (i + ½) spacing`, within `radius` of the centre.
/// - A cylinder has a frame of its own: `(i + ½) spacing` along its axis from `start`, and `(i + ½) spacing` across the
///   axis, within `radius` of it.
///
/// Option 1 for round shapes: a lattice point at the centre, and points within `radius − spacing/2`. Option 2: as
/// above. We use 2: the number of particles times spacing³ is then an unbiased estimate of the volume (option 1 loses
/// 1.5 spacing/radius of it), and no isolated particles remain at the poles.
#[derive(Clone)]
pub(crate) struct Lattice {
    /// The first point \[m].
    origin: DVec3,
    /// Vectors between neighbouring points \[m].
    steps: [DVec3; 3],
    counts: [u32; 3],
    keep: Keep,
}

/// Points of a row that belong to a shape.
#[derive(Debug, Clone, PartialEq)]
struct Span {
    /// Second and third number of the row.
    row: [u32; 2],
    points: Range<u32>,
}

/// Adds points of a row behind those of the last span.
fn join(spans: &mut Vec<Span>, row: [u32; 2], points: Range<u32>) {
    match spans.last_mut() {
        Some(last) if last.row == row && last.points.end == points.start => {
            last.points.end = points.end;
        }
        _ => spans.push(Span { row, points }),
    }
}

/// Which lattice points belong to the shape.
#[derive(Clone)]
enum Keep {
    All,
    /// These, in the order of rows.
    Spans(Vec<Span>),
    /// No lattice, but these points \[m], with velocities \[m/s] if there are any.
    Points(Vec<DVec3>, Option<Vec<DVec3>>),
    Within {
        center: DVec3,
        radius: f64,
    },
    Around {
        start: DVec3,
        axis: DVec3,
        radius: f64,
    },
}

impl Lattice {
    pub(crate) fn new(shape: &Shape, spacing: f64, dimension: Dimension) -> Self {
        let flat = dimension == Dimension::Two;
        let tolerance = tolerance(largest(shape), spacing);
        let along = |length: f64| (length / spacing + tolerance).floor() as u32;
        // Both sides of a centre: i from -half to half - 1.
        let across = |radius: f64| (radius / spacing + 1e-3).ceil() as u32;
        let reach = |radius: f64| radius + 1e-3 * spacing;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * spacing);

        let mut lattice = match *shape {
            Shape::Mesh(_) | Shape::Particles(_) => Self::empty(),
            Shape::Box { min, max } => {
                let (min, max) = (min.as_dvec3(), max.as_dvec3());
                Self {
                    origin: min + 0.5 * spacing,
                    steps: axes,
                    counts: (max - min).to_array().map(along),
                    keep: Keep::All,
                }
            }
            Shape::Sphere { center, radius } => {
                let (center, radius) = (center.as_dvec3(), f64::from(radius));
                let half = across(radius);
                Self {
                    origin: center + (0.5 - f64::from(half)) * spacing,
                    steps: axes,
                    counts: [half.saturating_mul(2); 3],
                    keep: Keep::Within {
                        center: if flat { center.with_z(0.0) } else { center },
                        radius: reach(radius),
                    },
                }
            }
            Shape::Cylinder { start, end, radius } => {
                let (start, end, radius) = (start.as_dvec3(), end.as_dvec3(), f64::from(radius));
                let axis = (end - start).normalize_or_zero();
                let (u, v) = frame(axis);
                let half = across(radius);
                let first = (0.5 - f64::from(half)) * spacing;
                Self {
                    origin: start + first * (u + v) + 0.5 * spacing * axis,
                    steps: [u, v, axis].map(|axis| axis * spacing),
                    counts: [
                        half.saturating_mul(2),
                        half.saturating_mul(2),
                        along((end - start).length()),
                    ],
                    keep: Keep::Around {
                        start,
                        axis,
                        radius: reach(radius),
                    },
                }
            }
        };
        if flat {
            lattice.origin.z = 0.0;
            lattice.counts[2] = 1;
        }
        // A needle or a sheet thinner than the spacing contains no points, so its rows need not be searched.
        let thin = match *shape {
            Shape::Box { .. } | Shape::Mesh(_) | Shape::Particles(_) => false,
            Shape::Sphere { radius, .. } | Shape::Cylinder { radius, .. } => {
                reach(f64::from(radius)) < spacing / 2.0_f64.sqrt()
            }
        };
        if thin || lattice.counts.contains(&0) {
            lattice.counts = [0; 3];
        }
        lattice
    }

    fn empty() -> Self {
        Self {
            origin: DVec3::ZERO,
            steps: [DVec3::X, DVec3::Y, DVec3::Z],
            counts: [0; 3],
            keep: Keep::All,
        }
    }

    /// The lattice of a body: its shape's, turned with it. A file that cannot be read counts for nothing: the scene's
    /// check names it.
    pub(crate) fn of(body: &FluidBody, spacing: f32, dimension: Dimension) -> Self {
        let lattice = match &body.shape {
            Shape::Mesh(file) => file
                .mesh(spacing)
                .ok()
                .map(|mesh| Self::within(&mesh, spacing)),
            Shape::Particles(file) => file.particles().ok().map(|particles| Self {
                keep: Keep::Points(particles.positions, particles.velocities),
                ..Self::empty()
            }),
            shape => Some(Self::new(shape, spacing.into(), dimension)),
        };
        let mut lattice = lattice.unwrap_or_else(Self::empty);
        let frame = body.frame();
        if frame.is_turned() {
            lattice.turn(&frame);
        }
        lattice
    }

    fn turn(&mut self, frame: &Frame) {
        self.origin = frame.place(self.origin);
        self.steps = self.steps.map(|step| frame.direction(step));
        match &mut self.keep {
            Keep::All | Keep::Spans(_) => {}
            Keep::Within { center, .. } => *center = frame.place(*center),
            Keep::Around { start, axis, .. } => {
                (*start, *axis) = (frame.place(*start), frame.direction(*axis));
            }
            Keep::Points(points, velocities) => {
                (points.iter_mut()).for_each(|point| *point = frame.place(*point));
                let velocities = velocities.iter_mut().flatten();
                velocities.for_each(|velocity| *velocity = frame.direction(*velocity));
            }
        }
    }

    /// The lattice in the box around a closed mesh, of which the points in it belong to it.
    fn within(mesh: &Mesh, spacing: f32) -> Self {
        let spacing = f64::from(spacing);
        let (low, high) = mesh.bounds();
        let along = |length: f64| (length / spacing + 1e-3).ceil() as u32;
        let mut lattice = Self {
            origin: low + 0.5 * spacing,
            steps: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * spacing),
            counts: (high - low).to_array().map(along),
            keep: Keep::All,
        };
        // Points are as far as this from the surface at least, and on the same side of it as far as they are from it.
        let reach = 1e-3 * spacing;
        lattice.keep_only(|point| {
            let distance = mesh.nearest(point).distance;
            (distance <= reach, (distance - reach).abs() / spacing)
        });
        lattice
    }

    /// Leaves out the points that `keep` does not want, row by row in parallel. It also says for how many points beside
    /// one its answer is the same.
    fn keep_only(&mut self, keep: impl Fn(DVec3) -> (bool, f64) + Sync) {
        let [across, up, deep] = self.counts;
        let of_row = |row: u64| {
            let row = [(row % u64::from(up)) as u32, (row / u64::from(up)) as u32];
            let mut spans: Vec<Span> = Vec::new();
            let mut i = 0;
            while i < across {
                let (is_kept, beside) = keep(self.point(i, row));
                let end = i.saturating_add((beside as u32).max(1)).min(across);
                if is_kept {
                    join(&mut spans, row, i..end);
                }
                i = end;
            }
            spans
        };
        let rows = 0..u64::from(up) * u64::from(deep);
        let spans = rows.into_par_iter().flat_map_iter(of_row).collect();
        self.keep = Keep::Spans(spans);
    }

    /// The same without the points that `keep` does not want, which is asked for each.
    pub(crate) fn cut(mut self, keep: impl Fn(DVec3) -> bool + Sync) -> Self {
        if let Keep::Points(points, velocities) = &mut self.keep {
            let kept: Vec<bool> = points.par_iter().map(|point| keep(*point)).collect();
            let of = |values: &mut Vec<DVec3>| {
                let mut kept = kept.iter();
                values.retain(|_| kept.next().is_none_or(|kept| *kept));
            };
            of(points);
            velocities.iter_mut().for_each(of);
            return self;
        }
        let mut cut = Self {
            keep: Keep::All,
            ..self
        };
        match &self.keep {
            Keep::Spans(spans) => {
                let pieces = spans.par_iter().flat_map_iter(|span| {
                    let is_kept = |i: &u32| keep(self.point(*i, span.row));
                    let mut pieces: Vec<Span> = Vec::new();
                    for i in span.points.clone().filter(is_kept) {
                        join(&mut pieces, span.row, i..i + 1);
                    }
                    pieces
                });
                cut.keep = Keep::Spans(pieces.collect());
            }
            _ => cut.keep_only(|point| (self.keeps(point) && keep(point), 1.0)),
        }
        cut
    }

    fn point(&self, i: u32, row: [u32; 2]) -> DVec3 {
        self.origin
            + f64::from(row[1]) * self.steps[2]
            + f64::from(row[0]) * self.steps[1]
            + f64::from(i) * self.steps[0]
    }

    /// Number of points and spans that it holds one by one.
    pub(crate) fn stored_points(&self) -> f64 {
        match &self.keep {
            Keep::Spans(spans) => spans.len() as f64,
            Keep::Points(points, _) => points.len() as f64,
            _ => 0.0,
        }
    }

    /// Number of the points, of a file's or spans that are known; else an upper bound of it.
    pub(crate) fn most(&self) -> f64 {
        match &self.keep {
            Keep::Spans(spans) => spans.iter().map(|span| span.points.len() as f64).sum(),
            Keep::Points(points, _) => points.len() as f64,
            _ => self.counts.iter().map(|&count| f64::from(count)).product(),
        }
    }

    /// Velocity of the point with a number, in the order of [`for_each`](Self::for_each) \[m/s]: zero, if not from a
    /// file.
    pub(crate) fn velocity(&self, number: usize) -> DVec3 {
        match &self.keep {
            Keep::Points(_, Some(velocities)) => {
                velocities.get(number).copied().unwrap_or_default()
            }
            _ => DVec3::ZERO,
        }
    }

    pub(crate) fn for_each(&self, visit: impl FnMut(DVec3)) {
        self.for_each_of(self.counts.map(|count| 0..count), visit);
    }

    /// As [`for_each`](Self::for_each), without most of the points that are not in the box from `low` to `high` \[m].
    pub(crate) fn for_each_near(&self, low: DVec3, high: DVec3, visit: impl FnMut(DVec3)) {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let rows = [0, 1, 2].map(|k| {
            let (step, count) = (self.steps[k], f64::from(self.counts[k]));
            let square = step.length_squared();
            let at = (middle - self.origin).dot(step) / square;
            let reach = half.dot(step.abs()) / square;
            // A row more on either side, for rounding.
            let first = (at - reach - 1.0).floor().clamp(0.0, count);
            let end = (at + reach + 2.0).ceil().clamp(first, count);
            first as u32..end as u32
        });
        self.for_each_of(rows, visit);
    }

    fn for_each_of(&self, [across, up, deep]: [Range<u32>; 3], mut visit: impl FnMut(DVec3)) {
        match &self.keep {
            Keep::Points(points, _) => return points.iter().copied().for_each(visit),
            Keep::Spans(spans) => {
                let is_near =
                    |span: &&Span| up.contains(&span.row[0]) && deep.contains(&span.row[1]);
                for span in spans.iter().filter(is_near) {
                    let points =
                        span.points.start.max(across.start)..span.points.end.min(across.end);
                    points.for_each(|i| visit(self.point(i, span.row)));
                }
                return;
            }
            Keep::All | Keep::Within { .. } | Keep::Around { .. } => {}
        }
        for k in deep {
            for j in up.clone() {
                let row = self.origin + f64::from(k) * self.steps[2] + f64::from(j) * self.steps[1];
                for i in across.clone() {
                    let point = row + f64::from(i) * self.steps[0];
                    if self.keeps(point) {
                        visit(point);
                    }
                }
            }
        }
    }

    fn keeps(&self, point: DVec3) -> bool {
        match self.keep {
            Keep::All | Keep::Spans(_) | Keep::Points(..) => true,
            Keep::Within { center, radius } => (point - center).length_squared() <= radius * radius,
            Keep::Around {
                start,
                axis,
                radius,
            } => {
                let from = point - start;
                (from - axis * from.dot(axis)).length_squared() <= radius * radius
            }
        }
    }
}
