//! Types of instances -> their kind: face, shell, surface, body, or not a shape. Shapes -> what they are the shape of.

use super::table::{Entity, Table};
use crate::model::BodyRefusal;

/// Supported primitives of constructive solid geometry.
pub(super) const PRIMITIVES: [&str; 9] = [
    "BLOCK",
    "RIGHT_ANGULAR_WEDGE",
    "RECTANGULAR_PYRAMID",
    "TETRAHEDRON",
    "CONVEX_HEXAHEDRON",
    "SPHERE",
    "TORUS",
    "RIGHT_CIRCULAR_CYLINDER",
    "RIGHT_CIRCULAR_CONE",
];

/// Supported swept solids.
pub(super) const SWEEPS: [&str; 4] =
    ["EXTRUDED_AREA_SOLID", "EXTRUDED_FACE_SOLID", "REVOLVED_AREA_SOLID", "REVOLVED_FACE_SOLID"];

/// Supported faces of triangles, loose or listed.
pub(super) const TRIANGULATED: [&str; 4] =
    ["TRIANGULATED_FACE", "COMPLEX_TRIANGULATED_FACE", "TRIANGULATED_SURFACE_SET", "COMPLEX_TRIANGULATED_SURFACE_SET"];

/// Tessellated types that list their faces.
pub(super) const HOLDERS: [&str; 3] = ["TESSELLATED_SOLID", "TESSELLATED_SHELL", "TESSELLATED_GEOMETRIC_SET"];

const BODIES: [&str; 5] =
    ["MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP", "SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"];

/// Whether an item may contribute faces to a part.
pub(super) fn is_body(item: Entity<'_>) -> bool {
    let tessellated = BodyKind::of(item) == Some(BodyKind::Tessellated);
    is_solid(item) || tessellated || is_shell(item) || is_face(item) || item.is("GEOMETRIC_SET")
}

/// Whether an item is a body of faces, a primitive, a sweep, or a refused body.
pub(super) fn is_solid(item: Entity<'_>) -> bool {
    let made = BodyKind::of(item).is_some_and(|kind| kind != BodyKind::Tessellated);
    made || item.is("CSG_SOLID") || refused(item).is_some() || item.types().any(|name| BODIES.contains(&name))
}

const BOOLEANS: [&str; 2] = ["BOOLEAN_RESULT", "BOOLEAN_CLIPPING_RESULT"];

/// Whether an instance is composed of other bodies or faces.
pub(super) fn has_parts(instance: Entity<'_>) -> bool {
    instance.is_any(BOOLEANS) || instance.is_any(HOLDERS) || instance.is_any(["CSG_SOLID", "SOLID_REPLICA"])
}

/// The bodies or faces of which an instance is composed.
pub(super) fn parts_of(instance: Entity<'_>) -> impl Iterator<Item = u64> {
    let held = instance.first_of(HOLDERS).and_then(|name| instance.fields(name, 1).links(0).ok());
    let root = instance.is("CSG_SOLID").then(|| instance.fields("CSG_SOLID", 1).optional(0)).flatten();
    let parent = instance.is("SOLID_REPLICA").then(|| instance.fields("SOLID_REPLICA", 1).optional(0)).flatten();
    let operands = instance.is_any(BOOLEANS).then(|| instance.fields("BOOLEAN_RESULT", 1));
    let operands = operands.into_iter().flat_map(|own| [own.optional(1), own.optional(2)]).flatten();
    operands.chain(root).chain(parent).chain(held.into_iter().flatten())
}

pub(super) fn is_shell(instance: Entity<'_>) -> bool {
    instance.is_any(["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET", "CONNECTED_FACE_SUB_SET"])
}

/// The type of a model of shells.
pub(super) fn shell_model(instance: Entity<'_>) -> Option<&'static str> {
    instance.first_of(["SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"])
}

/// Whether an instance is a face, with a surface or in the plane of its bounds.
pub(super) fn is_face(instance: Entity<'_>) -> bool {
    let of_others = || instance.is("ORIENTED_FACE") || instance.is("SUBFACE");
    instance.is("ADVANCED_FACE") || instance.is("FACE_SURFACE") || instance.is("FACE") && !of_others()
}

pub(super) fn is_surface(instance: Entity<'_>) -> bool {
    let named = |name: &str| {
        let one = name == "PLANE" || name == "B_SPLINE_SURFACE_WITH_KNOTS";
        one || name.ends_with("_SURFACE") || name.starts_with("SURFACE_OF_")
    };
    instance.types().any(named) && !is_shapeless(instance)
}

/// Whether an instance is an analytic surface without bounds.
pub(super) fn is_endless(instance: Entity<'_>) -> bool {
    instance.is_any(["PLANE", "CYLINDRICAL_SURFACE", "CONICAL_SURFACE"])
}

/// Whether a surface is bounded by itself. Files list others next to shapes for reference.
pub(super) fn is_bounded(surface: Entity<'_>) -> bool {
    const UNBOUNDED: [&str; 4] =
        ["SURFACE_OF_LINEAR_EXTRUSION", "SURFACE_OF_REVOLUTION", "OFFSET_SURFACE", "SURFACE_REPLICA"];
    !(is_endless(surface) || surface.is_any(UNBOUNDED))
}

/// Whether an item is known not to be a shape: placements, points, curves, wires, annotations, values. Unknown types
/// may be shapes.
pub(super) fn is_shapeless(item: Entity<'_>) -> bool {
    /// What a word of a type's name says: that it is a shape (`true`) or not (`false`). `None`: nothing.
    fn told(word: &str) -> Option<bool> {
        match word {
            "SOLID" | "BREP" | "FACE" | "SURFACE" | "SHELL" | "VOLUME" | "BODY" => Some(true),
            "PLACEMENT" | "TRANSFORMATION" | "POINT" | "CURVE" | "PCURVE" | "EDGE" | "VERTEX" | "LOOP" | "PATH"
            | "WIRE" | "ANNOTATION" | "TEXT" | "CALLOUT" | "LEADER" | "TERMINATOR" | "DIMENSION" | "SYMBOL"
            | "STYLED" | "CAMERA" | "LIGHT" | "PLANAR" | "MEASURE" | "DRAUGHTING" | "MAPPED" | "KINEMATIC"
            | "STYLE" | "GLYPH" => Some(false),
            _ => None,
        }
    }
    let mut known = false;
    for name in item.types() {
        let is_none = match name {
            "COORDINATES_LIST" | "LINE" | "CIRCLE" | "ELLIPSE" | "HYPERBOLA" | "PARABOLA" | "CLOTHOID" | "POLYLINE"
            | "DIRECTION" | "VECTOR" | "POINT_ON_SURFACE" | "WIRE_SHELL" | "VERTEX_SHELL" => true,
            "COMPOSITE_CURVE_ON_SURFACE" | "SHELL_BASED_WIREFRAME_MODEL" => true,
            _ if name.starts_with("GEOMETRIC_") || name.starts_with("TOPOLOGICAL_") => name.ends_with("_CURVE"),
            _ => name.ends_with("_CURVE") || name.ends_with("_REPRESENTATION_ITEM"),
        };
        // One word that tells of a shape outweighs the others.
        let told = if is_none { Some(false) } else { name.split('_').filter_map(told).max() };
        if told == Some(true) {
            return false;
        }
        known |= told.is_some();
    }
    known
}

/// How the faces of a body are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BodyKind {
    /// A primitive of constructive solid geometry.
    Primitive,
    /// A planar area or face, extruded or revolved.
    Sweep,
    /// Triangles.
    Tessellated,
}

