//! The report -> charts as SVG: time of each frame, and load balance of the workers.

use super::flight::Flight;
use super::replay::Policy;
use super::summary::{Replay, Report};
use crate::Failure;
use crate::outputs::Outputs;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;
use std::path::Path;

/// Width and height of a chart, pixels.
const SIZE: (u32, u32) = (960, 420);
pub(super) const FONT: (&str, u32) = ("sans-serif", 15);

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;
pub(super) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Writes the charts atomically.
pub(super) fn save(report: &Report, flights: &[Flight], file: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
    let charts = 1 + report.replays.len();
    page((SIZE.0, charts as u32 * SIZE.1), file, outputs, |page| {
        let rows = page.split_evenly((charts, 1));
        frames(report, flights, &rows[0])?;
        report.replays.iter().zip(&rows[1..]).try_for_each(|(replay, row)| balance(report, replay, row))
    })
}

/// Writes a page of so many pixels, atomically.
pub(super) fn page(
    size: (u32, u32),
    file: &Path,
    outputs: &mut Outputs,
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<(), Failure> {
    let mut text = String::new();
    {
        let page = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let drawn = page.fill(&WHITE).and_then(|()| draw(&page)).and_then(|()| page.present());
        drawn.map_err(|why| Failure::Cannot(format!("{}: {why}", file.display())))?;
    }
    outputs.write(file, |out| out.write_all(text.as_bytes()))
}

/// A chart with room for the labels of its axes.
pub(super) fn chart<'a, 'b>(area: &'a Area<'b>, caption: String) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut chart = ChartBuilder::on(area);
    chart.caption(caption, FONT).margin(12).x_label_area_size(44).y_label_area_size(56);
    chart
}

/// Draws a line, with dots of `dots` pixels, and adds it to the legend.
pub(super) fn line<X: Ranged<ValueType: Clone + 'static>, Y: Ranged<ValueType: Clone + 'static>>(
    chart: &mut Chart<'_, '_, X, Y>,
    name: impl Into<String>,
    (style, dots): (ShapeStyle, u32),
    points: impl IntoIterator<Item = (X::ValueType, Y::ValueType)>,
) -> Drawn {
    let drawn = chart.draw_series(LineSeries::new(points, style).point_size(dots))?;
    drawn.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    Ok(())
}

/// The style of line `k` of a chart.
pub(super) fn style(k: usize) -> ShapeStyle {
    Palette99::pick(k).stroke_width(2)
}

/// Milliseconds of each frame along the path, on a logarithmic scale.
fn frames(report: &Report, flights: &[Flight], area: &Area<'_>) -> Drawn {
    let all = || flights.iter().flat_map(|flight| &flight.times).map(|t| t.frame);
    let (low, high) = all().fold((f64::INFINITY, 1e-3_f64), |(low, high), ms| (low.min(ms), high.max(ms)));
    let longest = flights.iter().map(|flight| flight.times.len()).max().unwrap_or(1);
    let path = report.runs.first().map_or("", |run| run.path.as_str());
    let mut chart = chart(area, format!("{}, {path}: ms per frame", report.model))
        .build_cartesian_2d(0..longest, (low.clamp(1e-4, high * 0.5)..high * 1.3).log_scale())?;
    chart.configure_mesh().x_desc("frame").y_desc("ms").label_style(FONT).light_line_style(TRANSPARENT).draw()?;
    for (k, (flight, run)) in flights.iter().zip(&report.runs).enumerate() {
        let name = format!("workers {}, coherence {}", run.workers, run.coherence);
        line(&mut chart, name, (style(k), 0), flight.times.iter().map(|t| t.frame).enumerate())?;
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}

/// Efficiency by number of workers: a line per way of dealing tiles as simulated, and dots as measured.
fn balance(report: &Report, replay: &Replay, area: &Area<'_>) -> Drawn {
    let rows = &replay.rows;
    let most = rows.iter().map(|row| row.workers).max().unwrap_or(2) as f64;
    let caption = format!("{}: mean over maximum load of workers, coherence {}", report.model, replay.coherence);
    let mut chart = chart(area, caption).build_cartesian_2d((0.9..most * 1.1).log_scale().base(2.0), 0.0..1.05)?;
    chart
        .configure_mesh()
        .x_desc("workers")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_desc("efficiency")
        .label_style(FONT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (k, (name, _)) in Policy::ALL.into_iter().enumerate() {
        let points = rows.iter().map(|row| (row.workers as f64, row.efficiency[name]));
        line(&mut chart, name, (style(k), 0), points)?;
    }
    let measured = report.runs.iter().filter(|run| run.coherence == replay.coherence);
    let dots = measured.map(|run| Circle::new((run.workers as f64, run.efficiency), 4, BLACK.filled()));
    chart.draw_series(dots)?.label("measured").legend(|(x, y)| Circle::new((x + 9, y), 4, BLACK.filled()));
    legend(&mut chart, SeriesLabelPosition::LowerLeft)
}

pub(super) fn legend<'a, 'b: 'a, X: Ranged, Y: Ranged>(
    chart: &mut Chart<'a, 'b, X, Y>,
    place: SeriesLabelPosition,
) -> Drawn {
    let style = WHITE.mix(0.8);
    chart.configure_series_labels().position(place).background_style(style).border_style(BLACK).label_font(FONT).draw()
}
