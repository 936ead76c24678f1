//! Items of a representation to shells: lists of faces with the way each is used.

use super::body::{BodyKind, refused};
use super::style::Styles;
use super::sweep::profile;
use super::table::{Instance, MAX_DEPTH, Read, Set, Table, Trouble};
use super::tessellated::stands_for;
use super::units::Units;
use crate::model::{Colour, Shell, ShellKind};
use std::collections::BTreeMap;

/// Where a face comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// An `ADVANCED_FACE` or `FACE_SURFACE`.
    Face(u64),
    /// A bounded surface without topology, as geometric sets hold them.
    Surface(u64),
}

impl Source {
    pub(super) fn id(self) -> u64 {
        match self {
            Self::Face(id) | Self::Surface(id) => id,
        }
    }
}

/// One shell as a body uses it.
#[derive(Clone, Debug)]
pub(super) struct ShellUse {
    pub(super) kind: ShellKind,
    pub(super) entity: u64,
    /// The faces, and whether the use turns them over.
    pub(super) faces: Vec<(Source, bool)>,
    /// Colour of faces that have none.
    pub(super) colour: Option<Colour>,
    pub(super) units: Units,
}

/// A body without stated faces.
#[derive(Clone, Debug)]
pub(super) struct BodyUse {
    pub(super) kind: BodyKind,
    pub(super) entity: u64,
    pub(super) colour: Option<Colour>,
    pub(super) units: Units,
}

/// Gathers shells and remembers what is taken, so that leftovers can be found.
pub(super) struct Gather<'a> {
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Items, shells and faces that some part has taken, of the whole file.
    pub(super) taken: Set<u64>,
    /// Items that annotations draw: texts and arrows, not shapes.
    pub(super) annotations: Set<u64>,
    /// Representation items that hold geometry of a kind that is not read.
    pub(super) unread: Vec<(Trouble, Units)>,
    /// The representation whose items are being gathered, 0 for none.
    pub(super) within: u64,
    /// Whether supplemental geometry is asked for.
    supplemental: bool,
    /// Items that are no part of a shape, by representation and number: of what type.
    pub(super) aside: BTreeMap<u64, BTreeMap<u64, String>>,
}

/// What was gathered for one part.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) shells: Vec<ShellUse>,
    pub(super) bodies: Vec<BodyUse>,
    /// Items, shells and faces in this part already: a part holds each once, however often its representations list it.
    pub(super) held: Set<u64>,
}

/// What annotations draw.
fn annotated(table: &Table) -> Set<u64> {
    let occurrences = table.of_types(|i| i.types().any(|name| name.ends_with("ANNOTATION_OCCURRENCE")));
    occurrences.filter_map(|i| i.fields("STYLED_ITEM", 1).optional(1)).collect()
}

impl Gathered {
    pub(super) fn is_empty(&self) -> bool {
        self.shells.is_empty() && self.bodies.is_empty()
    }

    /// What the numbers of the first shell or body mean.
    pub(super) fn units(&self) -> Option<Units> {
        self.shells.first().map(|shell| shell.units).or(self.bodies.first().map(|body| body.units))
    }
}

impl<'a> Gather<'a> {
    pub(super) fn new(table: &'a Table, styles: &'a Styles, supplemental: bool) -> Self {
        let (taken, unread, aside) = Default::default();
        Self { table, styles, taken, annotations: annotated(table), unread, within: 0, supplemental, aside }
    }

    /// Counts an item as no part of the shape.
    pub(super) fn put_aside(&mut self, item: u64) {
        let keyword = self.table.find(item).map_or_else(|| "missing".to_owned(), |item| item.keyword());
        self.aside.entry(self.within).or_default().insert(item, keyword);
    }

    /// Marks the items of a representation as taken without reading them, with all that they hold, and counts them.
    pub(super) fn leave_out(&mut self, representation: u64, items: impl Iterator<Item = u64>) {
        let mut withheld = Gathered::default();
        let (told, aside) = (self.unread.len(), std::mem::take(&mut self.aside));
        let items: Vec<u64> = items.collect();
        items.iter().for_each(|item| self.item(*item, Units::DEFAULT, &mut withheld));
        // What these told and counted is of what is not read.
        self.unread.truncate(told);
        self.aside = aside;
        self.within = representation;
        items.into_iter().for_each(|item| self.put_aside(item));
    }

