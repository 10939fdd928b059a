//! Pictures of curves without a browser or display.

use std::sync::OnceLock;

use plotters::prelude::*;

use super::curves::Plot;
use super::picture::png_bytes;
use crate::{Error, Result};

/// Letters of the pictures; plotters knows them under this family.
const FONT: (&str, &[u8]) = (
    "report",
    include_bytes!("../../templates/vendor/font/DejaVuSans.ttf"),
);

/// PNG of `plot` on white, `width` × `height` pixels.
///
/// # Errors
/// [`Error::Internal`] when it cannot be drawn.
pub fn png(plot: &Plot, (width, height): (u32, u32)) -> Result<Vec<u8>> {
    font()?;
    let (wide, high) = (width * FINER, height * FINER);
    let mut fine = vec![255; (wide * high * 3) as usize];
    draw(plot, BitMapBackend::with_buffer(&mut fine, (wide, high)))
        .map_err(|e| Error::Internal(format!("picture of {}: {e}", plot.title)))?;
    let mean = |x: u32, y: u32, channel: u32| {
        let samples = (0..FINER * FINER).map(|i| (x * FINER + i % FINER, y * FINER + i / FINER));
        let sum: u32 = samples
            .map(|(x, y)| u32::from(fine[((y * wide + x) * 3 + channel) as usize]))
            .sum();
        (sum / (FINER * FINER)) as u8
    };
    let pixels: Vec<u8> = (0..width * height)
        .flat_map(|i| [0, 1, 2].map(|channel| mean(i % width, i / width, channel)))
        .collect();
    png_bytes(
        &pixels,
        (width as usize, height as usize),
        png::ColorType::Rgb,
    )
}

/// Each pixel is the mean of this many squared: smooth lines.
const FINER: u32 = 2;

/// The axis counts eighths of a turn, deg, so that its round numbers are round angles.
const EIGHTH: f64 = 45.0;

/// Registers the letters once.
fn font() -> Result<()> {
    static READY: OnceLock<bool> = OnceLock::new();
    let ready = READY
        .get_or_init(|| plotters::style::register_font(FONT.0, FontStyle::Normal, FONT.1).is_ok());
    if *ready {
        Ok(())
    } else {
        Err(Error::Internal("the font of the pictures is broken".into()))
    }
}

fn draw(
    plot: &Plot,
    backend: BitMapBackend,
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let area = backend.into_drawing_area();
    area.fill(&WHITE)?;
    let strip = if plot.series.len() > 1 { 210 } else { 20 } * FINER;
    let (area, names) = area.split_horizontally(area.dim_in_pixel().0 - strip);
    let x = (
        plot.phi_deg.first().copied().unwrap_or(0.0),
        plot.phi_deg.last().copied().unwrap_or(360.0),
    );
    let (low, high) = range(plot);
    let heading = if plot.unit.is_empty() {
        plot.title.to_string()
    } else {
        format!("{} · {}", plot.title, plot.unit)
    };
    let mut chart = ChartBuilder::on(&area)
        .caption(heading, (FONT.0, 30 * FINER))
        .margin(16 * FINER)
        .x_label_area_size(40 * FINER)
        .y_label_area_size(80 * FINER)
        .build_cartesian_2d(x.0 / EIGHTH..x.1 / EIGHTH, low..high)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(ShapeStyle::from(RGBColor(221, 227, 234)).stroke_width(FINER))
        .axis_style(ShapeStyle::from(RGBColor(91, 104, 119)).stroke_width(FINER))
        .label_style((FONT.0, 20 * FINER))
        .x_labels(9)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{:.0}°", x * EIGHTH))
        .y_label_formatter(&|y| ((y * 1e6).round() / 1e6).to_string())
        .draw()?;
    for (i, series) in plot.series.iter().enumerate() {
        let color = rgb(series.color);
        let line = ShapeStyle::from(color).stroke_width(3 * FINER);
        // A gap in the values is a gap in the curve.
        let points: Vec<(f64, Option<f64>)> = plot
            .phi_deg
            .iter()
            .copied()
            .zip(series.values.iter().copied())
            .collect();
        for run in points
            .split(|(_, y)| y.is_none())
            .filter(|run| !run.is_empty())
        {
            let run = run.iter().filter_map(|&(x, y)| Some((x / EIGHTH, y?)));
            chart.draw_series(LineSeries::new(run, line))?;
        }
        if plot.series.len() > 1 {
            let y = (70 + 34 * i as i32) * FINER as i32;
            let dash = vec![(0, y), (26 * FINER as i32, y)];
            names.draw(&PathElement::new(dash, line))?;
            let at = (34 * FINER as i32, y - 9 * FINER as i32);
            names.draw(&Text::new(series.label.clone(), at, (FONT.0, 20 * FINER)))?;
        }
    }
    area.present()?;
    Ok(())
}

/// Range of the values, with 0 where it has a meaning and a little air.
fn range(plot: &Plot) -> (f64, f64) {
    let values = || {
        plot.series
            .iter()
            .flat_map(|s| &s.values)
            .flatten()
            .copied()
    };
    let zero = plot.from_zero.then_some(0.0);
    let low = values().chain(zero).fold(f64::INFINITY, f64::min);
    let high = values().chain(zero).fold(f64::NEG_INFINITY, f64::max);
    if low < high {
        let air = 0.06 * (high - low);
        (
            if low == 0.0 { 0.0 } else { low - air },
            if high == 0.0 { 0.0 } else { high + air },
        )
    } else if low.is_finite() {
        (low - 1.0, low + 1.0)
    } else {
        (0.0, 1.0)
    }
}

fn rgb(css: &str) -> RGBColor {
    let [r, g, b] = super::picture::css_color(css).map(|c| (255.0 * c) as u8);
    RGBColor(r, g, b)
}
