//! Picture of the mechanism without a browser or display: a depth buffer, flat light, lines where
//! surfaces end.

use nalgebra::{Matrix3, Vector3};

use super::report::color;
use crate::solid::assembly::{Carrier, SolidBody};
use crate::{Error, Result};

/// From where, and how large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Direction from the mechanism to the eye, Σ.
    pub direction: [f64; 3],
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Whether parts that stand still are shown as glass.
    pub glass: bool,
}

impl Default for View {
    fn default() -> Self {
        View {
            direction: [0.35, -1.0, 0.42],
            width: 1200,
            height: 900,
            glass: true,
        }
    }
}

/// Each pixel is the mean of this many samples squared.
const SAMPLES: usize = 2;
/// Share of a glass part's colour in front of another part, and in front of nothing.
const GLASS: [f32; 2] = [0.22, 0.45];
/// Margin around the mechanism, as a share of the picture.
const MARGIN: f64 = 0.04;

/// A triangle as it is seen: lit colour, unit normal.
#[derive(Clone, Copy)]
struct Facet {
    color: [f32; 3],
    normal: [f32; 3],
}

/// One sample of a layer: distance towards the eye, and which facet.
#[derive(Clone, Copy)]
struct Sample {
    depth: f32,
    facet: u32,
}

struct Layer {
    width: usize,
    height: usize,
    samples: Vec<Sample>,
    /// The first is nothing.
    facets: Vec<Facet>,
    /// Samples on an outline.
    dark: Vec<bool>,
    /// What the colour is multiplied with there.
    strength: f32,
}

/// PNG of `bodies` where they are, on white.
///
/// # Errors
/// [`Error::Internal`] when the picture cannot be encoded.
pub fn mechanism(bodies: &[SolidBody], view: View) -> Result<Vec<u8>> {
    let (width, height) = (view.width * SAMPLES, view.height * SAMPLES);
    let towards_eye = Vector3::from(view.direction).normalize();
    let right = Vector3::z()
        .cross(&towards_eye)
        .try_normalize(1e-9)
        .unwrap_or_else(Vector3::x);
    let turn = Matrix3::from_rows(&[
        right.transpose(),
        towards_eye.cross(&right).transpose(),
        towards_eye.transpose(),
    ]);

    let points = || {
        bodies
            .iter()
            .flat_map(|p| &p.mesh.vertices)
            .map(|&v| turn * Vector3::from(v))
    };
    let (low, high) = points().fold(
        (
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ),
        |(low, high), p| (low.inf(&p), high.sup(&p)),
    );
    let (size, middle) = (high - low, (high + low) * 0.5);
    let scale = (1.0 - 2.0 * MARGIN) * (width as f64 / size.x).min(height as f64 / size.y);
    let pixel = |v: [f64; 3]| {
        let p = (turn * Vector3::from(v) - middle) * scale;
        [
            (p.x + 0.5 * width as f64) as f32,
            (0.5 * height as f64 - p.y) as f32,
            p.z as f32,
        ]
    };

    let mut solid = Layer::new((width, height), 0.45); // stays empty without bodies
    let mut glass = Layer::new((width, height), 0.6);
    for part in bodies {
        let layer = if view.glass && part.carrier == Carrier::Support {
            &mut glass
        } else {
            &mut solid
        };
        let tone = css_color(color(part.carrier));
        for t in &part.mesh.triangles {
            let [a, b, c] = t.map(|i| part.mesh.vertex(i));
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else {
                continue;
            };
            let n = turn * normal;
            if n.z > 0.0 {
                let lit = light([n.x as f32, n.y as f32, n.z as f32], tone);
                layer.fill(t.map(|i| pixel(part.mesh.vertices[i as usize])), lit);
            }
        }
    }
    solid.outline();
    glass.outline();
    encode(&solid, &glass, view)
}

/// `#rrggbb` as shares of 1.
pub(super) fn css_color(text: &str) -> [f32; 3] {
    let number = u32::from_str_radix(text.trim_start_matches('#'), 16).unwrap_or(0);
    [16, 8, 0].map(|shift| ((number >> shift) & 255) as f32 / 255.0)
}

/// A surface under light from the upper left.
fn light(normal: [f32; 3], color: [f32; 3]) -> Facet {
    let [x, y, z] = normal;
    let key = (-0.35 * x + 0.6 * y + 0.72 * z).max(0.0);
    let brightness = 0.42 + 0.62 * key;
    Facet {
        color: color.map(|c| (c * brightness).min(1.0)),
        normal,
    }
}

