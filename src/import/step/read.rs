//! A file's bytes -> a model, by the steps of this folder.

use super::face_surface::Reader;
use super::options::{BYTES_PER_BYTE, StepError, StepOptions, proceed};
use super::product::StructureBuilder;
use super::style::{Styles, hidden};
use super::table::Table;
use super::text::{self, piece};
use super::tree::Tree;
use super::units::Contexts;
use crate::control::{Alone, Call, Control, Counter, Jobs, Rayon, Stage, width};
use crate::math::boxes::{Corner as _, around};
use crate::model::{Diagnostic, Instance, Model, Part, PartId, Severity, StepOutcome, surface_points};
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// Reads a STEP file. The model's name is the file's, without extension.
///
/// # Errors
/// As [`read`], and [`StepError::Io`] if the file cannot be read.
pub fn read_file(path: &Path, options: &StepOptions) -> Result<Model, StepError> {
    read_file_on(&Rayon, path, options, &Control::default())
}

/// As [`read_file`], on the threads of `jobs`, with progress and cancellation. The bytes are read before the first look
/// whether the work is cancelled. Threads of `jobs` read files above 16 MiB, and wait for the disk.
///
/// # Errors
/// As [`read_file`] and [`read_on`].
pub fn read_file_on(
    jobs: &dyn Jobs,
    path: &Path,
    options: &StepOptions,
    control: &Control,
) -> Result<Model, StepError> {
    let fail = |error| StepError::Io { path: path.to_owned(), error };
    let file = File::open(path).map_err(fail)?;
    let bytes = file.metadata().map_err(fail)?.len();
    check(bytes, options)?;
    // Devices and pipes have no length beforehand and may be endless.
    let most = options.max_bytes.min(options.max_memory / BYTES_PER_BYTE);
    let mut text = Vec::with_capacity(text::MAGIC_WITHIN);
    (&file).take(most.min(text::MAGIC_WITHIN as u64)).read_to_end(&mut text).map_err(fail)?;
    // A film or a disk image is refused before all of it is in memory.
    text::magic(&text)?;
    let call = Call::new(jobs, control);
    text = in_stretches(call, &file, bytes.min(most)).map_err(fail)?.unwrap_or(text);
    let rest = usize::try_from(bytes.min(most)).unwrap_or(usize::MAX).saturating_sub(text.len());
    text.try_reserve_exact(rest).map_err(|error| fail(error.into()))?;
    (&file).take(most.saturating_add(1).saturating_sub(text.len() as u64)).read_to_end(&mut text).map_err(fail)?;
    let piece = piece(text.len(), width(jobs));
    let mut model = read_in_pieces(call, text.into(), options, piece)?;
    model.name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(model)
}

/// The first `length` bytes of a file, read on all threads, because new pages take longer than the copy into them. The
/// handle is left behind them. `None` if one thread reads them as fast, or if the file is shorter, the length above
/// `MOST`, or the system cannot read it by position.
///
/// One handle reads all: if another file takes the name meanwhile, the old one is read.
fn in_stretches(call: Call<'_>, mut file: &File, length: u64) -> io::Result<Option<Vec<u8>>> {
    /// Bytes that a thread reads at a time.
    const STRETCH: usize = 1 << 18;
    /// The program's allocator clears room of at most this length, and so touches all pages on one thread. Without
    /// that, one thread reads them in the same time.
    const CLEARED: u64 = 1 << 24;
    /// Larger files are read into room that the system can refuse without an abort.
    const MOST: u64 = 1 << 28;
    if !cfg!(unix) || width(call.jobs) < 2 || length <= CLEARED || length > MOST {
        return Ok(None);
    }
    // The system's zeros are pages that nobody has touched.
    let mut text = vec![0; length as usize];
    let stretches = text.chunks_mut(STRETCH).enumerate();
    let read = call.each(1, stretches, |(k, stretch)| read_at(file, stretch, (k * STRETCH) as u64));
    if read.iter().any(Result::is_err) {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(length))?;
    Ok(Some(text))
}

#[cfg(unix)]
fn read_at(file: &File, to: &mut [u8], from: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, to, from)
}

#[cfg(not(unix))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

fn check(bytes: u64, options: &StepOptions) -> Result<(), StepError> {
    let asked = options.fit_tolerance;
    if !(asked > 0.0 && asked.is_finite()) {
        return Err(StepError::FitTolerance { asked });
    }
    if bytes > options.max_bytes {
        return Err(StepError::TooLarge { bytes, limit: options.max_bytes });
    }
    let needed = bytes.saturating_mul(BYTES_PER_BYTE);
    if needed > options.max_memory {
        return Err(StepError::TooMuchMemory { needed, limit: options.max_memory });
    }
    Ok(())
}

