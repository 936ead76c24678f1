//! Part -> a hash of everything that prepare reads of it.
//!
//! Each type is taken apart without `..`, so that a new field does not compile until it is hashed or named as one that
//! prepare does not read.

use crate::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, Frame3, FreeTrims, Loop, NurbsCurve, NurbsSurface, Part, Shell, ShellKind,
    StepCause, Surface, TrimCurve, TrimPiece, TrimRule, VertexId,
};
use glam::{DVec2, DVec3};

/// BLAKE3 of a part's content, and of the options that matter. Parts with the same hash are prepared to the same bytes:
/// nobody can make two that differ and have the same one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct ContentHash([u8; 32]);

impl ContentHash {
    /// Hashes a part to be prepared with this [border tolerance](crate::prepare::PrepareOptions::border_tolerance),
    /// numbers bit by bit. Leaves out names, colours, and [entity numbers](entities) but those in the cause of a
    /// refused face. Cost: about a nanosecond per byte of the part.
    pub(crate) fn of(part: &Part, border_tolerance: f64) -> Self {
        let mut digest = Digest::new();
        border_tolerance.feed(&mut digest);
        part.feed(&mut digest);
        digest.finish()
    }
}

/// The entity numbers that prepare hands on: of all faces, then of all shells. A program may give all
/// entities other numbers on every save.
pub(crate) fn entities(part: &Part) -> Vec<u64> {
    part.faces.iter().map(|face| face.entity).chain(part.shells.iter().map(|shell| shell.entity)).collect()
}

/// Bytes given to the hash at a time: enough for all lanes of a vector unit.
const BLOCK: usize = 1 << 15;

pub(super) struct Digest {
    hasher: blake3::Hasher,
    buffer: Vec<u8>,
}

impl Digest {
    pub(super) fn new() -> Self {
        Self { hasher: blake3::Hasher::new(), buffer: Vec::new() }
    }

    pub(super) fn finish(mut self) -> ContentHash {
        self.flush();
        ContentHash(*self.hasher.finalize().as_bytes())
    }

    fn push(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.hasher.update(&self.buffer);
        self.buffer.clear();
    }
}

/// What is hashed. Lists begin with their length and variants with their number, so that no two values feed the same
/// bytes.
pub(super) trait Content {
    fn feed(&self, digest: &mut Digest);
}

impl Content for u64 {
    fn feed(&self, digest: &mut Digest) {
        digest.push(&self.to_le_bytes());
    }
}

impl Content for f64 {
    fn feed(&self, digest: &mut Digest) {
        self.to_bits().feed(digest);
    }
}

impl<T: Content> Content for [T] {
    fn feed(&self, digest: &mut Digest) {
        (self.len() as u64).feed(digest);
        self.iter().for_each(|item| item.feed(digest));
    }
}

impl<T: Content + ?Sized> Content for &T {
    fn feed(&self, digest: &mut Digest) {
        (**self).feed(digest);
    }
}

impl<T: Content> Content for Vec<T> {
    fn feed(&self, digest: &mut Digest) {
        self.as_slice().feed(digest);
    }
}

impl<T: Content> Content for Option<T> {
    fn feed(&self, digest: &mut Digest) {
        self.as_slice().feed(digest);
    }
}

impl<A: Content, B: Content> Content for (A, B) {
    fn feed(&self, digest: &mut Digest) {
        self.0.feed(digest);
        self.1.feed(digest);
    }
}

/// Numbers and variants without fields, as 64 bits.
macro_rules! words {
    ($($type:ty: $value:ident => $word:expr),* $(,)?) => {
        $(impl Content for $type {
            fn feed(&self, digest: &mut Digest) {
                let $value = *self;
                let word: u64 = $word;
                word.feed(digest);
            }
        })*
    };
}
words!(
    bool: value => u64::from(value),
    u32: value => u64::from(value),
    usize: value => value as u64,
    VertexId: value => u64::from(value.0),
    EdgeId: value => u64::from(value.0),
    CurveKind: value => value as u64,
    ShellKind: value => value as u64,
    TrimRule: value => value as u64,
);

/// Structs: the fields that are hashed, and those that are not.
macro_rules! fields {
    ($($type:ty { $($read:ident),* } $(without { $($left:ident),* })?;)*) => {
        $(impl Content for $type {
            fn feed(&self, digest: &mut Digest) {
                let Self { $($read,)* $($($left: _,)*)? } = self;
                $($read.feed(digest);)*
            }
        })*
    };
}
fields!(
    DVec2 { x, y };
    DVec3 { x, y, z };
    Frame3 { origin, x, y, z };
    NurbsCurve<DVec2> { degree, knots, points, weights };
    NurbsCurve<DVec3> { degree, knots, points, weights };
    NurbsSurface { degree_u, degree_v, knots_u, knots_v, points, weights };
    TrimCurve { pieces };
    FreeTrims { rule, curves };
    Coedge { edge, reversed };
    Edge { curve, range, start, end, kind } without { entity };
    Face { surface, loops, trims, reversed, shell, lost, refused } without { colour, name, entity };
    Shell { kind } without { entity };
    Part { vertices, edges, faces, shells, tolerance } without { name, colour };
);

