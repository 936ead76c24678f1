//! Models built by calls: vertices, edges, shells, faces with loops or free trims, parts, instances.

use crate::border::handles::{Exclusive, Table};
use crate::border::{Caller, entry, versioned};
use crate::geometry::{curve, frame, points_in_plane, surface, tt_curve, tt_surface};
use crate::limits::{above_zero, choice, finite};
use crate::model::{add, tt_model};
use crate::status::{Failure, row, tt_status};
use std::f64::consts::TAU;
use std::ffi::c_char;
use std::sync::Mutex;
use trimtess::glam::{DAffine3, DVec2, DVec3};
use trimtess::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, FreeTrims, Instance, Loop, ModelBuilder, NurbsCurve3, Part, PartId, Shell,
    ShellKind, TrimCurve, TrimRule, VertexId,
};

/// A model while it is built, by one thread at a time: another one gets TT_ERROR_BUSY.
///
/// Parts, vertices, edges, shells, faces and instances have indices from 0, in the order in which they were added. What
/// is wrong with numbers and gaps is told by `tt_builder_finish`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_builder {
    pub id: u64,
}

/// What a shell bounds.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_shell_kind {
    /// Open, not known to be closed, or loose faces.
    TT_SHELL_OPEN = 0,
    /// The outer boundary of a solid: normals point outwards.
    TT_SHELL_OUTER = 1,
    /// A void of a solid: normals point into the void.
    TT_SHELL_VOID = 2,
}

/// Which points of a surface free trims keep. With u to the right and v up, a curve keeps its left side.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_trim_rule {
    /// What lies left of all curves.
    TT_TRIM_HANDEDNESS = 0,
    /// Where the winding numbers of all curves do not sum to 0.
    TT_TRIM_NON_ZERO = 1,
    /// Where they sum to an odd number.
    TT_TRIM_EVEN_ODD = 2,
}

/// One use of an edge by a loop. Will not grow.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_coedge {
    /// The edge.
    pub edge: u32,
    /// 1 if the loop runs against the edge, else 0.
    pub reversed: u32,
}

/// A placed part.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_placement {
    /// `sizeof(tt_placement)`.
    pub size: u32,
    /// The part.
    pub part: u32,
    /// Part to world, millimetres: x, y and z axis, then the origin, 3 numbers each. A rigid motion with an optional
    /// reflection and uniform scale. All zeros stand for the identity.
    pub transform: [f64; 12],
    /// 1 if `colour` overrides the colours of the faces.
    pub has_colour: u32,
    /// Red, green, blue (sRGB) and opacity, 0 to 1.
    pub colour: [f32; 4],
    /// 0.
    pub reserved: u32,
    /// Name; null for none. Copied.
    pub name: *const c_char,
}
versioned!(tt_placement, reserved);

#[derive(Default)]
struct Draft {
    name: String,
    parts: Vec<Part>,
    instances: Vec<Instance>,
}

static BUILDERS: Table<Exclusive<Draft>> = Table::new(3);

/// Adds to a model, and writes the index of what was added.
fn add_to(
    c: &Caller,
    builder: tt_builder,
    (name, index): (&str, *mut u32),
    work: impl FnOnce(&mut Draft) -> Result<usize, Failure>,
) -> Result<(), Failure> {
    let out = c.out_if(name, index)?;
    let added = BUILDERS.with(builder.id, work)?;
    out.into_iter().for_each(|out| out.give(added as u32));
    Ok(())
}

/// Adds to a part, and writes the index of what was added.
fn change(
    c: &Caller,
    (builder, part): (tt_builder, u32),
    index: (&str, *mut u32),
    work: impl FnOnce(&mut Part) -> Result<usize, Failure>,
) -> Result<(), Failure> {
    add_to(c, builder, index, |draft| work(draft.part(part)?))
}

