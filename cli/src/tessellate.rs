//! `trimtess tessellate`: a CAD file to a mesh file within a chord and angle tolerance.

use crate::closedness::Closedness;
use crate::input::{self, Input};
use crate::laps::Laps;
use crate::limits::unprepared;
use crate::outputs::{Named, Outputs};
use crate::progress::Progress;
use crate::report::Report;
use crate::rounded;
use crate::{AsJson, Common, Done, Failure};
use std::path::PathBuf;
use std::sync::Arc;
use trimtess::audit;
use trimtess::control::Control;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::out::{self, Format};
use trimtess::parallel::{self, FrameReport, SessionOptions, balance};
use trimtess::prepare::{Prepared, Shells, prepare};

/// Default chord tolerance as a fraction of the model's diagonal. At 1e-2 a cylinder across the model is visibly a
/// prism; 1e-4 makes ten times as many triangles that look the same on a screen.
const DEFAULT_CHORD_REL: f64 = 1e-3;

/// Default angle tolerance in degrees: about 18 segments around a full circle, however small.
const DEFAULT_ANGLE: f64 = 20.0;

/// `trimtess tessellate`
#[derive(clap::Args)]
pub(crate) struct TessellateArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parser())]
    pub(crate) input: Input,
    /// Output file. The extension selects the format: glb, stl, ply or obj.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    tolerance: ToleranceArgs,
    /// Check the mesh: report whether each part is closed in the file and in the mesh, and measure the deviation from
    /// the exact surfaces and edges. Exit status 3 if the check fails.
    #[arg(long)]
    check: bool,
    /// Move the centre of the scene to the origin, and report the offset. Formats in single precision lose detail far
    /// from the origin.
    #[arg(long)]
    recenter: bool,
    /// What a GLB asks of its readers, so that it is smaller. A comma-separated list.
    #[arg(long, value_name = "HOW", value_delimiter = ',')]
    glb: Vec<Compact>,
    /// Write a report as JSON.
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
    #[command(flatten)]
    told: AsJson,
}

/// What a GLB asks of its readers.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Compact {
    /// Instances of a part are one node (EXT_mesh_gpu_instancing). Leaves out edges.
    Instanced,
    /// Positions and normals have 16 bits where the tolerance allows it (KHR_mesh_quantization).
    Quantized,
    /// Buffers are compressed (EXT_meshopt_compression).
    Compressed,
}

impl TessellateArgs {
    /// The files to write.
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("output", Some(&self.output)).output("report", self.report.as_ref())
    }

    fn format(&self) -> Result<Format, Failure> {
        let format = Format::of_path(&self.output).map_err(|e| Failure::Usage(e.to_string()))?;
        let is = |how| self.glb.contains(&how);
        match format {
            Format::Glb(plain) => Ok(Format::Glb(
                plain
                    .with_instanced(is(Compact::Instanced))
                    .with_quantized(is(Compact::Quantized))
                    .with_compressed(is(Compact::Compressed)),
            )),
            other if self.glb.is_empty() => Ok(other),
            _ => Err(Failure::Usage(format!("--glb is for .glb files, and not for {}", self.output.display()))),
        }
    }
}

/// Tolerance options.
#[derive(clap::Args)]
pub(crate) struct ToleranceArgs {
    /// Maximum distance between mesh and exact surface, millimetres.
    #[arg(long, value_name = "MM", value_parser = positive, conflicts_with = "chord_rel")]
    chord: Option<f64>,
    /// Maximum distance as a fraction of the model's diagonal [default: 1e-3].
    #[arg(long, value_name = "FRACTION", value_parser = positive)]
    chord_rel: Option<f64>,
    /// Maximum angle by which the normal turns across a lattice cell, degrees.
    #[arg(long, value_name = "DEG", value_parser = positive, default_value_t = DEFAULT_ANGLE)]
    angle: f64,
    /// Maximum length of lattice cell sides and edge segments, millimetres.
    #[arg(long, value_name = "MM", value_parser = positive)]
    max_edge: Option<f64>,
}

impl ToleranceArgs {
    /// The tolerance for a model of this diagonal, millimetres.
    pub(crate) fn resolve(&self, diagonal: f64) -> Tolerance {
        let relative = self.chord_rel.unwrap_or(DEFAULT_CHORD_REL) * diagonal;
        let chord = self.chord.unwrap_or(relative);
        Tolerance { chord, angle: self.angle.to_radians(), max_edge: self.max_edge }
    }
}

