//! Why a primitive, a sweep or a triangulation of a file is not a solid.

/// Why bodies of a type are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyRefusal {
    /// Its faces are intersections of surfaces, which are not computed.
    #[error("its faces are intersections of surfaces, which are not computed; export a boundary representation")]
    Intersects,
    /// It is unbounded.
    #[error("it is unbounded")]
    Unbounded,
    /// Its faces have no exact form.
    #[error("its faces have no exact form; export a boundary representation")]
    NotExact,
}

/// Why a primitive, a sweep or a triangulation of a file is not a solid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidTrouble {
    /// A torus meets its own axis.
    #[error("a torus of radii {major_mm} and {minor_mm} mm meets its own axis")]
    Torus {
        /// Its major radius, millimetres.
        major_mm: f64,
        /// Its minor radius, millimetres.
        minor_mm: f64,
    },
    /// The top of a wedge is not shorter than its foot.
    #[error("a wedge is {foot_mm} mm long at its foot and {top_mm} mm, no less, at its top")]
    Wedge {
        /// Length of the foot, millimetres.
        foot_mm: f64,
        /// Length of the top, millimetres.
        top_mm: f64,
    },
    /// A side of a hexahedron is not planar.
    #[error("corners {corners:?} of the hexahedron are not in one plane")]
    SideNotPlane {
        /// The side's corners, by their numbers in the hexahedron.
        corners: [usize; 4],
    },
    /// A polyhedron has too few or too many corners.
    #[error("a {keyword} has {count} corners")]
    Corners {
        /// Its type.
        keyword: &'static str,
        /// How many corners it has.
        count: usize,
    },
    /// The swept face is not planar.
    #[error("the swept face is not planar")]
    ProfileNotPlane,
    /// The profile is extruded along its own plane.
    #[error("the profile is extruded along its own plane")]
    AlongProfile,
    /// The whole profile lies on its axis.
    #[error("the whole profile lies on its axis")]
    ProfileOnAxis,
    /// The axis is not in the plane of the profile.
    #[error("the axis is not in the plane of the profile")]
    AxisOffPlane,
    /// The profile lies on both sides of its axis.
    #[error("the profile lies on both sides of its axis")]
    AcrossAxis,
    /// Triangles refer to coordinates that do not exist.
    #[error("{count} triangles refer to coordinates that do not exist")]
    Triangles {
        /// How many triangles.
        count: usize,
    },
}
