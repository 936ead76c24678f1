//! The report -> charts as SVG: time of each frame, and load balance of the workers.

use super::flight::Flight;
use super::replay::Policy;
use super::summary::{Replay, Report};
use crate::Failure;
use crate::outputs::Outputs;
use plotters::prelude::*;
use std::path::Path;

/// Width and height of a chart, pixels.
const SIZE: (u32, u32) = (960, 420);
const FONT: (&str, u32) = ("sans-serif", 15);

/// Writes the charts atomically.
pub(super) fn save(report: &Report, flights: &[Flight], file: &Path, outputs: &mut Outputs) -> Result<(), Failure> {
    let cannot = |why: &dyn std::fmt::Display| Failure::Cannot(format!("{}: {why}", file.display()));
    let charts = 1 + report.replays.len() as u32;
    let mut text = String::new();
    {
        let page = SVGBackend::with_string(&mut text, (SIZE.0, charts * SIZE.1)).into_drawing_area();
        let drawn = page.fill(&WHITE).map_err(|e| e.to_string()).and_then(|()| {
            let rows = page.split_evenly((charts as usize, 1));
            frames(report, flights, &rows[0]).map_err(|e| e.to_string())?;
            for (replay, row) in report.replays.iter().zip(&rows[1..]) {
                balance(report, replay, row).map_err(|e| e.to_string())?;
            }
            page.present().map_err(|e| e.to_string())
        });
        drawn.map_err(|e| cannot(&e))?;
    }
    outputs.write(file, |out| out.write_all(text.as_bytes()))
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type Drawn<'a> = Result<(), DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>>;

/// Milliseconds of each frame along the path, on a logarithmic scale.
fn frames<'a>(report: &Report, flights: &[Flight], area: &Area<'a>) -> Drawn<'a> {
    let all = || flights.iter().flat_map(|flight| &flight.times).map(|t| t.frame);
    let (low, high) = all().fold((f64::INFINITY, 1e-3_f64), |(low, high), ms| (low.min(ms), high.max(ms)));
    let longest = flights.iter().map(|flight| flight.times.len()).max().unwrap_or(1);
    let path = report.runs.first().map_or("", |run| run.path.as_str());
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{}, {path}: ms per frame", report.model), FONT)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(0..longest, (low.clamp(1e-4, high * 0.5)..high * 1.3).log_scale())?;
    chart.configure_mesh().x_desc("frame").y_desc("ms").label_style(FONT).light_line_style(TRANSPARENT).draw()?;
    for (k, (flight, run)) in flights.iter().zip(&report.runs).enumerate() {
        let colour = Palette99::pick(k).to_rgba();
        let points = flight.times.iter().enumerate().map(|(frame, t)| (frame, t.frame));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(format!("workers {}, coherence {}, {}", run.workers, run.coherence, run.lines))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)
}

/// Efficiency by number of workers: a line per way of dealing tiles as simulated, and dots as measured.
fn balance<'a>(report: &Report, replay: &Replay, area: &Area<'a>) -> Drawn<'a> {
    let rows = &replay.rows;
    let most = rows.iter().map(|row| row.workers).max().unwrap_or(2) as f64;
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{}: mean over maximum load of workers, coherence {}", report.model, replay.coherence), FONT)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d((0.9..most * 1.1).log_scale().base(2.0), 0.0..1.05)?;
    chart
        .configure_mesh()
        .x_desc("workers")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_desc("efficiency")
        .label_style(FONT)
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (k, (name, _)) in Policy::ALL.into_iter().enumerate() {
        let colour = Palette99::pick(k).to_rgba();
        let points = rows.iter().map(|row| (row.workers as f64, row.efficiency[name]));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    let measured = report.runs.iter().filter(|run| run.coherence == replay.coherence);
    let dots = measured.map(|run| Circle::new((run.workers as f64, run.efficiency), 4, BLACK.filled()));
    chart.draw_series(dots)?.label("measured").legend(|(x, y)| Circle::new((x + 9, y), 4, BLACK.filled()));
    legend(&mut chart, SeriesLabelPosition::LowerLeft)
}

fn legend<'a, 'b: 'a, C: CoordTranslate>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, C>,
    place: SeriesLabelPosition,
) -> Drawn<'b> {
    let style = WHITE.mix(0.8);
    chart.configure_series_labels().position(place).background_style(style).border_style(BLACK).label_font(FONT).draw()
}
