//! Cameras: where they are and how they project, what they fit, how a pointer moves them, and the screen-space error
//! that their pictures may have.

mod camera;
pub use camera::{Camera, Projection, View, box_corners};

mod invalid_view;
pub use invalid_view::InvalidView;

mod from_matrix;

mod view_point;
pub use view_point::{BadViewPoint, ViewPoint};

mod orbit;

mod path;
pub use path::{CameraPath, Picture, UnknownPath};