impl Draft {
    fn part(&mut self, part: u32) -> Result<&mut Part, Failure> {
        let count = self.parts.len();
        self.parts.get_mut(part as usize).ok_or_else(|| Failure::index("part", part.into(), count))
    }
}

/// Adds a row to a table, and returns its index.
fn pushed<T>(table: &mut Vec<T>, row: T) -> Result<usize, Failure> {
    // Indices have 32 bits, of which one value means none.
    if table.len() >= u32::MAX as usize - 1 {
        return Err(Failure::argument("there are as many already as indices have numbers"));
    }
    table.push(row);
    Ok(table.len() - 1)
}

/// A vertex of a part.
fn vertex(part: &Part, vertex: u32) -> Result<(VertexId, DVec3), Failure> {
    Ok((VertexId(vertex), *row(&part.vertices, "vertex", vertex)?))
}

/// Adds an edge along the whole of a curve.
fn edge(part: &mut Part, curve: NurbsCurve3, kind: CurveKind, ends: [VertexId; 2]) -> Result<usize, Failure> {
    // The domain is asked for before `tt_builder_finish` checks the curve, and an invalid curve has no domain.
    curve.check().map_err(|error| Failure::argument(format!("curve: {error}")))?;
    let (range, [start, end]) = (curve.domain(), ends);
    pushed(&mut part.edges, Edge { curve, range, start, end, kind, entity: 0 })
}

/// Starts a model. `name` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_new(name: *const c_char, builder: *mut tt_builder) -> tt_status {
    entry!(c => {
        let (name, out) = (c.text_or_empty("name", name)?.to_owned(), c.out("builder", builder)?);
        out.give(tt_builder { id: BUILDERS.add(Mutex::new(Some(Draft { name, ..Draft::default() }))) });
        Ok(())
    })
}

/// Adds a part. `name` and `part` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_part(builder: tt_builder, name: *const c_char, part: *mut u32) -> tt_status {
    entry!(c => {
        let name = c.text_or_empty("name", name)?.to_owned();
        let new = Part { name, ..Part::default() };
        add_to(c, builder, ("part", part), |draft| pushed(&mut draft.parts, new))
    })
}

/// Adds a vertex, millimetres. `vertex`, as all pointers to an index in these functions, may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_vertex(
    builder: tt_builder,
    part: u32,
    x: f64,
    y: f64,
    z: f64,
    vertex: *mut u32,
) -> tt_status {
    entry!(c => {
        let place = finite("vertex", [x, y, z])?;
        change(c, (builder, part), ("vertex", vertex), |part| pushed(&mut part.vertices, place.into()))
    })
}

/// Adds a straight edge between two vertices.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_line(
    builder: tt_builder,
    part: u32,
    start: u32,
    end: u32,
    edge: *mut u32,
) -> tt_status {
    entry!(c => change(c, (builder, part), ("edge", edge), |part| {
        let [(start, from), (end, to)] = [vertex(part, start)?, vertex(part, end)?];
        self::edge(part, NurbsCurve3::line(from, to), CurveKind::Line, [start, end])
    }))
}

/// Adds a full circle about `axis` through `origin`, with a new vertex at `radius` in the direction of `reference`. Its
/// vertex is the last one then. The three point to 3 numbers each.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_circle(
    builder: tt_builder,
    part: u32,
    origin: *const f64,
    axis: *const f64,
    reference: *const f64,
    radius: f64,
    edge: *mut u32,
) -> tt_status {
    entry!(c => {
        let three = |name, numbers| c.slice(name, numbers, 3).map(|numbers| [numbers[0], numbers[1], numbers[2]]);
        let frame = frame(three("origin", origin)?, three("axis", axis)?, three("reference", reference)?)?;
        let radius = above_zero("radius", radius)?;
        let circle = NurbsCurve3::arc(&frame, radius, radius, 0.0, TAU);
        change(c, (builder, part), ("edge", edge), |part| {
            // The vertex comes with the edge, or neither does.
            let vertex = VertexId(part.vertices.len() as u32);
            let edge = self::edge(part, circle, CurveKind::Circle, [vertex, vertex])?;
            pushed(&mut part.vertices, frame.place(DVec3::X * radius))?;
            Ok(edge)
        })
    })
}