/// Parses a finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        Ok(number) => Err(format!("{number} is not a positive number")),
        Err(e) => Err(e.to_string()),
    }
}

/// Largest side of a picture or a window, pixels. No graphics device has larger textures.
const MOST_PIXELS: u32 = 32_768;

/// Parses WxH.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let parse = |side: &str| side.parse::<u32>().ok().filter(|&side| side > 0);
    let sides = text.split_once('x').and_then(|(width, height)| Some((parse(width)?, parse(height)?)));
    match sides {
        Some((width, height)) if width.max(height) > MOST_PIXELS => {
            Err(format!("{text} is not from 1x1 to {MOST_PIXELS}x{MOST_PIXELS}"))
        }
        Some(sides) => Ok(sides),
        None => Err(format!("{text} is not WIDTHxHEIGHT, like 1280x960")),
    }
}

/// Runs the command.
pub(crate) fn run(
    args: &TessellateArgs,
    common: &Common,
    mut laps: Laps,
    outputs: &mut Outputs,
) -> Result<Done, Failure> {
    let format = args.format()?;
    let progress = Progress::start(common);

    progress.stage(format!("reading {}", args.input.name()));
    let model = tracing::info_span!("read").in_scope(|| args.input.read(&common.limits.step()))?;
    let shells: Vec<Shells> = if args.check { model.parts.iter().map(Shells::of).collect() } else { Vec::new() };
    let read = laps.lap();

    progress.stage("preparing");
    let prepared = tracing::info_span!("prepare").in_scope(|| prepare(model, &common.prepare()));
    let prepared = Arc::new(prepared.map_err(unprepared)?);
    let tolerance = args.tolerance.resolve(prepared.diagonal);
    let prepare = laps.lap();

    progress.stage("tessellating");
    let plan = Arc::new(common.limits.accept(frame::plan_within(&prepared, &tolerance, &common.limits.plan()))?);
    let mut frame = MemorySink::default();
    let made = make(&prepared, &plan, common, matches!(format, Format::Glb(_)) || args.check, &mut frame)?;
    let mut report = Report::of(&frame, &prepared, &made);
    plan.shortfall.iter().for_each(|shortfall| report.add_warning(shortfall.to_string()));
    let tessellate = laps.lap();

    if args.check {
        progress.stage("checking");
        check_mesh(&prepared, &shells, &frame, tolerance.chord, &mut report);
    }
    report.diagonal_mm = prepared.diagonal;
    let mut check = laps.lap();

    progress.stage(format!("writing {}", args.output.display()));
    if args.recenter {
        report.offset_mm = rounded::recenter(&mut frame, &prepared).to_array();
    }
    let most = rounded::most(tolerance.chord);
    let written = tracing::info_span!("write")
        .in_scope(|| out::save_pending(&frame, &args.output, format, most, &mut outputs.files));
    let (rounding, pending) = match written {
        Ok(written) => written,
        Err(e) => return Err(rounded::unwritten(&e, (&frame, args.recenter), &prepared, (format, most))),
    };
    rounded::tell(&rounding, &mut report);
    let write = laps.lap();
    if args.check {
        progress.stage("reading the file back");
        rounded::check(&prepared, &frame, &pending, (format, tolerance.chord), &mut report);
        check += laps.lap();
    }
    drop(progress);

    report.input = args.input.name();
    report.output = args.output.display().to_string();
    report.chord_mm = Some(tolerance.chord);
    report.angle_deg = Some(args.tolerance.angle);
    report.workers = rayon::current_num_threads();
    report.seconds = crate::report::Seconds { read, prepare, tessellate, check, write, total: laps.total() };
    let done = report.publish(common, args.told.json, args.report.as_deref(), outputs);
    // The process is about to exit: dropping large structures would only delay it.
    std::mem::forget((prepared, plan, frame));
    done
}