/// Enums whose variants have fields: a number for each variant, and its fields.
macro_rules! variants {
    ($($type:ty { $($number:literal => $variant:ident $fields:tt,)* })*) => {
        $(impl Content for $type {
            fn feed(&self, digest: &mut Digest) {
                match self {
                    $(variants!(@pattern $variant $fields) => variants!(@feed digest, $number, $fields),)*
                }
            }
        })*
    };
    (@pattern $variant:ident { $($field:ident),* }) => { Self::$variant { $($field),* } };
    (@pattern $variant:ident ( $field:ident )) => { Self::$variant($field) };
    (@feed $digest:ident, $number:literal, { $($field:ident),* }) => {{
        $number.feed($digest);
        $($field.feed($digest);)*
    }};
    (@feed $digest:ident, $number:literal, ( $field:ident )) => {{
        $number.feed($digest);
        $field.feed($digest);
    }};
}
variants!(
    Surface {
        0_u64 => Plane { frame },
        1_u64 => Cylinder { frame, radius },
        2_u64 => Cone { frame, radius, half_angle },
        3_u64 => Sphere { frame, radius },
        4_u64 => Torus { frame, major, minor },
        5_u64 => Extrusion { curve, direction },
        6_u64 => Revolution { curve, frame },
        7_u64 => Nurbs(surface),
    }
    Loop {
        0_u64 => Edges(coedges),
        1_u64 => Vertex(vertex),
    }
    TrimPiece {
        0_u64 => Nurbs(curve),
        1_u64 => Polyline(points),
    }
);

/// By its derived `Debug`, which writes every field, and numbers so that they read back as the same.
impl Content for StepCause {
    fn feed(&self, digest: &mut Digest) {
        let text = format!("{self:?}");
        text.len().feed(digest);
        digest.push(text.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{StepTrouble, shapes};

    /// Every change that prepare may see changes the hash, and no two of them have the same one.
    #[test]
    fn whatever_prepare_reads_is_hashed() {
        let part = || shapes::by_name("box").expect("a shape").parts.remove(0);
        let mut changes: Vec<fn(&mut Part)> = vec![
            |_| {},
            |part| part.vertices[0].z = f64::from_bits(part.vertices[0].z.to_bits() + 1),
            |part| part.tolerance = 1e-3,
            |part| part.edges[1].range.1 *= 0.5,
            |part| part.edges[1].kind = CurveKind::Circle,
            |part| part.edges[1].curve.weights = vec![1.0; part.edges[1].curve.points.len()],
            |part| part.edges[1].curve.knots.swap(0, 3),
            |part| part.edges.swap(0, 1),
            |part| part.faces[2].reversed ^= true,
            |part| part.faces[2].lost = true,
            |part| part.faces[2].trims = Some(FreeTrims::default()),
            |part| part.faces[2].trims = Some(FreeTrims { rule: TrimRule::EvenOdd, curves: Vec::new() }),
            |part| part.faces[2].loops.clear(),
            |part| part.faces[2].loops.push(Loop::Vertex(VertexId(1))),
            |part| part.shells[0].kind = ShellKind::Open,
            |part| part.faces[2].surface = Surface::Sphere { frame: Frame3::WORLD, radius: 1.0 },
            |part| part.faces[2].surface = Surface::Cylinder { frame: Frame3::WORLD, radius: 1.0 },
            |part| drop(part.faces.pop()),
        ];
        changes.push(|part| {
            let trouble = Box::new(StepTrouble::NotInFile { entity: 9 });
            part.faces[2].refused = Some(StepCause { entity: Some(3), trouble });
        });
        let hash = |change: &fn(&mut Part)| {
            let mut part = part();
            change(&mut part);
            ContentHash::of(&part, 1e-6)
        };
        let mut hashes: Vec<ContentHash> = changes.iter().map(hash).collect();
        hashes.push(ContentHash::of(&part(), 1e-5));
        for (k, hash) in hashes.iter().enumerate() {
            assert_eq!(hashes.iter().position(|other| other == hash), Some(k));
        }
    }

    #[test]
    fn names_colours_and_entity_numbers_are_not_hashed() {
        let mut part = shapes::by_name("box").expect("a shape").parts.remove(0);
        let before = ContentHash::of(&part, 1e-6);
        part.name = "another".to_owned();
        part.colour = Some([1.0; 4]);
        part.faces[0].name = "top".to_owned();
        part.faces[0].colour = Some([0.5; 4]);
        (part.faces[0].entity, part.edges[0].entity, part.shells[0].entity) = (7, 8, 9);
        assert_eq!(entities(&part), [7, 0, 0, 0, 0, 0, 9]);
        assert_eq!(ContentHash::of(&part, 1e-6), before);
    }
}
