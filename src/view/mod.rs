//! Cameras: where they are and how they project, what they fit, how a pointer moves them, and the screen-space error
//! that their pictures may have.

mod box_corners;
pub use box_corners::box_corners;

mod camera;
pub use camera::{Camera, Projection, View};

mod invalid_view;
pub use invalid_view::InvalidView;

mod from_matrix;

mod view_point;
pub use view_point::{BadViewPoint, ViewPoint};

mod orbit;

mod path;
pub use path::{CameraPath, Picture, UnknownPath};