/// Tessellates one frame on the threads that `common` asks for.
pub(crate) fn make(
    prepared: &Arc<Prepared>,
    plan: &Arc<frame::Plan>,
    common: &Common,
    edge_lines: bool,
    sink: &mut MemorySink,
) -> Result<FrameReport, Failure> {
    let options = SessionOptions::DEFAULT.with_threads(common.workers()).with_edge_lines(edge_lines);
    let made = parallel::tessellate(prepared, plan, &options, &Control::default(), sink);
    let made = made.map_err(|e| Failure::Cannot(e.to_string()))?;
    tracing::info!(
        triangles = made.triangles,
        batches = made.batches,
        workers = made.workers.len(),
        balance = balance(&made.workers, made.workers.len()),
        "made in {:?}, committed in {:?}",
        made.made_in,
        made.committed_in
    );
    Ok(made)
}

/// Runs `check_scene` and the audit, and adds their results and errors to the report.
fn check_mesh(prepared: &Prepared, shells: &[Shells], frame: &MemorySink, chord: f64, report: &mut Report) {
    let facts = check_scene(frame);
    report.open_edges = Some(facts.total.open_edges);
    report.unbalanced_edges = Some(facts.total.unbalanced_edges);
    tracing::info!("{}", facts.total);
    report.defects = Some(facts.total.defects);
    let parts = frame.scene.parts.iter().zip(&facts.parts);
    let closedness = (0..).zip(parts).map(|(k, (part, mesh))| Closedness::of(k, part, mesh));
    report.closedness = Some(closedness.collect());
    audit::mesh_faults(&frame.scene, &facts, shells).into_iter().for_each(|fault| report.add_error(fault));
    let deviation = audit::deviation(prepared, frame, chord);
    deviation.faults().for_each(|fault| report.add_error(fault));
    tracing::info!("{deviation}");
    let economy = audit::economy(prepared, frame, chord);
    tracing::info!("{economy}");
    report.book(deviation, economy);
}

#[cfg(test)]
mod tests {
    use super::*;
    use trimtess::model::shapes;
    use trimtess::parallel::Session;
    use trimtess::prepare::PrepareOptions;

    /// Errors that `check` reports for a shape after `tamper` changed its mesh or shells.
    fn errors(name: &str, chord: f64, tamper: impl Fn(&mut MemorySink, &mut Vec<Shells>)) -> Vec<String> {
        let model = shapes::by_name(name).unwrap_or_default();
        let mut shells: Vec<Shells> = model.parts.iter().map(Shells::of).collect();
        let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"));
        let tolerance = Tolerance { chord: 0.05, angle: 0.5, max_edge: None };
        let plan = frame::plan(&prepared, &tolerance);
        let mut frame = MemorySink::default();
        let options = SessionOptions::DEFAULT.with_threads(1);
        let mut session = Session::start(Arc::clone(&prepared), &options).expect("a thread");
        session.frame(plan, &mut frame).expect("a frame");
        tamper(&mut frame, &mut shells);
        let mut report = Report::default();
        check_mesh(&prepared, &shells, &frame, chord, &mut report);
        report.diagnostics.into_iter().map(|entry| entry.reason).collect()
    }

    #[test]
    fn a_sound_mesh_passes() {
        for name in ["box", "cylinder", "sphere", "square", "wave"] {
            assert_eq!(errors(name, 0.05, |_, _| ()), [""; 0], "{name}");
        }
    }

    #[test]
    fn cracks_inversion_and_deviation_are_errors() {
        let crack = errors("cylinder", 0.05, |frame, _| drop(frame.batches.pop()));
        assert!(crack.len() == 1 && crack[0].contains("unbalanced"), "{crack:?}");
        let turned = errors("cylinder", 0.05, |frame, _| {
            let triangles = frame.batches.iter_mut().flat_map(|batch| &mut batch.mesh.triangles);
            triangles.for_each(|corners| corners.swap(0, 1));
        });
        assert!(turned.len() == 1 && turned[0].contains("inside out"), "{turned:?}");
        let coarse = errors("cylinder", 0.001, |_, _| ());
        assert!(coarse.len() == 2 && coarse[1].contains("edges"), "{coarse:?}");
        // Voids have negative volume.
        let void = errors("cylinder", 0.05, |frame, shells| {
            let triangles = frame.batches.iter_mut().flat_map(|batch| &mut batch.mesh.triangles);
            triangles.for_each(|corners| corners.swap(0, 1));
            shells[0].voids = 1;
        });
        assert_eq!(void, [""; 0]);
    }
}