/// Adds an edge along the whole of a curve in space, which starts and ends at these vertices.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_edge(
    builder: tt_builder,
    part: u32,
    curve: *const tt_curve,
    start: u32,
    end: u32,
    edge: *mut u32,
) -> tt_status {
    entry!(c => {
        let curve = self::curve::<3, DVec3>(c, curve)?;
        change(c, (builder, part), ("edge", edge), |part| {
            let [(start, _), (end, _)] = [vertex(part, start)?, vertex(part, end)?];
            self::edge(part, curve, CurveKind::Spline, [start, end])
        })
    })
}

/// Adds a shell. `kind` is a `tt_shell_kind`. Faces of one shell are oriented together.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_shell(builder: tt_builder, part: u32, kind: u32, shell: *mut u32) -> tt_status {
    entry!(c => {
        let kind = choice!("kind of shell", kind, tt_shell_kind {
            TT_SHELL_OPEN => ShellKind::Open,
            TT_SHELL_OUTER => ShellKind::Outer,
            TT_SHELL_VOID => ShellKind::Void,
        });
        change(c, (builder, part), ("shell", shell), |part| pushed(&mut part.shells, Shell { kind, entity: 0 }))
    })
}

/// Adds a face, which is the whole surface until loops or trims are added. `reversed` is 1 if its outward normal is
/// opposite to the surface's, else 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_face(
    builder: tt_builder,
    part: u32,
    surface: *const tt_surface,
    shell: u32,
    reversed: u32,
    face: *mut u32,
) -> tt_status {
    entry!(c => {
        let surface = self::surface(c, surface)?;
        change(c, (builder, part), ("face", face), |part| {
            let count = part.shells.len();
            if shell as usize >= count {
                return Err(Failure::index("shell", shell.into(), count));
            }
            pushed(&mut part.faces, Face::new(surface, shell, Vec::new(), reversed != 0))
        })
    })
}

/// Changes a face.
fn in_face(
    builder: tt_builder,
    (part, face): (u32, u32),
    work: impl FnOnce(&mut Face, (usize, usize)) -> Result<(), Failure>,
) -> Result<(), Failure> {
    BUILDERS.with(builder.id, |draft| {
        let part = draft.part(part)?;
        let (faces, rest) = (part.faces.len(), (part.edges.len(), part.vertices.len()));
        work(part.faces.get_mut(face as usize).ok_or_else(|| Failure::index("face", face.into(), faces))?, rest)
    })
}

/// Sets the colour of a face: red, green, blue (sRGB) and opacity, 0 to 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_set_colour(
    builder: tt_builder,
    part: u32,
    face: u32,
    red: f32,
    green: f32,
    blue: f32,
    opacity: f32,
) -> tt_status {
    entry!(_c => {
        let colour = finite("colour", [red, green, blue, opacity].map(f64::from))?.map(|x| x as f32);
        in_face(builder, (part, face), |face, _| {
            face.colour = Some(colour);
            Ok(())
        })
    })
}

/// Bounds a face by edges, head to tail and closed; it lies left of them, seen from the tip of the surface's normal.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_loop(
    builder: tt_builder,
    part: u32,
    face: u32,
    coedges: *const tt_coedge,
    count: usize,
) -> tt_status {
    entry!(c => {
        let coedges = c.slice("coedges", coedges, count)?;
        in_face(builder, (part, face), |face, (edges, _)| {
            if let Some(bad) = coedges.iter().find(|coedge| coedge.edge as usize >= edges) {
                return Err(Failure::index("edge", bad.edge.into(), edges));
            }
            let of = |&tt_coedge { edge, reversed }: &tt_coedge| {
                Coedge { edge: EdgeId(edge), reversed: reversed != 0 }
            };
            face.loops.push(Loop::Edges(coedges.iter().map(of).collect()));
            Ok(())
        })
    })
}