    /// Adds the shells of a representation item.
    pub(super) fn item(&mut self, id: u64, units: Units, into: &mut Gathered) {
        let read = self.table.get(id).and_then(|item| self.try_item(item, units, into));
        if let Err(trouble) = read {
            self.unread.push((trouble, units));
        }
    }

    fn try_item(&mut self, item: Instance<'_>, units: Units, into: &mut Gathered) -> Read<()> {
        let colour = self.styles.of(item.id);
        if item.is("MANIFOLD_SOLID_BREP") || item.is("BREP_WITH_VOIDS") || item.is("FACETED_BREP") {
            if !self.take(item.id, into) {
                return Ok(());
            }
            let outer = item.fields("MANIFOLD_SOLID_BREP", 1).reference(0)?;
            self.shell(outer, ShellKind::Outer, colour, units, into)?;
            if item.is("BREP_WITH_VOIDS") {
                for void in item.fields("BREP_WITH_VOIDS", 2).links(0)? {
                    self.shell(void, ShellKind::Void, colour, units, into)?;
                }
            }
        } else if item.is("SHELL_BASED_SURFACE_MODEL") || item.is("FACE_BASED_SURFACE_MODEL") {
            if !self.take(item.id, into) {
                return Ok(());
            }
            // Both list their shells or face sets behind the name.
            let name = if item.is("SHELL_BASED_SURFACE_MODEL") {
                "SHELL_BASED_SURFACE_MODEL"
            } else {
                "FACE_BASED_SURFACE_MODEL"
            };
            for shell in item.fields(name, 1).links(0)? {
                self.shell(shell, ShellKind::Open, colour, units, into)?;
            }
        } else if is_shell(item) {
            // A shell listed beside the body it bounds is that body's.
            if !into.held.contains(&item.id) {
                self.shell(item.id, ShellKind::Open, colour, units, into)?;
            }
        } else if is_face(item) {
            if self.take(item.id, into) {
                let faces = vec![(Source::Face(item.id), false)];
                into.shells.push(ShellUse { kind: ShellKind::Open, entity: item.id, faces, colour: None, units });
            }
        } else if item.is("GEOMETRIC_SET") {
            self.set(item, colour, units, into)?;
        } else if item.is("CSG_SOLID") {
            // One primitive is a solid; what several make is refused there.
            let root = self.table.get(item.fields("CSG_SOLID", 1).reference(0)?)?;
            if root.is("CSG_SOLID") {
                return Err(Trouble::new(item.id, "a CSG_SOLID of a CSG_SOLID"));
            }
            if self.take(item.id, into) {
                let known = into.bodies.len();
                self.try_item(root, units, into)?;
                into.bodies[known..].iter_mut().for_each(|body| body.colour = body.colour.or(colour));
            }
        } else if item.is("SOLID_REPLICA") {
            // The product structure places it, like an occurrence of its parent.
            self.taken.insert(item.id);
        } else if let Some(reason) = refused(item) {
            self.operands(item, 0);
            let operator = item.fields("BOOLEAN_RESULT", 1).keyword(0);
            let operator = if operator.is_empty() { String::new() } else { format!(" ({operator})") };
            let reason = format!("the body of type {}{operator} is not read: {reason}", item.keyword());
            return Err(Trouble::new(item.id, reason));
        } else if let Some(kind) = BodyKind::of(item) {
            if kind == BodyKind::Tessellated && self.annotations.contains(&item.id) {
                self.taken.insert(item.id);
            } else if self.take(item.id, into) {
                // The face that is swept is no face of its own.
                self.taken.extend(profile(item));
                into.bodies.push(BodyUse { kind, entity: item.id, colour, units });
            }
        } else if is_surface(item) {
            // A construction that is asked for is read as far as it has ends; a face tells that it has none.
            if !(is_bounded(item) || self.supplemental && !is_endless(item)) {
                self.put_aside(item.id);
            } else if self.take(item.id, into) {
                let faces = vec![(Source::Surface(item.id), false)];
                into.shells.push(ShellUse { kind: ShellKind::Open, entity: item.id, faces, colour, units });
            }
        } else if !is_shapeless(item) && !self.annotations.contains(&item.id) && self.take(item.id, into) {
            return Err(Trouble::new(item.id, format!("items of type {} are not read", item.keyword())));
        }
        Ok(())
    }