impl Layer {
    fn new((width, height): (usize, usize), strength: f32) -> Layer {
        let nothing = Sample {
            depth: f32::NEG_INFINITY,
            facet: 0,
        };
        Layer {
            width,
            height,
            samples: vec![nothing; width * height],
            facets: vec![Facet {
                color: [0.0; 3],
                normal: [0.0; 3],
            }],
            dark: vec![false; width * height],
            strength,
        }
    }

    /// Colour of sample `i`.
    fn color(&self, i: usize) -> [f32; 3] {
        let color = self.facets[self.samples[i].facet as usize].color;
        match self.dark[i] {
            true => color.map(|c| c * self.strength),
            false => color,
        }
    }

    /// Fills the triangle (x, y, depth) where it is nearest.
    fn fill(&mut self, [a, b, c]: [[f32; 3]; 3], lit: Facet) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let range = |i: usize, end: usize| {
            let low = a[i].min(b[i]).min(c[i]).floor().max(0.0) as usize;
            let high = a[i].max(b[i]).max(c[i]).ceil().max(0.0) as usize;
            low..(high + 1).min(end)
        };
        let facet = self.facets.len() as u32;
        self.facets.push(lit);
        for y in range(1, self.height) {
            for x in range(0, self.width) {
                let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
                let share = |p: [f32; 3], q: [f32; 3]| {
                    ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) / area
                };
                let (wa, wb, wc) = (share(b, c), share(c, a), share(a, b));
                if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                    let depth = wa * a[2] + wb * b[2] + wc * c[2];
                    let sample = &mut self.samples[y * self.width + x];
                    if depth > sample.depth {
                        *sample = Sample { depth, facet };
                    }
                }
            }
        }
    }

    /// Darkens samples where the surface ends or folds sharply.
    fn outline(&mut self) {
        let at = |x: usize, y: usize| self.samples[y * self.width + x];
        let normal = |sample: Sample| self.facets[sample.facet as usize].normal;
        for y in 1..self.height.saturating_sub(1) {
            for x in 1..self.width.saturating_sub(1) {
                let here = at(x, y);
                let edge = [at(x + 1, y), at(x, y + 1), at(x - 1, y), at(x, y - 1)]
                    .iter()
                    .any(|other| {
                        let jump = here.depth - other.depth;
                        let (one, two) = (normal(here), normal(*other));
                        let fold: f32 = one.iter().zip(two).map(|(a, b)| a * b).sum();
                        // A slanted surface recedes by less than six samples per sample; more is an edge.
                        jump > 6.0 || (jump.abs() <= 6.0 && fold < 0.75)
                    });
                self.dark[y * self.width + x] = edge && here.depth.is_finite();
            }
        }
    }
}

/// Puts the glass layer over the solid one and writes the mean of each pixel's samples.
fn encode(solid: &Layer, glass: &Layer, view: View) -> Result<Vec<u8>> {
    let over = |i: usize| -> [f32; 3] {
        let (s, g) = (solid.samples[i], glass.samples[i]);
        let behind = s.depth.is_finite();
        let ground = if behind { solid.color(i) } else { [1.0; 3] };
        if g.depth > s.depth {
            let share = GLASS[usize::from(!behind)];
            let front = glass.color(i);
            [0, 1, 2].map(|c| ground[c] * (1.0 - share) + front[c] * share)
        } else {
            ground
        }
    };
    let mut bytes = Vec::with_capacity(view.width * view.height * 3);
    for y in 0..view.height {
        for x in 0..view.width {
            let mut sum = [0.0f32; 3];
            for sub in 0..SAMPLES * SAMPLES {
                let (sx, sy) = (x * SAMPLES + sub % SAMPLES, y * SAMPLES + sub / SAMPLES);
                for (total, part) in sum.iter_mut().zip(over(sy * solid.width + sx)) {
                    *total += part;
                }
            }
            bytes.extend(sum.map(|s| (255.0 * s / (SAMPLES * SAMPLES) as f32).round() as u8));
        }
    }
    png_bytes(&bytes, (view.width, view.height), png::ColorType::Rgb)
}

/// PNG file of 8-bit samples.
pub(super) fn png_bytes(
    bytes: &[u8],
    (width, height): (usize, usize),
    color: png::ColorType,
) -> Result<Vec<u8>> {
    let failed = |e: png::EncodingError| Error::Internal(format!("picture: {e}"));
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width as u32, height as u32);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder
        .write_header()
        .and_then(|mut w| w.write_image_data(bytes))
        .map_err(failed)?;
    Ok(out)
}
