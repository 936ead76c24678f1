//! Why a primitive, a sweep or a triangulation of a file is not a solid.

use std::fmt;

/// Why bodies of a type are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BodyRefusal {
    /// Its faces are intersections of surfaces, which are not computed.
    Intersects,
    /// It is unbounded.
    Unbounded,
    /// Its faces have no exact form.
    NotExact,
}

impl fmt::Display for BodyRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Intersects => {
                "its faces are intersections of surfaces, which are not computed; export a boundary representation"
            }
            Self::Unbounded => "it is unbounded",
            Self::NotExact => "its faces have no exact form; export a boundary representation",
        })
    }
}

/// Why a primitive, a sweep or a triangulation of a file is not a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolidTrouble {
    /// A torus meets its own axis.
    Torus {
        /// Its major radius, millimetres.
        major_mm: f64,
        /// Its minor radius, millimetres.
        minor_mm: f64,
    },
    /// The top of a wedge is not shorter than its foot.
    Wedge {
        /// Length of the foot, millimetres.
        foot_mm: f64,
        /// Length of the top, millimetres.
        top_mm: f64,
    },
    /// A side of a hexahedron is not planar.
    SideNotPlane {
        /// The side's corners, by their numbers in the hexahedron.
        corners: [usize; 4],
    },
    /// A polyhedron has too few or too many corners.
    Corners {
        /// Its type.
        keyword: &'static str,
        /// How many corners it has.
        count: usize,
    },
    /// The swept face is not planar.
    ProfileNotPlane,
    /// The profile is extruded along its own plane.
    AlongProfile,
    /// The whole profile lies on its axis.
    ProfileOnAxis,
    /// The axis is not in the plane of the profile.
    AxisOffPlane,
    /// The profile lies on both sides of its axis.
    AcrossAxis,
    /// Triangles refer to coordinates that do not exist.
    Triangles {
        /// How many triangles.
        count: usize,
    },
}

impl fmt::Display for SolidTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Torus { major_mm, minor_mm } => {
                write!(f, "a torus of radii {major_mm} and {minor_mm} mm meets its own axis")
            }
            Self::Wedge { foot_mm, top_mm } => {
                write!(f, "a wedge is {foot_mm} mm long at its foot and {top_mm} mm, no less, at its top")
            }
            Self::SideNotPlane { corners } => {
                write!(f, "corners {corners:?} of the hexahedron are not in one plane")
            }
            Self::Corners { keyword, count } => write!(f, "a {keyword} has {count} corners"),
            Self::ProfileNotPlane => write!(f, "the swept face is not planar"),
            Self::AlongProfile => write!(f, "the profile is extruded along its own plane"),
            Self::ProfileOnAxis => write!(f, "the whole profile lies on its axis"),
            Self::AxisOffPlane => write!(f, "the axis is not in the plane of the profile"),
            Self::AcrossAxis => write!(f, "the profile lies on both sides of its axis"),
            Self::Triangles { count } => write!(f, "{count} triangles refer to coordinates that do not exist"),
        }
    }
}
