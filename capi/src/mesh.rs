//! Prepared models -> meshes within a tolerance everywhere, kept by the library.

use crate::border::handles::Table;
use crate::border::{Caller, entry, versioned};
use crate::control::{control, tt_control};
use crate::diagnostic::{self, tt_diagnostic};
use crate::limits::{plan_limits, positive};
use crate::prepared::{self, tt_prepared};
use crate::status::{Failure, row, tt_status};
use crate::threads::{Workplace, at_most};
use std::ffi::c_char;
use std::sync::Arc;
use trimtess::frame::{Plan, PlanLimits, Tolerance, plan_on};
use trimtess::mesh::PackedFrame;
use trimtess::model::{Diagnostic, PartId};
use trimtess::parallel::{FrameReport, tessellate_on};
use trimtess::prepare::Prepared;

/// A mesh of a whole model, part by part. It does not change, and any number of threads may use it at the same time.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_mesh {
    pub id: u64,
}

/// How close a mesh is to the surfaces, and limits of its size. Numbers are finite.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_tolerance {
    /// `sizeof(tt_tolerance)`.
    pub size: u32,
    /// 1 makes a coarser mesh where limits do not allow the tolerance; 0 refuses with TT_ERROR_LIMIT.
    pub coarsen: u32,
    /// Largest distance between triangles and surface, millimetres; 0 if `chord_rel` is given.
    pub chord: f64,
    /// The same as a fraction of the diagonal of the placed model; 0 if `chord` is given.
    pub chord_rel: f64,
    /// Largest turn of the normal across a lattice cell, radians; 0 = 20 degrees.
    pub angle: f64,
    /// Longest diagonal of a lattice cell and segment of an edge, millimetres; 0 = any.
    pub max_edge: f64,
    /// Triangles at most; 0 = 64 million.
    pub max_triangles: u64,
    /// Triangles of one tile at most; 0 = 8 million.
    pub max_tile_triangles: u64,
    /// Memory of mesh and prepared model at most, bytes, estimated; 0 = 16 GiB.
    pub max_memory: u64,
}
versioned!(tt_tolerance);

/// How `tt_tessellate` works. Zeros are the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_tessellate_options {
    /// `sizeof(tt_tessellate_options)`.
    pub size: u32,
    /// Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    /// file; 1 = the caller's alone.
    pub threads: u32,
    /// 1 makes the polylines of edges, too.
    pub edge_lines: u32,
    /// 0.
    pub reserved: u32,
}
versioned!(tt_tessellate_options, reserved);

/// What a mesh has.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_mesh_info {
    /// `sizeof(tt_mesh_info)`.
    pub size: u32,
    /// Number of parts, those of the prepared model.
    pub parts: u32,
    /// Number of triangles, each part once.
    pub triangles: u64,
    /// Number of vertices, each part once.
    pub vertices: u64,
    /// Number of diagnostics of reading, preparing and tessellating.
    pub diagnostics: u32,
    /// 1 if limits made the mesh coarser than the tolerance; else 0.
    pub coarsened: u32,
}
versioned!(tt_mesh_info);

/// The mesh of a part, in its own coordinates. The arrays are valid until the mesh is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_mesh_part {
    /// `sizeof(tt_mesh_part)`.
    pub size: u32,
    /// Number of vertices. Tiles do not share vertices; equal points have equal bits.
    pub vertices: u32,
    /// Number of triangles.
    pub triangles: u64,
    /// 3 numbers per vertex, millimetres.
    pub positions: *const f64,
    /// 3 numbers per vertex: unit normals that point outwards.
    pub normals: *const f32,
    /// 2 numbers per vertex, in the natural parameters of the face's surface.
    pub uvs: *const f32,
    /// 3 vertices per triangle, counter-clockwise seen from outside.
    pub indices: *const u32,
    /// The face of each triangle, within the part.
    pub faces: *const u32,
    /// Number of polylines.
    pub lines: u64,
}
versioned!(tt_mesh_part);

/// The polyline of an edge.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_line {
    /// `sizeof(tt_line)`.
    pub size: u32,
    /// The part.
    pub part: u32,
    /// The edge within the part.
    pub edge: u32,
    /// Number of points.
    pub count: u32,
    /// 3 numbers per point, millimetres, part coordinates, from the edge's start to its end. Valid until the mesh is
    /// freed; in a callback, until it returns.
    pub points: *const f64,
}
versioned!(tt_line);

struct Mesh {
    frame: PackedFrame,
    diagnostics: Vec<Diagnostic>,
    coarsened: bool,
}

static MESHES: Table<Mesh> = Table::new(5);

/// The tolerance and limits that C states, and whether limits may make the mesh coarser.
pub(crate) fn tolerance(
    c: &Caller,
    from: *const tt_tolerance,
    diagonal: f64,
) -> Result<(Tolerance, PlanLimits, bool), Failure> {
    let from = c.read("tolerance", from)?;
    let number = |field: &str, value| positive(&format!("tolerance.{field}"), value);
    let chord = match (number("chord", from.chord)?, number("chord_rel", from.chord_rel)?) {
        (Some(chord), None) => chord,
        (None, Some(fraction)) => Tolerance::relative(fraction, diagonal).chord,
        _ => return Err(Failure::argument("one of tolerance.chord and chord_rel must be above 0, the other 0")),
    };
    let angle = number("angle", from.angle)?.unwrap_or(Tolerance::DEFAULT_ANGLE_DEGREES.to_radians());
    let max_edge = number("max_edge", from.max_edge)?;
    let limits = plan_limits(from.max_triangles, from.max_tile_triangles, from.max_memory);
    Ok((Tolerance { chord, angle, max_edge }, limits, from.coarsen != 0))
}

