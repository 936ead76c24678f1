//! Output types: batches, the scene, and the sink that receives them.

mod tile_mesh;
pub use tile_mesh::{Batch, EdgeLine, MeshLists, Origin, TileMesh};

mod drawn;
pub use drawn::DrawnTiles;
pub(crate) use drawn::tiles_of_word;

mod keys;
pub use keys::{InstanceKey, PartKey};

mod scene;
pub use scene::{Scene, SceneInstance, ScenePart};

mod scene_changes;
pub use scene_changes::SceneChanges;

mod sink_error;
pub use sink_error::SinkError;

mod vertex_layout;
#[cfg(any(feature = "glb", feature = "wgpu"))]
pub(crate) use vertex_layout::SHORT_VERTICES;
#[cfg(feature = "wgpu")]
pub(crate) use vertex_layout::octahedral;
pub use vertex_layout::{IndexFormat, NormalFormat, PositionFormat, VertexLayout};

mod written;
pub use written::{GridTooCoarse, TileGrid, TileMemory, WrittenTile};
pub(crate) use written::{NotWritten, PartGrid};

mod sink;
pub(crate) use sink::successors;
pub use sink::{MemorySink, MeshSink};

mod frame_view;
pub use frame_view::{BatchView, FrameView, TileView, Triangles};

mod packed;
pub use packed::{PackedFrame, PartMesh};

mod placement;
pub(crate) use placement::Placement;

mod flat;
pub use flat::{FlatMesh, TooManyVertices};

mod cause;
pub use cause::Cause;

mod check;
pub use check::{BadEdge, MeshFacts, SceneFacts, check_part, check_scene};