    /// Marks a body and what it is made of as taken: with the body refused, its operands are no bodies of their own.
    fn operands(&mut self, body: Instance<'_>, depth: usize) {
        if !self.taken.insert(body.id) || depth >= MAX_DEPTH {
            return;
        }
        for operand in parts_of(body) {
            if let Some(operand) = self.table.find(operand) {
                self.operands(operand, depth + 1);
            }
        }
    }

    /// Leaves out tessellated bodies of a part that has exact ones: they repeat those. Says how many.
    pub(super) fn repeated(&self, gathered: &mut Gathered) -> usize {
        let before = gathered.bodies.len();
        let exact = !gathered.shells.is_empty() || gathered.bodies.iter().any(|b| b.kind != BodyKind::Tessellated);
        gathered.bodies.retain(|body| {
            let stands_for = self.table.find(body.entity).and_then(stands_for);
            let linked =
                stands_for.is_some_and(|id| self.taken.contains(&id) || self.table.find(id).is_some_and(is_body));
            body.kind != BodyKind::Tessellated || !(exact || linked)
        });
        before - gathered.bodies.len()
    }

    /// Whether `id` is new to the part; marks it as taken.
    fn take(&mut self, id: u64, into: &mut Gathered) -> bool {
        self.taken.insert(id);
        into.held.insert(id)
    }

    fn shell(
        &mut self,
        id: u64,
        kind: ShellKind,
        colour: Option<Colour>,
        units: Units,
        into: &mut Gathered,
    ) -> Read<()> {
        let (mut shell, mut turned) = (self.table.get(id)?, false);
        let mut colour = self.styles.of(id).or(colour);
        for _ in 0..MAX_DEPTH {
            let oriented = ["ORIENTED_CLOSED_SHELL", "ORIENTED_OPEN_SHELL"].into_iter().find(|name| shell.is(name));
            let Some(oriented) = oriented else { break };
            // name, (the faces, derived), shell, orientation
            let own = shell.fields(oriented, 2);
            turned ^= !own.flag(1, true);
            self.taken.insert(shell.id);
            shell = self.table.get(own.reference(0)?)?;
            colour = self.styles.of(shell.id).or(colour);
        }
        if !is_shell(shell) {
            return Err(Trouble::new(id, format!("{} where a shell is needed", shell.keyword())));
        }
        // Two bodies may be bounded by one shell; each gets its faces.
        self.take(shell.id, into);
        let mut faces = Vec::new();
        for face in shell.fields("CONNECTED_FACE_SET", 1).links(0)? {
            // What is no face fails when it is read, and is counted then.
            let (face, over) = self.face(face);
            self.taken.insert(face);
            into.held.insert(face);
            faces.push((Source::Face(face), turned != over));
        }
        into.shells.push(ShellUse { kind, entity: shell.id, faces, colour, units });
        Ok(())
    }

    /// Follows `ORIENTED_FACE`s as far as they lead; whether they turn the face over.
    fn face(&self, id: u64) -> (u64, bool) {
        let (mut at, mut over) = (id, false);
        for _ in 0..MAX_DEPTH {
            let Some(face) = self.table.find(at).filter(|face| face.is("ORIENTED_FACE")) else { break };
            let own = face.fields("ORIENTED_FACE", 2);
            let Ok(next) = own.reference(0) else { break };
            over ^= !own.flag(1, true);
            at = next;
        }
        (at, over)
    }

    fn set(&mut self, set: Instance<'_>, colour: Option<Colour>, units: Units, into: &mut Gathered) -> Read<()> {
        let mut faces = Vec::new();
        for element in set.fields("GEOMETRIC_SET", 1).links(0)? {
            match self.table.get(element) {
                Ok(item) if is_endless(item) => self.put_aside(element),
                Ok(item) if is_surface(item) => {
                    if self.take(element, into) {
                        faces.push((Source::Surface(element), false));
                    }
                }
                Ok(item) if is_shapeless(item) => {}
                Ok(item) => {
                    let reason = format!("elements of type {} of a geometric set are not read", item.keyword());
                    self.unread.push((Trouble::new(element, reason), units));
                }
                Err(trouble) => self.unread.push((trouble, units)),
            }
        }
        if !faces.is_empty() {
            into.shells.push(ShellUse { kind: ShellKind::Open, entity: set.id, faces, colour, units });
        }
        Ok(())
    }