/// The plan, unless limits make it coarser than they may.
pub(crate) fn allowed(plan: Plan, coarsen: bool) -> Result<Arc<Plan>, Failure> {
    let plan = if coarsen { Ok(plan) } else { plan.require_full() };
    plan.map(Arc::new).map_err(|short| Failure::new(tt_status::TT_ERROR_LIMIT, short.to_string()))
}

/// Tessellates a whole model within a tolerance. The mesh is the same for any number of threads, byte by byte.
///
/// The mesh is kept as arrays per part: about 115 bytes per triangle while it is made, and half of that afterwards.
/// Tiles may go into the caller's own memory and layout instead, by `tt_session_tessellate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_tessellate(
    prepared: tt_prepared,
    tolerance: *const tt_tolerance,
    options: *const tt_tessellate_options,
    control: tt_control,
    mesh: *mut tt_mesh,
) -> tt_status {
    entry!(c => {
        let (prepared, out) = (prepared::get(prepared)?, c.out("mesh", mesh)?);
        let (tolerance, limits, coarsen) = self::tolerance(c, tolerance, prepared.diagonal)?;
        let (options, control) = (c.read_or_zeros("options", options)?, self::control(control)?);
        let made = Workplace::Own(at_most(options.threads)?).run(|jobs| -> Result<Mesh, Failure> {
            let plan = allowed(plan_on(jobs, &prepared, &tolerance, &limits, &control)?, coarsen)?;
            let mut frame = PackedFrame::default();
            let report = tessellate_on(jobs, &prepared, &plan, options.edge_lines != 0, &control, &mut frame)?;
            Ok(made(frame, &report, (&prepared, &plan)))
        })??;
        out.give(tt_mesh { id: MESHES.add(made) });
        Ok(())
    })
}

fn made(frame: PackedFrame, report: &FrameReport, (prepared, plan): (&Prepared, &Plan)) -> Mesh {
    let diagnostics = report.diagnostics(&frame, prepared);
    Mesh { frame, diagnostics, coarsened: plan.shortfall.as_ref().is_some_and(|short| short.by_limits()) }
}

/// Counts what a mesh has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_mesh_get_info(mesh: tt_mesh, info: *mut tt_mesh_info) -> tt_status {
    entry!(c => {
        let (mesh, out) = (MESHES.get(mesh.id)?, c.out_struct("info", info)?);
        let parts = &mesh.frame.parts;
        out.give(&tt_mesh_info {
            size: 0,
            parts: parts.len() as u32,
            triangles: parts.iter().map(|part| part.triangles.len() as u64).sum(),
            vertices: parts.iter().map(|part| part.positions.len() as u64).sum(),
            diagnostics: mesh.diagnostics.len() as u32,
            coarsened: mesh.coarsened.into(),
        });
        Ok(())
    })
}

/// Gives the arrays of a part. Copies nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_mesh_get_part(mesh: tt_mesh, index: u32, part: *mut tt_mesh_part) -> tt_status {
    entry!(c => {
        let (mesh, out) = (MESHES.get(mesh.id)?, c.out_struct("part", part)?);
        let found = row(&mesh.frame.parts, "part", index)?;
        out.give(&tt_mesh_part {
            size: 0,
            vertices: found.positions.len() as u32,
            triangles: found.triangles.len() as u64,
            positions: found.positions.as_ptr().cast(),
            normals: found.normals.as_ptr().cast(),
            uvs: found.uvs.as_ptr().cast(),
            indices: found.triangles.as_ptr().cast(),
            faces: found.face_ids.as_ptr(),
            lines: mesh.frame.edge_lines_of(PartId(index)).len() as u64,
        });
        Ok(())
    })
}

/// Gives the polyline of an edge of a part, by its index among those of the part. Copies nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_mesh_get_line(mesh: tt_mesh, part: u32, index: u64, line: *mut tt_line) -> tt_status {
    entry!(c => {
        let (mesh, out) = (MESHES.get(mesh.id)?, c.out_struct("line", line)?);
        out.give(&as_line(row(mesh.frame.edge_lines_of(PartId(part)), "line", index)?));
        Ok(())
    })
}

pub(crate) fn as_line(line: &trimtess::mesh::EdgeLine) -> tt_line {
    tt_line {
        size: size_of::<tt_line>() as u32,
        part: line.part.0,
        edge: line.edge.0,
        count: line.points.len() as u32,
        points: line.points.as_ptr().cast(),
    }
}

/// Gives a diagnostic of reading, preparing and tessellating, and copies its message into `text`. `diagnostic` may be
/// null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_mesh_get_diagnostic(
    mesh: tt_mesh,
    index: u32,
    diagnostic: *mut tt_diagnostic,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => {
        let mesh = MESHES.get(mesh.id)?;
        diagnostic::give(c, (&mesh.diagnostics, index), diagnostic, (text, capacity, length))
    })
}

/// Frees a mesh, and its arrays with it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_mesh_free(mesh: tt_mesh) -> tt_status {
    entry!(_c => MESHES.free(mesh.id))
}
