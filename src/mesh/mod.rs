//! Output types: batches, the scene, and the sink that receives them.

mod tile_mesh;
pub use tile_mesh::{Batch, EdgeLine, MeshLists, Origin, TileMesh};

mod drawn;
pub use drawn::DrawnTiles;
pub(crate) use drawn::tiles_of_word;

mod scene;
pub(crate) use scene::uniform_scale;
pub use scene::{InstanceKey, PartKey, Scene, SceneChanges, SceneInstance, ScenePart};

mod vertex_layout;
#[cfg(any(feature = "glb", feature = "wgpu"))]
pub(crate) use vertex_layout::SHORT_VERTICES;
#[cfg(feature = "wgpu")]
pub(crate) use vertex_layout::octahedral;
pub use vertex_layout::{IndexFormat, NormalFormat, PositionFormat, VertexLayout};

mod written;
pub use written::{GridTooCoarse, SinkError, TileGrid, TileMemory, WrittenTile};
pub(crate) use written::{NotWritten, PartGrid};

mod sink;
pub(crate) use sink::successors;
pub use sink::{MemorySink, MeshSink};

mod frame_view;
pub use frame_view::{BatchView, FrameView, TileView, Triangles};

mod packed;
pub(crate) use packed::Placement;
pub use packed::{FlatMesh, PackedFrame, PartMesh, TooManyVertices};

mod check;
pub use check::{BadEdge, Cause, MeshFacts, SceneFacts, check_part, check_scene};