impl BodyKind {
    pub(super) fn of(item: Entity<'_>) -> Option<Self> {
        if item.is_any(PRIMITIVES) {
            Some(Self::Primitive)
        } else if item.is_any(SWEEPS) {
            Some(Self::Sweep)
        } else {
            let is_tessellated =
                item.is_any(HOLDERS) || item.is_any(TRIANGULATED) || item.is("REPOSITIONED_TESSELLATED_ITEM");
            is_tessellated.then_some(Self::Tessellated)
        }
    }
}

/// Why bodies of this type are not read; `None` if they are.
pub(super) fn refused(item: Entity<'_>) -> Option<BodyRefusal> {
    use BodyRefusal::{Intersects, NotExact, Unbounded};
    const REFUSED: [(&str, BodyRefusal); 15] = [
        ("BOOLEAN_RESULT", Intersects),
        ("BOOLEAN_CLIPPING_RESULT", Intersects),
        ("HALF_SPACE_SOLID", Unbounded),
        ("BOXED_HALF_SPACE", Unbounded),
        ("POLYGONAL_BOUNDED_HALF_SPACE", Unbounded),
        ("SWEPT_DISK_SOLID", NotExact),
        ("SURFACE_CURVE_SWEPT_AREA_SOLID", NotExact),
        ("SURFACE_CURVE_SWEPT_FACE_SOLID", NotExact),
        ("ECCENTRIC_CONE", NotExact),
        ("ECCENTRIC_CONICAL_VOLUME", NotExact),
        ("ELLIPSOID", NotExact),
        ("CYCLIDE_SEGMENT_SOLID", NotExact),
        ("TRIMMED_VOLUME", NotExact),
        ("B_SPLINE_VOLUME", NotExact),
        ("CUBIC_BEZIER_TRIANGULATED_FACE", NotExact),
    ];
    REFUSED.into_iter().find(|(name, _)| item.is(name)).map(|(_, why)| why)
}

/// The area or face that a body sweeps.
pub(super) fn profile(item: Entity<'_>) -> Option<u64> {
    let name = item.first_of(SWEEPS)?;
    // The supertype declares name and profile.
    let swept = if name.contains("AREA") { "SWEPT_AREA_SOLID" } else { "SWEPT_FACE_SOLID" };
    item.fields(swept, 1).optional(0)
}

/// The exact solid, shell or face that a tessellated one repeats.
pub(super) fn stands_for(item: Entity<'_>) -> Option<u64> {
    if let Some(name) = item.first_of(["TESSELLATED_SOLID", "TESSELLATED_SHELL"]) {
        return item.fields(name, 1).optional(1);
    }
    let face = item.is_any(["TRIANGULATED_FACE", "COMPLEX_TRIANGULATED_FACE"]);
    face.then(|| item.fields("TESSELLATED_FACE", 1).optional(3)).flatten()
}

pub(super) const OCCURRENCE: &str = "NEXT_ASSEMBLY_USAGE_OCCURRENCE";

/// The definition or occurrence to which a `PRODUCT_DEFINITION_SHAPE` belongs.
pub(super) fn defined(table: &Table, property: u64) -> Option<u64> {
    table.find(property)?.fields("PROPERTY_DEFINITION", 0).optional(2)
}

/// The shapes that the file defines: the definition or occurrence, and its representation.
pub(super) fn shapes(table: &Table) -> impl Iterator<Item = (u64, u64)> {
    table.of_types(|i| i.is("SHAPE_DEFINITION_REPRESENTATION")).filter_map(|link| {
        let own = link.fields("PROPERTY_DEFINITION_REPRESENTATION", 0);
        let (property, shape) = (own.optional(0)?, own.optional(1)?);
        Some((defined(table, property)?, shape))
    })
}
