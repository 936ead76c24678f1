//! The trait through which triangles leave the engine, and a sink that keeps them in memory.

use super::{Batch, DrawnTiles, EdgeLine, MeshLists, Scene, SceneChanges, SceneInstance, SinkError, WrittenTile};
use crate::model::PartId;
use std::collections::BTreeMap;
use std::slice::Iter;

/// Receives frames of triangles.
///
/// Call order: `begin`, `begin_changes` or `begin_update`, `batch`*, `edge_line`*, `drawn`, then `end` or `abort`, all
/// on the render thread. Batches arrive sorted by (part, tile), lines by (part, edge), for any number of workers.
///
/// A session that [writes into the sink's memory](crate::parallel::Session::write_into) calls `written` instead of
/// `batch`: first for evicted tiles, then for each worker that made some. A tile without triangles is
/// removed, in whichever call it comes. No tile comes twice in a frame.
///
/// Provisional: it changes together with `parallel::Session`.
pub trait MeshSink: Send {
    /// The lists of meshes that it reads; others may be empty. The provided implementation reads all. A sink that
    /// passes batches on to another returns what that one reads, and what it reads itself.
    ///
    /// A session makes frames of views for the sink of its last commit. The commit to a sink that reads more fails
    /// before any other call, with [`InvalidInput`](std::io::ErrorKind::InvalidInput), and the next frame is a whole
    /// one. When a sink begins to read more, call [`forget`](crate::parallel::Session::forget): the tiles that it has
    /// do not get the lists that they lack.
    fn reads(&self) -> MeshLists {
        MeshLists::ALL
    }

    /// Starts a whole frame, which replaces everything sent before. It has no batches without triangles.
    ///
    /// # Errors
    /// When the sink cannot take the frame; `abort` follows.
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError>;

    /// Starts an incremental frame: it equals the last completed frame except for what is sent now. Each batch replaces
    /// that of its tile; a batch without triangles removes the tile. Each line replaces that of its edge. Known
    /// parts stay the same, and others may follow them; instances may have changed. `changes` lists what of the scene
    /// differs, so that a sink need not look at all of it.
    ///
    /// # Errors
    /// When the sink takes whole frames only, like files; `abort` follows. The provided implementation always fails.
    fn begin_changes(&mut self, scene: &Scene, _changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        let context = format!("incremental frame of {:?} for a sink that takes whole frames only", scene.name);
        Err(SinkError::new(context, std::io::ErrorKind::Unsupported))
    }

    /// Starts an incremental frame of another model, after [`Session::update`](crate::parallel::Session::update). Part
    /// `p` of `scene` starts with the tiles and lines of part `from[p]` of the last completed frame, and with none if
    /// that is `None`. No part is named twice; parts that are not named go, with their tiles and lines. `from` has a
    /// row for each part of `scene`. A part that goes on has the same centre and radius; name, colours and instances
    /// may differ. Instances are all new. Then as [`begin_changes`](Self::begin_changes).
    ///
    /// # Errors
    /// When the sink takes whole frames only, or one model only; `abort` follows, and the next frame is a whole one.
    /// The provided implementation always fails.
    fn begin_update(
        &mut self,
        scene: &Scene,
        _changes: &SceneChanges<'_>,
        _from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        let context = format!("another model, {:?}, for a sink that takes one model only", scene.name);
        Err(SinkError::new(context, std::io::ErrorKind::Unsupported))
    }

    /// Receives the triangles of one tile. Instances share their part's batches.
    ///
    /// A sink that keeps the mesh takes it with [`std::mem::take`]. Buffers that stay in `batch` are freed after the
    /// frame.
    ///
    /// # Errors
    /// When the sink cannot take the batch; `abort` follows.
    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError>;

    /// Receives tiles that are in its memory already, instead of [`batch`](Self::batch)es: at least one, ascending by
    /// (part, tile). One without triangles removes the tile, if there is one.
    ///
    /// The sink owns the room of the tiles that it takes from `tiles`, also if it returns an error. The room of the
    /// others is given back.
    ///
    /// # Errors
    /// When the sink cannot take all of them; `abort` follows. To leave some is an error too. The provided
    /// implementation always fails.
    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        let context = format!("{} tiles written for a sink that takes meshes", tiles.len());
        Err(SinkError::new(context, std::io::ErrorKind::Unsupported))
    }

    /// Receives the polyline of one B-rep edge. The provided implementation ignores it.
    ///
    /// # Errors
    /// When the sink cannot take the line; `abort` follows.
    fn edge_line(&mut self, _line: EdgeLine) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives the set of tiles to draw, once per frame of views. There are no cracks between drawn tiles; a tile that
    /// is not drawn may be several frames old. Frames made without views draw everything and skip this call.
    ///
    /// `before`: those of the last completed frame, without instances that were removed, by the rows that instances
    /// have now; none in a whole frame. [`DrawnTiles::set_difference`] tells what comes and what goes. If an instance
    /// changes its LOD, redraw all its tiles, even those in both sets: tile ids now refer to the new LOD.
    ///
    /// # Errors
    /// When the sink cannot take it; `abort` follows.
    fn drawn(&mut self, _drawn: &DrawnTiles, _before: &DrawnTiles) -> Result<(), SinkError> {
        Ok(())
    }

    /// Completes the frame. Files become visible here, all at once. The provided implementation does nothing.
    ///
    /// # Errors
    /// When the result cannot be finished; `abort` follows.
    fn end(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    /// Discards the frame: leave nothing half-written. If another frame follows, it is a whole one. The provided
    /// implementation does nothing, for sinks that keep nothing.
    fn abort(&mut self) {}
}

