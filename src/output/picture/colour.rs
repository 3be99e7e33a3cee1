//! Colours: linear light for drawing, sRGB in the file, OKLab for choosing them.

use glam::{Vec3, vec3};

/// Colours along a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// From deep water to foam: blue to white.
    #[default]
    Water,
    /// From embers to flames: dark red to pale yellow.
    Fire,
    /// All hues, from violet to red, at one lightness: neighbouring values differ much.
    Spectrum,
    /// From dark to light grey.
    Grey,
    /// Red wine, from depth to foam: dark red to rose.
    Wine,
}

/// Lightness, chroma and hue \[°] in OKLCh, evenly spaced.
type Stops = &'static [[f32; 3]];

impl ColourMap {
    /// Lightness increases evenly, except in the spectrum, so that equal steps look equal, also in greyscale print.
    fn stops(self) -> Stops {
        match self {
            Self::Water => &[
                [0.47, 0.140, 257.0],
                [0.57, 0.145, 252.0],
                [0.66, 0.130, 246.0],
                [0.77, 0.100, 237.0],
                [0.88, 0.058, 225.0],
                [0.985, 0.010, 215.0],
            ],
            Self::Fire => &[
                [0.30, 0.100, 15.0],
                [0.45, 0.160, 28.0],
                [0.60, 0.190, 42.0],
                [0.75, 0.170, 65.0],
                [0.87, 0.140, 90.0],
                [0.97, 0.060, 105.0],
            ],
            Self::Spectrum => &[
                [0.62, 0.16, 310.0],
                [0.62, 0.16, 262.0],
                [0.72, 0.12, 200.0],
                [0.76, 0.17, 145.0],
                [0.84, 0.16, 100.0],
                [0.72, 0.16, 60.0],
                [0.62, 0.20, 25.0],
            ],
            Self::Grey => &[[0.30, 0.0, 0.0], [0.95, 0.0, 0.0]],
            Self::Wine => &[
                [0.30, 0.115, 18.0],
                [0.40, 0.145, 17.0],
                [0.52, 0.160, 15.0],
                [0.68, 0.130, 12.0],
                [0.88, 0.050, 10.0],
            ],
        }
    }
}

/// Colours of values as linear light, from the low to the high end of the range.
pub(super) struct Colours([Vec3; 256]);

impl Colours {
    pub(super) fn new(map: ColourMap) -> Self {
        let stops = map.stops();
        Self(std::array::from_fn(|i| {
            let at = i as f32 / 255.0 * (stops.len() - 1) as f32;
            let stop = (at as usize).min(stops.len() - 2);
            let [from, to] = [stops[stop], stops[stop + 1]].map(from_oklch);
            from_oklab(from.lerp(to, at - stop as f32))
        }))
    }

    /// Colour at a position in the range, 0 to 1.
    pub(super) fn at(&self, place: f32) -> Vec3 {
        // NaN becomes 0.
        self.0[(place.clamp(0.0, 1.0) * 255.0 + 0.5) as usize]
    }
}

fn from_oklch([lightness, chroma, hue]: [f32; 3]) -> Vec3 {
    let (sin, cos) = hue.to_radians().sin_cos();
    vec3(lightness, chroma * cos, chroma * sin)
}

/// Linear sRGB from OKLab (B. Ottosson, "A perceptual color space for image processing", 2020).
fn from_oklab(lab: Vec3) -> Vec3 {
    let l = (lab.x + 0.396_337_78 * lab.y + 0.215_803_76 * lab.z).powi(3);
    let m = (lab.x - 0.105_561_346 * lab.y - 0.063_854_17 * lab.z).powi(3);
    let s = (lab.x - 0.089_484_18 * lab.y - 1.291_485_5 * lab.z).powi(3);
    let rgb = vec3(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    );
    rgb.clamp(Vec3::ZERO, Vec3::ONE)
}

/// Linear light of an sRGB colour.
pub(super) fn linear(srgb: [u8; 3]) -> Vec3 {
    Vec3::from(srgb.map(|value| {
        let value = f32::from(value) / 255.0;
        if value <= 0.040_45 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    }))
}

/// The sRGB colour of linear light.
pub(super) fn srgb(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|value| {
        let value = value.clamp(0.0, 1.0);
        let encoded = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0 + 0.5) as u8
    })
}
