//! Instances that come, move and go, and attributes of parts and instances, between two frames of views.

use super::edits::check;
use super::error::EditError;
use super::session::Session;
use crate::frame::Attributes;
use crate::mesh::{InstanceKey, SceneInstance};
use crate::model::{PartId, bad_colour, not_rigid};
use glam::DAffine3;
use std::sync::OnceLock;

impl Session {
    /// Adds an instance of a part of the model, from the next frame of views on. Its row is the last. Its attributes
    /// are the default, but for `visible`. Cancels a frame of views that was begun, and waits for its tiles in
    /// progress.
    ///
    /// A part has as many LODs as instances, up to [`SessionOptions::levels`](super::SessionOptions::levels). An LOD
    /// that this adds becomes the last part of [`scene`](Self::scene).
    ///
    /// # Errors
    /// When there is no such part, the transform is not a rigid motion with an optional reflection and uniform scale,
    /// or a number of the colour is not from 0 to 1. When an internal error ended the session.
    pub fn add_instance(&mut self, instance: SceneInstance) -> Result<InstanceKey, EditError> {
        let count = self.model.scene.parts.len();
        if instance.part.index() >= count {
            return Err(EditError::NoPart { part: instance.part, count });
        }
        not_rigid(&instance.transform).map_or(Ok(()), |error| Err(EditError::Transform { error }))?;
        bad_colour(instance.colour).map_or(Ok(()), |colour| Err(EditError::Colour { colour }))?;
        let engine = self.edited()?;
        let has_level = engine.add_instance(instance.clone());
        let looks = engine.placed.take_looks();
        if has_level {
            self.scene.add_level(instance.part);
            self.keys.name_part(&mut self.scene);
            self.grown = OnceLock::new();
        }
        let row = self.scene.instances.len();
        let key = self.keys.push(&mut self.scene, instance);
        self.edits.add(key, &self.scene.instances[row]);
        self.repaint(looks);
        self.scene.number_faces(row);
        Ok(key)
    }

    /// Removes an instance from the next frame of views on. The rows of later instances decrease by one. Cancels a
    /// frame of views that was begun, and waits for its tiles in progress. Cost: a pass over the instances after it;
    /// many go at once in [`remove_instances`](Self::remove_instances).
    ///
    /// Returns the instance: at its present place, visible if it was set so, with the colour that the model or the
    /// caller of [`add_instance`](Self::add_instance) gave it.
    ///
    /// # Errors
    /// When it was removed before, or an internal error ended the session.
    pub fn remove_instance(&mut self, key: InstanceKey) -> Result<SceneInstance, EditError> {
        Ok(self.remove_instances(&[key])?.swap_remove(0))
    }

    /// As [`remove_instance`](Self::remove_instance), of many. Returns them in the order of `keys`. Cost: one pass over
    /// the instances, however many go.
    ///
    /// # Errors
    /// When one was removed before, or is named twice: nothing changes. When an internal error ended the session.
    pub fn remove_instances(&mut self, keys: &[InstanceKey]) -> Result<Vec<SceneInstance>, EditError> {
        let row = |key: InstanceKey| self.keys.row(key).ok_or(EditError::NoInstance { key });
        let rows = keys.iter().enumerate().map(|(k, key)| Ok((row(*key)?, k)));
        let mut order = rows.collect::<Result<Vec<(usize, usize)>, EditError>>()?;
        order.sort_unstable();
        if let Some(twice) = order.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(EditError::NoInstance { key: keys[twice[1].1] });
        }
        let rows: Vec<usize> = order.iter().map(|(row, _)| *row).collect();
        let Some(&first) = rows.first() else { return Ok(Vec::new()) };
        let engine = self.edited()?;
        let (looks, stated) = (engine.placed.take_looks(), engine.remove_instances(&rows));
        self.repaint(looks);
        let gone = self.keys.remove(&mut self.scene, &rows);
        self.edits.remove_rows(&rows);
        self.scene.number_faces(first);
        let mut gone: Vec<(usize, SceneInstance)> = order.iter().map(|(_, k)| *k).zip(gone).collect();
        for ((k, gone), stated) in gone.iter_mut().zip(stated) {
            gone.visible = self.edits.remove(keys[*k]).visible;
            (gone.part, gone.colour, gone.key) = (self.scene.of_model(gone.part), stated.colour, None);
        }
        gone.sort_unstable_by_key(|(k, _)| *k);
        Ok(gone.into_iter().map(|(_, gone)| gone).collect())
    }

    /// Moves an instance from the next frame of views on. A frame that was begun goes on with its place before.
    ///
    /// # Errors
    /// When it was removed, or the transform is not a rigid motion with an optional reflection and uniform scale.
    pub fn move_instance(&mut self, key: InstanceKey, transform: DAffine3) -> Result<(), EditError> {
        let row = self.keys.row(key).ok_or(EditError::NoInstance { key })?;
        not_rigid(&transform).map_or(Ok(()), |error| Err(EditError::Transform { error }))?;
        self.edits.move_row(row, transform);
        Ok(())
    }

    /// Sets the attributes of a part of the model from the next frame of views on: for all its instances, together with
    /// their own. They replace those set before. A frame that was begun goes on without them. Whole frames by a plan
    /// ([`frame`](Self::frame)) have the model as it is.
    ///
    /// Cost: a look-up on this thread; in the frame, a look at all instances, and about 100 ns for each that changes.
    ///
    /// # Errors
    /// When there is no such part, or a value is out of range. Nothing changes.
    pub fn set_part(&mut self, part: PartId, attributes: &Attributes) -> Result<(), EditError> {
        self.part_attributes(part)?;
        check(attributes)?;
        self.edits.set_part(part, *attributes);
        Ok(())
    }

    /// As [`set_part`](Self::set_part), of one instance: no other is looked at.
    ///
    /// # Errors
    /// When it was removed, or a value is out of range. Nothing changes.
    pub fn set_instance(&mut self, key: InstanceKey, attributes: &Attributes) -> Result<(), EditError> {
        self.instance_attributes(key)?;
        check(attributes)?;
        self.edits.set_instance(key, *attributes);
        Ok(())
    }

    /// The attributes that [`set_part`](Self::set_part) set last for a part of the model, else the default.
    ///
    /// # Errors
    /// When there is no such part.
    pub fn part_attributes(&self, part: PartId) -> Result<Attributes, EditError> {
        let count = self.model.scene.parts.len();
        let known = part.index() < count;
        if known { Ok(self.edits.part(part)) } else { Err(EditError::NoPart { part, count }) }
    }

    /// The attributes that [`set_instance`](Self::set_instance) set last, without those of the part. Until then the
    /// default, with `visible` as the instance was added.
    ///
    /// # Errors
    /// When it was removed.
    pub fn instance_attributes(&self, key: InstanceKey) -> Result<Attributes, EditError> {
        let known = self.keys.row(key).is_some();
        if known { Ok(self.edits.instance(key)) } else { Err(EditError::NoInstance { key }) }
    }
}