/// A sink that keeps the last frame in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemorySink {
    /// The scene of the last frame.
    pub scene: Scene,
    /// Batches with triangles, sorted by (part, tile).
    pub batches: Vec<Batch>,
    /// Edge polylines, sorted by (part, edge).
    pub edge_lines: Vec<EdgeLine>,
    /// The drawn tiles. [`DrawnTiles::default`] for frames made without views, which draw everything.
    pub drawn: DrawnTiles,
    reads: MeshLists,
    changes: Changes,
}

impl MemorySink {
    /// An empty sink that reads these lists of meshes. The others may be empty in its batches. The default sink reads
    /// all.
    #[must_use]
    pub fn reading(reads: MeshLists) -> Self {
        Self { reads, ..Self::default() }
    }

    /// A frame that draws everything. `batches` are sorted by (part, tile), `edge_lines` by (part, edge).
    #[must_use]
    pub fn of(scene: Scene, batches: Vec<Batch>, edge_lines: Vec<EdgeLine>) -> Self {
        Self { scene, batches, edge_lines, ..Self::default() }
    }
}

/// The incremental frame being received, if any.
#[derive(Clone, Debug, Default, PartialEq)]
struct Changes {
    only: bool,
    batches: Vec<Batch>,
    edge_lines: Vec<EdgeLine>,
}

/// The new number of each part that goes on, from what [`MeshSink::begin_update`] gets.
pub(crate) fn successors(from: &[Option<PartId>]) -> BTreeMap<PartId, PartId> {
    from.iter().enumerate().filter_map(|(new, old)| Some(((*old)?, PartId::new(new)))).collect()
}

/// Renumbers parts, drops the rows of parts that have no number, and sorts the others by `key`.
fn renumber<T, K: Ord>(
    rows: &mut Vec<T>,
    new: &BTreeMap<PartId, PartId>,
    part: impl Fn(&mut T) -> &mut PartId,
    key: impl Fn(&T) -> K,
) {
    rows.retain_mut(|row| {
        let part = part(row);
        new.get(part).map(|new| *part = *new).is_some()
    });
    rows.sort_by_key(key);
}

/// Merges the sorted rows `new` into the sorted rows `old`; equal keys are replaced.
fn replaced<T, K: Ord>(old: &mut Vec<T>, new: Vec<T>, key: impl Fn(&T) -> K) {
    let mut out = Vec::with_capacity(old.len() + new.len());
    let mut rest = std::mem::take(old).into_iter().peekable();
    for row in new {
        while let Some(before) = rest.next_if(|r| key(r) < key(&row)) {
            out.push(before);
        }
        rest.next_if(|r| key(r) == key(&row));
        out.push(row);
    }
    out.extend(rest);
    *old = out;
}

impl MeshSink for MemorySink {
    fn reads(&self) -> MeshLists {
        self.reads
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        *self = Self { scene: scene.clone(), ..Self::reading(self.reads) };
        Ok(())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.scene.parts.truncate(changes.first_part);
        self.scene.parts.extend_from_slice(&scene.parts[self.scene.parts.len()..]);
        changes.apply(scene, &mut self.scene.instances, SceneInstance::clone);
        self.changes = Changes { only: true, ..Changes::default() };
        Ok(())
    }

    fn begin_update(&mut self, scene: &Scene, _: &SceneChanges<'_>, from: &[Option<PartId>]) -> Result<(), SinkError> {
        let new = successors(from);
        renumber(&mut self.batches, &new, |batch| &mut batch.part, |batch| (batch.part, batch.tile));
        renumber(&mut self.edge_lines, &new, |line| &mut line.part, |line| (line.part, line.edge));
        self.scene = scene.clone();
        self.changes = Changes { only: true, ..Changes::default() };
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let batches = if self.changes.only { &mut self.changes.batches } else { &mut self.batches };
        batches.push(Batch { mesh: std::mem::take(&mut batch.mesh), ..*batch });
        Ok(())
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        let lines = if self.changes.only { &mut self.changes.edge_lines } else { &mut self.edge_lines };
        lines.push(line);
        Ok(())
    }

    fn drawn(&mut self, drawn: &DrawnTiles, _: &DrawnTiles) -> Result<(), SinkError> {
        self.drawn = drawn.clone();
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        let Changes { only, batches, edge_lines } = std::mem::take(&mut self.changes);
        if only {
            replaced(&mut self.batches, batches, |b| (b.part, b.tile));
            replaced(&mut self.edge_lines, edge_lines, |l| (l.part, l.edge));
            self.batches.retain(|batch| !batch.mesh.triangles.is_empty());
        }
        Ok(())
    }

    fn abort(&mut self) {
        *self = Self::reading(self.reads);
    }
}