/// Reads the text of a STEP file.
///
/// Each product definition with geometry becomes one part, placed as often as the assembly says. Geometry without a
/// product becomes parts that are placed once. [`Model::diagnostics`] reports everything that is not understood; the
/// rest is read all the same. A file without faces gives an empty model. A part further from the origin than 4096 of
/// its diagonals has coordinates relative to its centre, and its instances place it. The model's name is empty; that of
/// `read_file` is the file's. Runs on [`Rayon`]'s threads.
///
/// # Errors
/// If the bytes are not STEP text, their syntax is beyond repair, a limit of `options` is exceeded, or an option is out
/// of range.
pub fn read(bytes: &[u8], options: &StepOptions) -> Result<Model, StepError> {
    read_on(&Rayon, bytes, options, &Control::default())
}

/// As [`read`], on the threads of `jobs`, with progress and cancellation. The syntax is parsed in pieces before the
/// first progress is reported. Cancelling takes effect between these pieces, between parts and within them.
///
/// # Errors
/// As [`read`], and [`StepError::Cancelled`].
pub fn read_on(jobs: &dyn Jobs, bytes: &[u8], options: &StepOptions, control: &Control) -> Result<Model, StepError> {
    read_in_pieces(Call::new(jobs, control), bytes.into(), options, piece(bytes.len(), width(jobs)))
}

/// As [`read_on`], with a length of the pieces in which the syntax is parsed. A text that is handed over is freed once
/// it is parsed: the model takes its pages.
fn read_in_pieces(
    call: Call<'_>,
    bytes: Cow<'_, [u8]>,
    options: &StepOptions,
    piece: usize,
) -> Result<Model, StepError> {
    check(bytes.len() as u64, options)?;
    let mut diagnostics = Vec::new();
    let table = text::parse(call, bytes, options, piece, &mut diagnostics)?;
    model_of(call, &table, options, diagnostics)
}

/// The model that the instances of a file state. `diagnostics` are those of its text.
fn model_of(
    call: Call<'_>,
    table: &Table,
    options: &StepOptions,
    mut diagnostics: Vec<Diagnostic>,
) -> Result<Model, StepError> {
    let control = call.control;
    proceed(control)?;
    let contexts = Contexts::read(table);
    let styles = Styles::read(table);
    let structure = StructureBuilder::build(table, &contexts, &styles, options);
    proceed(control)?;
    let mut tree = Tree::new(table, &contexts, &styles, options, structure);
    tree.expand();
    proceed(control)?;
    if tree.visits > options.max_instances {
        return Err(StepError::TooManyInstances { limit: options.max_instances });
    }
    if let Some(entity) = tree.beyond {
        return Err(StepError::TooManyOccurrences { entity, limit: table.budget.max_occurrences() });
    }
    within(table, options)?;
    let Tree { gather, planned, instances, has_bare, diagnostics: of_tree, .. } = tree;
    let reader = Reader { call, table, styles: &styles, colours_of_copies: &gather.copies.colours, options };
    // A file may mix units; the model states those of the first part.
    let first = planned.first().and_then(|plan| plan.gathered.units());
    let millimetres_per_unit = first.unwrap_or(contexts.first).length;
    let counter = Counter::start(control, Stage::Read, planned.len() as u64);
    let read_on = |call: Call<'_>, counts: bool| -> Vec<Option<_>> {
        let reader = Reader { call, ..reader };
        call.each_by_size(
            &planned,
            |plan| plan.gathered.size(),
            |plan| {
                let read = (!control.is_cancelled()).then(|| reader.part(&plan.name, &plan.gathered, plan.colour));
                let (mut part, mut found) = read?;
                let centre = about_its_centre(&mut part, &mut found);
                if counts {
                    counter.advance();
                }
                Some((part, found, centre))
            },
        )
    };
    let before = table.budget.so_far();
    let mut read = read_on(call, true);
    // What comes first keeps its points: one thread alone reads in the order of the file.
    if width(call.jobs) > 1 && table.budget.has_refused_points() {
        call.discard(read);
        table.budget.go_back(before);
        read = read_on(Call::new(&Alone, control), false);
    }
    proceed(control)?;
    within(table, options)?;
    let mut model = Model { millimetres_per_unit, instances, ..Model::default() };
    let mut centres = Vec::with_capacity(read.len());
    for (part, found, centre) in read.into_iter().flatten().take_while(|_| !control.is_cancelled()) {
        let id = Some(PartId::new(model.parts.len()));
        centres.push(centre);
        diagnostics.extend(found.into_iter().map(|d| Diagnostic { part: id, ..d }));
        model.parts.push(part);
    }
    // Instances name parts that a cancel has left out.
    proceed(control)?;
    for Instance { part, transform, .. } in &mut model.instances {
        if let Some(centre) = centres[part.index()] {
            *transform *= DAffine3::from_translation(centre);
        }
    }
    diagnostics.extend(of_tree);
    if let Some(unit) = contexts.unread {
        diagnostics.push(Diagnostic { entity: unit, ..Diagnostic::new(Severity::Error, StepOutcome::UnitNotRead) });
    }
    if !contexts.stated && !model.parts.is_empty() {
        diagnostics.push(of_file(StepOutcome::NoUnit));
    }
    if let Some((context, unit_mm)) = contexts.out_of_range {
        let what = StepOutcome::UnitOutOfRange { unit_mm };
        diagnostics.push(Diagnostic { entity: context, ..Diagnostic::new(Severity::Error, what) });
    }
    if styles.along_paths > 0 {
        diagnostics.push(of_file(StepOutcome::PathColours { count: styles.along_paths }));
    }
    diagnostics.extend(foreign_files(table, has_bare));
    let items = hidden(table);
    if items > 0 {
        diagnostics.push(Diagnostic::new(Severity::Note, StepOutcome::Hidden { items }));
    }
    let lost = diagnostics.iter().any(|d| d.severity == Severity::Error);
    if !lost && model.parts.iter().all(|part| part.faces.is_empty()) {
        diagnostics.push(of_file(StepOutcome::NoFaces { instances: table.len() }));
    }
    model.diagnostics = diagnostics;
    Ok(model)
}

