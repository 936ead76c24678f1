//! Typed indices into the tables of one [`Part`](crate::model::Part) or [`Model`](crate::model::Model), and colours.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name(pub u32);

        impl $name {
            /// The id of row `index` of its table. Tables have fewer than 2³² rows.
            #[must_use]
            pub fn new(index: usize) -> Self {
                debug_assert!(u32::try_from(index).is_ok());
                #[allow(clippy::cast_possible_truncation, reason = "tables are bounded by the builder's limits")]
                Self(index as u32)
            }

            /// The row in the table.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id!(
    /// A vertex of a part.
    VertexId
);
id!(
    /// An edge of a part: one curve in space, shared by the faces that meet there.
    EdgeId
);
id!(
    /// A face of a part.
    FaceId
);
id!(
    /// A part of a model.
    PartId
);
id!(
    /// An instance (placed part) of a model.
    InstanceId
);
id!(
    /// A tile of a prepared part: a rectangle of a face's parameter domain.
    TileId
);
id!(
    /// An edge of a prepared part: first the part's edges in the order of [`EdgeId`], then the borders between tiles.
    RowId
);

/// Red, green, blue (sRGB) and opacity, each 0..1.
pub type Colour = [f32; 4];

/// The colour, if a share of it is not from 0 to 1.
pub(crate) fn bad_colour(colour: Option<Colour>) -> Option<Colour> {
    colour.filter(|colour| !colour.iter().all(|share| (0.0..=1.0).contains(share)))
}