/// Bounds a face at a single point, as an apex.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_vertex_loop(
    builder: tt_builder,
    part: u32,
    face: u32,
    vertex: u32,
) -> tt_status {
    entry!(_c => in_face(builder, (part, face), |face, (_, vertices)| {
        if vertex as usize >= vertices {
            return Err(Failure::index("vertex", vertex.into(), vertices));
        }
        face.loops.push(Loop::Vertex(VertexId(vertex)));
        Ok(())
    }))
}

/// Adds a free trim to a face that has no loops.
fn trim(builder: tt_builder, of: (u32, u32), rule: u32, curve: TrimCurve) -> Result<(), Failure> {
    let rule = choice!("trim rule", rule, tt_trim_rule {
        TT_TRIM_HANDEDNESS => TrimRule::Handedness,
        TT_TRIM_NON_ZERO => TrimRule::NonZero,
        TT_TRIM_EVEN_ODD => TrimRule::EvenOdd,
    });
    in_face(builder, of, |face, _| {
        let trims = face.trims.get_or_insert_with(|| FreeTrims { rule, curves: Vec::new() });
        trims.rule = rule;
        trims.curves.push(curve);
        Ok(())
    })
}

/// Trims a face by a curve in (u,v), open or closed. `rule` is a `tt_trim_rule`; that of the last trim holds for all
/// trims of the face. A face has loops or trims, not both.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_trim(
    builder: tt_builder,
    part: u32,
    face: u32,
    rule: u32,
    curve: *const tt_curve,
) -> tt_status {
    entry!(c => trim(builder, (part, face), rule, TrimCurve::nurbs(self::curve::<2, DVec2>(c, curve)?)))
}

/// Trims a face by straight lines through `count` points in (u,v), 2 numbers each, as `tt_builder_add_trim`. Repeat the
/// first point to close them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_add_polyline_trim(
    builder: tt_builder,
    part: u32,
    face: u32,
    rule: u32,
    points: *const f64,
    count: usize,
) -> tt_status {
    entry!(c => trim(builder, (part, face), rule, TrimCurve::polyline(points_in_plane(c, points, count)?)))
}

/// A transform of 12 numbers; the identity if all are 0.
pub(crate) fn transform(numbers: &[f64; 12]) -> DAffine3 {
    if *numbers == [0.0; 12] { DAffine3::IDENTITY } else { DAffine3::from_cols_array(numbers) }
}

/// Places a part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_place(
    builder: tt_builder,
    placement: *const tt_placement,
    instance: *mut u32,
) -> tt_status {
    entry!(c => {
        let from = c.read("placement", placement)?;
        let name = c.text_or_empty("placement.name", from.name)?.into();
        let colour = (from.has_colour != 0).then_some(from.colour);
        let (part, transform) = (PartId(from.part), transform(&from.transform));
        let placed = Instance { colour, name, ..Instance::new(part, transform) };
        add_to(c, builder, ("instance", instance), |draft| pushed(&mut draft.instances, placed))
    })
}

/// Makes the model as built so far, if it is a valid one. The builder stays, and may be used on. Costs a copy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_finish(builder: tt_builder, model: *mut tt_model) -> tt_status {
    entry!(c => {
        let out = c.out("model", model)?;
        let built = BUILDERS.with(builder.id, |draft| {
            let mut model = ModelBuilder::new(&*draft.name);
            draft.parts.iter().for_each(|part| _ = model.part(part.clone()));
            draft.instances.iter().for_each(|instance| _ = model.instance(instance.clone()));
            Ok(model)
        })?;
        out.give(add(built.finish()?));
        Ok(())
    })
}

/// Frees a builder, unless another call uses it. Models that it made stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_builder_free(builder: tt_builder) -> tt_status {
    entry!(_c => BUILDERS.end(builder.id))
}
