//! Items of a representation to shells: lists of faces with the way each is used.

use super::style::Styles;
use super::table::{Instance, MAX_DEPTH, Read, Table, Trouble};
use super::units::Units;
use crate::model::{Colour, ShellKind};
use std::collections::HashSet;

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

/// Gathers shells and remembers what is taken, so that leftovers can be found.
pub(super) struct Gather<'a> {
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Items, shells and faces that some part has taken, of the whole file.
    pub(super) taken: HashSet<u64>,
    /// Representation items that hold geometry of a kind that is not read.
    pub(super) unread: Vec<Trouble>,
}

/// What was gathered for one part.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) shells: Vec<ShellUse>,
    /// Items, shells and faces in this part already: a part holds each once, however often its representations list it.
    held: HashSet<u64>,
}

impl Gather<'_> {
    /// Adds the shells of a representation item.
    pub(super) fn item(&mut self, id: u64, units: Units, into: &mut Gathered) {
        let Some(item) = self.table.find(id) else { return };
        if let Err(trouble) = self.try_item(item, units, into) {
            self.unread.push(trouble);
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
        } else if item.types().any(unread_body) {
            self.taken.insert(item.id);
            return Err(Trouble::new(item.id, format!("bodies of type {} are not read", item.keyword())));
        }
        Ok(())
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
            if self.table.find(element).is_some_and(is_surface) && self.take(element, into) {
                faces.push((Source::Surface(element), false));
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
        let of_kind = |wanted: &dyn Fn(Instance<'_>) -> bool| -> Vec<u64> {
            self.table.iter().filter(|i| wanted(*i)).map(|i| i.id).collect()
        };
        let bodies = of_kind(&|i| i.types().any(|name| BODIES.contains(&name)));
        let shells = of_kind(&is_shell);
        let faces = of_kind(&is_face);
        for id in bodies.into_iter().chain(shells).chain(faces) {
            if !self.taken.contains(&id) {
                self.item(id, units, &mut found);
            }
        }
        found
    }
}

const BODIES: [&str; 5] =
    ["MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP", "SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"];

/// Whether an item may contribute faces to a part.
pub(super) fn is_body(item: Instance<'_>) -> bool {
    item.types().any(|name| BODIES.contains(&name)) || is_shell(item) || is_face(item) || item.is("GEOMETRIC_SET")
}

fn is_shell(instance: Instance<'_>) -> bool {
    ["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET", "CONNECTED_FACE_SUB_SET"].into_iter().any(|n| instance.is(n))
}

pub(super) fn is_face(instance: Instance<'_>) -> bool {
    instance.is("ADVANCED_FACE") || instance.is("FACE_SURFACE")
}

fn is_surface(instance: Instance<'_>) -> bool {
    instance.types().any(|name| name == "PLANE" || name.contains("_SURFACE") || name.starts_with("SURFACE_OF_"))
}

/// Bodies of other geometry than boundary representations.
fn unread_body(name: &str) -> bool {
    const KINDS: [&str; 8] = [
        "CSG_SOLID",
        "EXTRUDED_AREA_SOLID",
        "REVOLVED_AREA_SOLID",
        "EXTRUDED_FACE_SOLID",
        "REVOLVED_FACE_SOLID",
        "SWEPT_DISK_SOLID",
        "SOLID_REPLICA",
        "BOOLEAN_RESULT",
    ];
    KINDS.contains(&name) || name.starts_with("TESSELLATED_SOLID") || name.starts_with("TESSELLATED_SHELL")
}
