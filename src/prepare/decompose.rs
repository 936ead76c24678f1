//! (owned by the model branch)
#[derive(Clone, Debug, Default)]
pub struct BezierSpline3;
#[derive(Clone, Debug, Default)]
pub struct BezierPatches;
