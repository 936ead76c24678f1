//! `trimtess tessellate`: a CAD file to a mesh file within a chord and angle tolerance.

use crate::input::{self, Input};
use crate::levels::{self, Level};
use crate::limits::unprepared;
use crate::logging::Progress;
use crate::made::check_mesh;
use crate::outputs::{Named, Outputs};
use crate::report::{Seconds, lap};
use crate::{Common, Done, Failure, rounded};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use trimtess::control::{Control, Rayon};
use trimtess::frame::Tolerance;
use trimtess::mesh::{FrameView, MeshLists};
use trimtess::out::{Format, MeshLevel, Rounding, SaveOptions, Saved, read_back};
use trimtess::prepare::{Shells, prepare};

/// Tessellate a file to GLB, STL, PLY or OBJ.
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
    /// Coarser levels of detail in a GLB (MSFT_lod), each with 4 times the chord tolerance of the one before, and twice
    /// its angle. Limits hold for each.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u8).range(..=i64::from(levels::MOST)))]
    levels: u8,
    /// Write a report as JSON.
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
    /// Print the result to standard output as JSON.
    #[arg(long)]
    json: bool,
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
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("output", Some(&self.output)).output("report", self.report.as_ref())
    }

    fn format(&self) -> Result<Format, Failure> {
        let format =
            Format::of_path(&self.output).map_err(|e| Failure::Usage(format!("{}: {e}", self.output.display())))?;
        let is = |how| self.glb.contains(&how);
        match format {
            Format::Glb(plain) => Ok(Format::Glb(
                plain
                    .with_instanced(is(Compact::Instanced))
                    .with_quantized(is(Compact::Quantized))
                    .with_compressed(is(Compact::Compressed)),
            )),
            other => {
                let asked = [("--glb", !self.glb.is_empty()), ("--levels", self.levels > 0)];
                match asked.iter().find(|(_, is)| *is) {
                    Some((option, _)) => {
                        let output = self.output.display();
                        Err(Failure::Usage(format!("{option} is for .glb files, and not for {output}")))
                    }
                    None => Ok(other),
                }
            }
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
    /// Maximum angle by which the normal turns across a lattice cell, degrees; more than 90 count as 90.
    #[arg(long, value_name = "DEG", value_parser = positive, default_value_t = Tolerance::DEFAULT_ANGLE_DEGREES)]
    angle: f64,
    /// Maximum length of lattice cell diagonals and edge segments, millimetres.
    #[arg(long, value_name = "MM", value_parser = positive)]
    max_edge: Option<f64>,
}

impl ToleranceArgs {
    /// The tolerance for a model of this diagonal, millimetres.
    pub(crate) fn resolve(&self, diagonal: f64) -> Tolerance {
        let fraction = self.chord_rel.unwrap_or(Tolerance::DEFAULT_CHORD_REL);
        let chord = self.chord.unwrap_or(Tolerance::relative(fraction, diagonal).chord);
        Tolerance { chord, angle: self.angle.min(90.0).to_radians(), max_edge: self.max_edge }
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

pub(crate) fn run(args: &TessellateArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    let format = args.format()?;
    let progress = Progress::start(common);
    let mut begun = Instant::now();

    progress.stage(format!("reading {}", args.input.name()));
    let model = tracing::info_span!("read").in_scope(|| args.input.read(&common.limits.step()))?;
    let shells: Vec<Shells> = if args.check { model.parts.iter().map(Shells::of).collect() } else { Vec::new() };
    let read = lap(&mut begun);

    progress.stage("preparing");
    let prepared = tracing::info_span!("prepare").in_scope(|| prepare(model, &common.prepare()));
    let prepared = Arc::new(prepared.map_err(unprepared)?);
    let tolerance = args.tolerance.resolve(prepared.diagonal);
    let prepare = lap(&mut begun);

    progress.stage("tessellating");
    let lists =
        (matches!(format, Format::Glb(_)) || args.check, if args.check { MeshLists::ALL } else { MeshLists::NONE });
    let mut levels = Vec::new();
    for number in 0..=args.levels {
        if number > 0 {
            progress.stage(format!("tessellating level {number}"));
        }
        levels.push(Level::make(&prepared, &tolerance, number, lists, &common.limits)?);
    }
    let tessellate = lap(&mut begun);

    if args.check {
        progress.stage("checking");
        for Level { tolerance, frame, report } in &mut levels {
            check_mesh(&prepared, &shells, frame, tolerance.chord, report);
        }
    }
    let mut check = lap(&mut begun);

    progress.stage(format!("writing {}", args.output.display()));
    if args.recenter {
        let offset = prepared.centre();
        for Level { frame, report, .. } in &mut levels {
            frame.scene.translate(-offset);
            report.offset_mm = offset.to_array();
        }
    }
    let options = SaveOptions::new(format).with_max_rounding(Rounding::SHARE * tolerance.chord);
    let written = tracing::info_span!("write").in_scope(|| {
        let meshes =
            levels.iter().map(|level| MeshLevel { frame: (&level.frame).into(), chord: level.tolerance.chord });
        let meshes: Vec<MeshLevel<'_>> = meshes.collect();
        outputs.files().save_on(&Rayon, &meshes, &args.output, &options, &Control::default())
    });
    let Saved { roundings, temporary, .. } = written.map_err(|failure| {
        rounded::unwritten(&failure, &args.output, (&levels[0].frame.scene, args.recenter), &prepared, &options)
    })?;
    levels.iter_mut().zip(&roundings).for_each(|(level, rounding)| rounded::tell(rounding, &mut level.report));
    let write = lap(&mut begun);
    // Devices and pipes cannot be read back.
    if args.check && std::fs::metadata(&temporary).is_ok_and(|known| known.is_file()) {
        progress.stage("reading the file back");
        let frames: Vec<FrameView<'_>> = levels.iter().map(|level| (&level.frame).into()).collect();
        match read_back(&frames, &temporary, &options) {
            Ok(read) => levels.iter_mut().zip(&read).for_each(|(level, read)| {
                rounded::check(&prepared, read, level.tolerance.chord, &mut level.report);
            }),
            Err(error) => levels[0].report.add_error(format!("the file cannot be read back: {error}")),
        }
        check += lap(&mut begun);
    }
    let Level { frame, mut report, .. } = levels.remove(0);
    (1..).zip(levels).for_each(|(number, level)| level.add_to(&mut report, number));
    drop(progress);

    report.input = args.input.name();
    report.output = args.output.display().to_string();
    report.chord_mm = Some(tolerance.chord);
    report.angle_deg = Some(args.tolerance.angle.min(90.0));
    report.workers = rayon::current_num_threads();
    report.seconds = Seconds::new([read, prepare, tessellate, write], args.check.then_some(check));
    let done = report.publish(common, args.json, args.report.as_deref(), outputs);
    // The process is about to exit: dropping large structures would only delay it.
    std::mem::forget((prepared, frame));
    done
}
