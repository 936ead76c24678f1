//! (owned by the model branch)
#[derive(Clone, Debug, Default)]
pub struct CurveBounds;
#[derive(Clone, Debug, Default)]
pub struct SurfaceBounds;