    /// Bodies, then shells, then faces that nothing has taken.
    pub(super) fn leftovers(&mut self, units: Units) -> Gathered {
        let mut found = Gathered::default();
        let of_kind = |wanted: fn(Instance<'_>) -> bool| self.table.of_types(wanted).map(|i| i.id);
        let is_tessellated = |i: Instance<'_>| BodyKind::of(i) == Some(BodyKind::Tessellated);
        let inner: Set<u64> = self.table.of_types(has_parts).flat_map(parts_of).collect();
        let bodies: Vec<u64> = of_kind(is_solid).filter(|id| !inner.contains(id)).collect();
        let tessellated: Vec<u64> = of_kind(is_tessellated).filter(|id| !inner.contains(id)).collect();
        let shells = of_kind(is_shell);
        let faces = of_kind(is_face);
        for id in bodies.into_iter().chain(shells).chain(faces) {
            if !self.taken.contains(&id) {
                self.item(id, units, &mut found);
            }
        }
        // What no product owns beside exact geometry is a picture of it.
        if self.table.of_types(|i| BodyKind::of(i) != Some(BodyKind::Tessellated) && is_body(i)).next().is_none() {
            for id in tessellated {
                if !self.taken.contains(&id) {
                    self.item(id, units, &mut found);
                }
            }
        }
        found
    }
}

const BODIES: [&str; 5] =
    ["MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP", "SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"];

/// Whether an item may contribute faces to a part.
pub(super) fn is_body(item: Instance<'_>) -> bool {
    let tessellated = BodyKind::of(item) == Some(BodyKind::Tessellated);
    is_solid(item) || tessellated || is_shell(item) || is_face(item) || item.is("GEOMETRIC_SET")
}

/// Whether an item is a body of faces, of a few numbers, or one of those that are refused.
fn is_solid(item: Instance<'_>) -> bool {
    let made = BodyKind::of(item).is_some_and(|kind| kind != BodyKind::Tessellated);
    made || item.is("CSG_SOLID") || refused(item).is_some() || item.types().any(|name| BODIES.contains(&name))
}

const BOOLEANS: [&str; 2] = ["BOOLEAN_RESULT", "BOOLEAN_CLIPPING_RESULT"];
const HOLDERS: [&str; 3] = ["TESSELLATED_SOLID", "TESSELLATED_SHELL", "TESSELLATED_GEOMETRIC_SET"];

/// Whether an instance is of a type that makes a body of others, or holds some.
fn has_parts(instance: Instance<'_>) -> bool {
    let replicas = ["CSG_SOLID", "SOLID_REPLICA"];
    BOOLEANS.into_iter().chain(HOLDERS).chain(replicas).any(|name| instance.is(name))
}

/// The bodies that an instance makes another one of, or holds.
fn parts_of(instance: Instance<'_>) -> impl Iterator<Item = u64> {
    let boolean = BOOLEANS.into_iter().any(|name| instance.is(name));
    let held =
        HOLDERS.into_iter().find(|name| instance.is(name)).and_then(|name| instance.fields(name, 1).links(0).ok());
    let root = instance.is("CSG_SOLID").then(|| instance.fields("CSG_SOLID", 1).optional(0)).flatten();
    let parent = instance.is("SOLID_REPLICA").then(|| instance.fields("SOLID_REPLICA", 1).optional(0)).flatten();
    let operands = boolean.then(|| instance.fields("BOOLEAN_RESULT", 1));
    let operands = operands.into_iter().flat_map(|own| [own.optional(1), own.optional(2)]).flatten();
    operands.chain(root).chain(parent).chain(held.into_iter().flatten())
}

fn is_shell(instance: Instance<'_>) -> bool {
    ["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET", "CONNECTED_FACE_SUB_SET"].into_iter().any(|n| instance.is(n))
}

/// Whether an instance is a face with a surface, or one that lies in the plane of its bounds.
pub(super) fn is_face(instance: Instance<'_>) -> bool {
    let of_others = || instance.is("ORIENTED_FACE") || instance.is("SUBFACE");
    instance.is("ADVANCED_FACE") || instance.is("FACE_SURFACE") || instance.is("FACE") && !of_others()
}

fn is_surface(instance: Instance<'_>) -> bool {
    let named = |name: &str| {
        let one = name == "PLANE" || name == "B_SPLINE_SURFACE_WITH_KNOTS";
        one || name.ends_with("_SURFACE") || name.starts_with("SURFACE_OF_")
    };
    instance.types().any(named) && !is_shapeless(instance)
}

/// Whether an instance is a surface that never ends by itself.
pub(super) fn is_endless(instance: Instance<'_>) -> bool {
    ["PLANE", "CYLINDRICAL_SURFACE", "CONICAL_SURFACE"].into_iter().any(|name| instance.is(name))
}

/// Whether a surface ends by itself. Others are placed beside shapes for reference.
fn is_bounded(surface: Instance<'_>) -> bool {
    const UNBOUNDED: [&str; 7] = [
        "PLANE",
        "CYLINDRICAL_SURFACE",
        "CONICAL_SURFACE",
        "SURFACE_OF_LINEAR_EXTRUSION",
        "SURFACE_OF_REVOLUTION",
        "OFFSET_SURFACE",
        "SURFACE_REPLICA",
    ];
    !UNBOUNDED.into_iter().any(|name| surface.is(name))
}

/// Whether an item is known to be no shape: placements, points, curves, wires, annotations, values. What is not known may be
/// one.
pub(super) fn is_shapeless(item: Instance<'_>) -> bool {
    const NAMES: [&str; 15] = [
        "COORDINATES_LIST",
        "LINE",
        "CIRCLE",
        "ELLIPSE",
        "HYPERBOLA",
        "PARABOLA",
        "CLOTHOID",
        "POLYLINE",
        "DIRECTION",
        "VECTOR",
        "COMPOSITE_CURVE_ON_SURFACE",
        "POINT_ON_SURFACE",
        "WIRE_SHELL",
        "VERTEX_SHELL",
        "SHELL_BASED_WIREFRAME_MODEL",
    ];
    const WORDS: [&str; 27] = [
        "PLACEMENT",
        "TRANSFORMATION",
        "POINT",
        "CURVE",
        "PCURVE",
        "EDGE",
        "VERTEX",
        "LOOP",
        "PATH",
        "WIRE",
        "ANNOTATION",
        "TEXT",
        "CALLOUT",
        "LEADER",
        "TERMINATOR",
        "DIMENSION",
        "SYMBOL",
        "STYLED",
        "CAMERA",
        "LIGHT",
        "PLANAR",
        "MEASURE",
        "DRAUGHTING",
        "MAPPED",
        "KINEMATIC",
        "STYLE",
        "GLYPH",
    ];
    const SHAPES: [&str; 7] = ["SOLID", "BREP", "FACE", "SURFACE", "SHELL", "VOLUME", "BODY"];
    let mut known = false;
    for name in item.types() {
        let has = |words: &[&str]| name.split('_').any(|word| words.contains(&word));
        let value = name.ends_with("_REPRESENTATION_ITEM")
            && !name.starts_with("GEOMETRIC_")
            && !name.starts_with("TOPOLOGICAL_");
        let curve = name.ends_with("_CURVE");
        if NAMES.contains(&name) || value || curve {
            known = true;
        } else if has(&SHAPES) {
            return false;
        } else {
            known |= has(&WORDS);
        }
    }
    known
}

/// The shells that shells as stated become, and the number of each: surfaces and faces that are listed alone, or in sets, are of
/// one shell, so that those side by side have their borders in common.
pub(super) fn distinct(uses: &[ShellUse]) -> (Vec<u32>, Vec<Shell>) {
    let loose = |of: &ShellUse| {
        let alone = |source: &Source| matches!(source, Source::Surface(_)) || source.id() == of.entity;
        of.faces.iter().all(|(source, _)| alone(source))
    };
    let mut shells = Vec::with_capacity(uses.len());
    let mut first_loose = None;
    let number = |of: &ShellUse| {
        let known = first_loose.filter(|_| loose(of));
        known.unwrap_or_else(|| {
            let new = u32::try_from(shells.len()).unwrap_or(u32::MAX);
            shells.push(Shell { kind: of.kind, entity: of.entity });
            if loose(of) {
                first_loose = Some(new);
            }
            new
        })
    };
    (uses.iter().map(number).collect(), shells)
}
