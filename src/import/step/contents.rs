//! Contents of one part, gathered from its representations: shells of faces, and bodies without explicit faces.

use super::kinds::BodyKind;
use super::units::Units;
use super::values::{Map, Set};
use crate::model::{Colour, Shell, ShellKind};

/// Source of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// An `ADVANCED_FACE` or `FACE_SURFACE`.
    Face(u64),
    /// A bounded surface without topology, from a geometric set.
    Surface(u64),
}

impl Source {
    pub(super) fn id(self) -> u64 {
        match self {
            Self::Face(id) | Self::Surface(id) => id,
        }
    }
}

/// One use of a shell by a body.
#[derive(Clone, Debug)]
pub(super) struct ShellUse {
    pub(super) kind: ShellKind,
    pub(super) entity: u64,
    /// The faces, and whether the use flips them.
    pub(super) faces: Vec<(Source, bool)>,
    /// Colour of faces that have none.
    pub(super) colour: Option<Colour>,
    pub(super) units: Units,
}

/// A body without explicit faces.
#[derive(Clone, Debug)]
pub(super) struct BodyUse {
    pub(super) kind: BodyKind,
    pub(super) entity: u64,
    pub(super) colour: Option<Colour>,
    pub(super) units: Units,
}

/// Shells and bodies of one part.
#[derive(Default)]
pub(super) struct PartContents {
    pub(super) shells: Vec<ShellUse>,
    pub(super) bodies: Vec<BodyUse>,
    /// Items, shells and faces already in this part. A part has each once, however often its representations list it.
    pub(super) held: Set<u64>,
    /// Faces of open shells in this part, and whether the shell flips them.
    pub(super) open_sides: Set<(u64, bool)>,
    /// Open shells in this part, whether they are flipped, and how many faces they list.
    pub(super) open_shells: Map<(u64, bool), usize>,
}

impl PartContents {
    /// Numbers of the faces of its shells.
    pub(super) fn faces(&self) -> impl Iterator<Item = u64> {
        self.shells.iter().flat_map(|shell| &shell.faces).map(|(source, _)| source.id())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.shells.is_empty() && self.bodies.is_empty()
    }

    /// Faces and bodies.
    pub(super) fn size(&self) -> usize {
        self.shells.iter().map(|shell| shell.faces.len()).sum::<usize>() + self.bodies.len()
    }

    /// Units of the first shell or body.
    pub(super) fn units(&self) -> Option<Units> {
        self.shells.first().map(|shell| shell.units).or(self.bodies.first().map(|body| body.units))
    }
}

/// Merges all loose surfaces and faces (listed alone, in sets, or each as an open shell of its own) into one shell, so
/// that adjacent ones share their borders. Returns the new shell index of each use, and the shells.
pub(super) fn merge_loose_shells(uses: &[ShellUse]) -> (Vec<u32>, Vec<Shell>) {
    let loose = |of: &ShellUse| {
        let alone = |source: &Source| matches!(source, Source::Surface(_)) || source.id() == of.entity;
        of.faces.iter().all(|(source, _)| alone(source)) || of.kind == ShellKind::Open && of.faces.len() == 1
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