/// Names STEP files among the documents that the file refers to. A warning if a product has neither a shape nor
/// components (`has_bare`): its shape may be in one of them. Else a note.
fn foreign_files(table: &Table, has_bare: bool) -> Option<Diagnostic> {
    /// Maximum number of files to name.
    const NAMED: usize = 5;
    let ends = [".stp", ".step", ".p21", ".stpz", ".stp.gz"];
    let is_step = |name: &str| ends.into_iter().any(|end| name.to_ascii_lowercase().ends_with(end));
    let documents = table.of_types(|i| i.is("DOCUMENT_FILE")).map(|i| i.fields("DOCUMENT", 0));
    let found = documents.filter_map(|own| [own.text(0), own.text(1)].into_iter().find(|name| is_step(name)));
    let names: BTreeSet<&str> = found.collect();
    let first = names.iter().take(NAMED).map(|&name| name.to_owned()).collect();
    let severity = if has_bare { Severity::Warning } else { Severity::Note };
    (!names.is_empty()).then(|| Diagnostic::new(severity, StepOutcome::ForeignFiles { count: names.len(), first }))
}

/// The box around a part. `None` as soon as some of its points tell that it is near the origin for its size: nearly all
/// parts are, and a box stays so as it grows.
fn box_unless_near(part: &Part) -> Option<[DVec3; 2]> {
    let mut seen = around([]);
    for point in part.points_of_edges().chain(part.faces_without_edges().flat_map(surface_points)) {
        seen = point.added(seen);
        let [low, high] = seen;
        if low.length() <= 0.5 * FAR * (high - low).length() {
            return None;
        }
    }
    Some(seen)
}

/// Moves a part further than [`FAR`] from the origin to it, with what was said of it, and reports that. Returns where
/// its centre was. Otherwise every surface would be computed in numbers that have few digits for it.
fn about_its_centre(part: &mut Part, found: &mut Vec<Diagnostic>) -> Option<DVec3> {
    let [low, high] = box_unless_near(part)?;
    let (centre, size_mm) = (0.5 * low + 0.5 * high, (high - low).length());
    let distance_mm = centre.length();
    if !(size_mm > 0.0 && distance_mm.is_finite() && distance_mm > FAR * size_mm) {
        return None;
    }
    part.translate(-centre);
    found.iter_mut().filter_map(|told| told.place.as_mut()).for_each(|place| *place -= centre);
    found.push(Diagnostic::new(Severity::Note, StepOutcome::FarPart { distance_mm, size_mm }));
    Some(centre)
}

/// Distance from the origin, in diagonals of a part, beyond which its coordinates become relative to its centre: double
/// precision has twelve digits for it there.
const FAR: f64 = 4096.0;

/// Fails once reading takes more memory than `options` allow.
fn within(table: &Table, options: &StepOptions) -> Result<(), StepError> {
    let refused = |needed| Err(StepError::TooMuchMemory { needed, limit: options.max_memory });
    table.budget.exceeded().map_or(Ok(()), refused)
}

/// A warning that concerns the file as a whole.
fn of_file(what: StepOutcome) -> Diagnostic {
    Diagnostic::new(Severity::Warning, what)
}

#[cfg(test)]
mod tests;
