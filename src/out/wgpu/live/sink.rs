//! Frames of triangles to the device: each is uploaded next to the one that is drawn and replaces it when it ends.

use super::super::gpu::RenderError;
use super::device_scene::{Base, DeviceScene, Pending, look_like};
use super::pages::Companion;
use super::records::Stale;
use super::scene::LiveScene;
use super::store::line as encoded_line;
use crate::mesh::{Batch, DrawnTiles, EdgeLine, MeshLists, MeshSink, Scene, SceneChanges, SinkError};
use crate::model::PartId;
use std::io;

fn refusal(context: &str, kind: io::ErrorKind) -> SinkError {
    SinkError { context: context.to_owned(), cause: kind.into() }
}

fn failed(error: RenderError) -> SinkError {
    SinkError::new("the graphics device", io::Error::other(error))
}

impl LiveScene {
    fn start(&mut self, base: Base) {
        self.forget();
        self.pending = Some(Pending { base, tiles: Vec::new(), lines: Vec::new(), drawn: DrawnTiles::default() });
    }

    /// Frees what the pending frame has uploaded.
    fn forget(&mut self) {
        self.store.staging.discard();
        if let Some(pending) = self.pending.take() {
            pending.tiles.into_iter().filter_map(|row| row.2).for_each(|tile| self.store.drop_tile(tile));
        }
    }

    /// [`MeshSink::batch`] for a shared reference. Batches of unknown parts are skipped.
    pub(in crate::out::wgpu) fn add(&mut self, batch: &Batch) -> Result<(), SinkError> {
        let Some(pending) = &mut self.pending else { return Err(not_begun()) };
        if let Some(part) = pending.base.parts(&self.shown).get(batch.part.index()) {
            let tile = self.store.tile(&self.gpu, batch, part.centre).map_err(failed)?;
            pending.tiles.push((batch.part.0, batch.tile, tile));
        }
        Ok(())
    }

    /// [`MeshSink::edge_line`] for a shared reference. Lines of unknown parts are skipped.
    pub(in crate::out::wgpu) fn add_line(&mut self, line: &EdgeLine) -> Result<(), SinkError> {
        let Some(pending) = &mut self.pending else { return Err(not_begun()) };
        if let Some(part) = pending.base.parts(&self.shown).get(line.part.index()) {
            pending.lines.push((line.part.0, line.edge, encoded_line(&line.points, part.centre)));
        }
        Ok(())
    }

    /// Replaces the frame that is drawn by the pending one.
    fn commit(&mut self, Pending { base, tiles, lines, drawn }: Pending) {
        let mut edges_changed = !lines.is_empty();
        let mut old_tiles = Vec::new();
        match base {
            Base::New(shown, from) => {
                let mut old = std::mem::replace(&mut self.shown, shown);
                let same = from.is_empty() && self.shown.has_instances_of(&old);
                if from.is_empty() {
                    self.shown.hidden = std::mem::take(&mut old.hidden);
                } else {
                    self.records.mark(None);
                }
                for (part, from) in self.shown.parts.iter_mut().zip(from) {
                    if let Some(old) = from.and_then(|from| old.parts.get_mut(from.index())) {
                        (part.tiles, part.lines) = (std::mem::take(&mut old.tiles), std::mem::take(&mut old.lines));
                    }
                }
                old_tiles.extend(old.parts.into_iter().flat_map(|part| part.tiles).flatten());
                if same {
                    self.records.stale_all()
                } else {
                    self.records.leave_instances()
                }
                edges_changed = true;
            }
            Base::Instances(places) => {
                if !look_like(&places, &self.shown.places) {
                    self.records.leave_instances();
                    edges_changed = true;
                }
                self.shown.place(places);
            }
            Base::Changes(places) => {
                let mut moved = false;
                for (place, new) in places {
                    let old = std::mem::replace(&mut self.shown.places[place], new);
                    let new = &self.shown.places[place];
                    moved |= old.transform != new.transform;
                    if !old.looks_like(new) {
                        self.records.stale(Stale::Place(place as u32));
                        edges_changed = true;
                    }
                }
                if moved {
                    self.shown.measure();
                }
            }
        }
        for (part, tile, new) in tiles {
            old_tiles.extend(put(&mut self.shown.parts[part as usize].tiles, tile.0, new));
            self.records.stale(Stale::Tile(part, tile.0));
        }
        for (part, edge, new) in lines {
            put(&mut self.shown.parts[part as usize].lines, edge.0, new);
        }
        old_tiles.into_iter().for_each(|tile| self.store.drop_tile(tile));
        self.shown.drawn = drawn;
        self.version += 1;
        self.edges_version += u64::from(edges_changed);
    }
}

fn no_base() -> SinkError {
    refusal("changes without a complete frame to build on", io::ErrorKind::InvalidInput)
}

fn not_begun() -> SinkError {
    refusal("batch, line or end without a frame begun", io::ErrorKind::InvalidInput)
}

/// Replaces a row and returns the old one. Grows `rows` as needed.
fn put<T>(rows: &mut Vec<Option<T>>, number: u32, new: Option<T>) -> Option<T> {
    let number = number as usize;
    if number >= rows.len() {
        rows.resize_with(number + 1, || None);
    }
    std::mem::replace(&mut rows[number], new)
}

impl MeshSink for LiveScene {
    /// Parameters and lattice lines only while it keeps lattice positions.
    fn reads(&self) -> MeshLists {
        let cells = self.store.vertices.has_companion(Companion::Cells);
        // Origins tell how many cells a tile has, which is a colour.
        MeshLists { uvs: cells, lines: cells, origins: true }
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.start(Base::New(DeviceScene::of(scene), Vec::new()));
        Ok(())
    }

    fn begin_update(&mut self, scene: &Scene, _: &SceneChanges<'_>, from: &[Option<PartId>]) -> Result<(), SinkError> {
        if !self.whole {
            return Err(no_base());
        }
        self.start(Base::New(DeviceScene::of(scene), from.to_vec()));
        Ok(())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        if !self.whole {
            return Err(no_base());
        }
        self.shown.add_parts(scene);
        self.start(match self.shown.changed_places(scene, changes) {
            Some(places) => Base::Changes(places),
            None => Base::Instances(self.shown.places_of(scene)),
        });
        Ok(())
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        self.add(batch)
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.add_line(&line)
    }

    fn drawn(&mut self, drawn: &DrawnTiles, _: &DrawnTiles) -> Result<(), SinkError> {
        self.pending.as_mut().ok_or_else(not_begun)?.drawn = drawn.clone();
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.store.staging.flush(&self.gpu).map_err(failed)?;
        self.uploaded = std::mem::take(&mut self.store.staging.count);
        let pending = self.pending.take().ok_or_else(not_begun)?;
        self.commit(pending);
        self.whole = true;
        Ok(())
    }

    fn abort(&mut self) {
        self.forget();
        self.whole = false;
    }
}
