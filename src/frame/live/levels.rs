//! Instances of one part, far and near -> rows of the part, each planned for those that need about the same.
//!
//! One mesh for all instances has to be as fine as the nearest needs it, and all others are drawn as finely. So a part that is
//! placed several times stands in the prepared model several times, as one object, and each of its rows serves a band of
//! distances: a factor of four in rate, two in lines, is one band. The bands are absolute, so that a row is not made anew when the camera
//! moves, but instances go from row to row. What that costs is the triangles of the rows that are in use, once each.

use super::shown::PartBoxes;
use crate::frame::view::camera::View;
use crate::mesh::{SceneInstance, ScenePart};
use crate::model::PartId;
use crate::prepare::Prepared;
use crate::prepare::internals::BoundingBox;
use std::sync::Arc;

/// Pixels that a millimetre covers, from one band to the next.
const BAND: f64 = 4.0;
/// How far beyond its band an instance must be to leave it.
const SLACK: f64 = 1.2;

/// A band of distances.
type Band = Option<i32>;

/// Which rows each part of a model has, and who is in which.
#[derive(Debug)]
pub struct Levels {
    /// By part of the model.
    parts: Vec<PartLevels>,
    /// The part of the model, and the band, of each instance.
    instances: Vec<(PartId, Band)>,
}

#[derive(Debug)]
struct PartLevels {
    /// Rows in the prepared model; the part's own first.
    rows: Vec<PartId>,
    /// The band that each row serves; `None` while it serves none.
    bands: Vec<Band>,
    place: BoundingBox,
}

impl Levels {
    /// The model with up to `most` rows for each part that it places more than once, after the rows of its parts; their
    /// triangles and edges are shared, not copied.
    ///
    /// Cost: nothing to speak of, and in planners about 200 bytes per tile and edge of each row.
    #[must_use]
    pub fn of(prepared: &Arc<Prepared>, most: usize) -> (Arc<Prepared>, Self) {
        let mut placed = vec![0_usize; prepared.parts.len()];
        for instance in &prepared.scene.instances {
            placed[instance.part.index()] += 1;
        }
        let mut out = Prepared::clone(prepared);
        let mut parts = Vec::with_capacity(placed.len());
        for (p, placed) in placed.into_iter().enumerate() {
            let mut rows = vec![PartId::new(p)];
            for _ in 1..placed.min(most) {
                rows.push(PartId::new(out.parts.len()));
                out.parts.push(Arc::clone(&prepared.parts[p]));
                out.scene.parts.push(ScenePart { mesh_of: Some(PartId::new(p)), ..prepared.scene.parts[p].clone() });
            }
            parts.push(PartLevels { bands: vec![None; rows.len()], rows, place: PartBoxes::whole(&prepared.parts[p]) });
        }
        let instances = prepared.scene.instances.iter().map(|i| (i.part, None)).collect();
        (Arc::new(out), Self { parts, instances })
    }

    /// How many parts the model has: rows from there on are further ones of these.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// The part of the model that an instance is of. `None` if there is no such instance.
    #[must_use]
    pub fn part_of(&self, instance: usize) -> Option<PartId> {
        self.instances.get(instance).map(|(part, _)| *part)
    }

    /// An instance was added after the others.
    pub fn push(&mut self, part: PartId) {
        self.instances.push((part, None));
    }

    /// An instance was removed, and those after it moved up.
    pub fn remove(&mut self, instance: usize) {
        self.instances.remove(instance);
    }

    /// Gives each instance the row that serves what the views show of it. Those that no view shows stay where they are.
    ///
    /// Where there are more bands than rows, the coarser bands share a row, and keep the tolerance of the finest of them.
    /// A function of the views and of what was assigned before. Cost: about 20 ns per view for each instance of a part with
    /// several rows.
    pub fn assign(&mut self, instances: &mut [SceneInstance], views: &[View]) {
        if self.parts.iter().all(|part| part.rows.len() == 1) {
            return;
        }
        let lenses: Vec<_> = views.iter().map(|view| (view, view.lens())).collect();
        let mut wanted: Vec<Vec<i32>> = vec![Vec::new(); self.parts.len()];
        for ((part, band), instance) in self.instances.iter_mut().zip(&*instances) {
            let levels = &self.parts[part.index()];
            if levels.rows.len() == 1 {
                continue;
            }
            let seen = lenses.iter().filter_map(|&(view, lens)| {
                let seen = view.sight(lens?, instance).look(&levels.place)?;
                Some(seen.most / view.deviation_px)
            });
            let most = seen.fold(0.0, f64::max);
            if most > 0.0 && most.is_finite() {
                *band = Some(band_of(most, *band));
                wanted[part.index()].extend(*band);
            }
        }
        for (levels, wanted) in self.parts.iter_mut().zip(&mut wanted) {
            wanted.sort_unstable();
            wanted.dedup();
            levels.serve(wanted);
        }
        for ((part, band), instance) in self.instances.iter().zip(instances) {
            let levels = &self.parts[part.index()];
            if let Some(row) = band.and_then(|band| levels.row(band)) {
                instance.part = row;
            }
        }
    }
}

/// The band of a rate; the one before, as long as that is near.
fn band_of(most: f64, before: Band) -> i32 {
    let exact = most.log2() / BAND.log2();
    let slack = SLACK.log2() / BAND.log2();
    let near = |&band: &i32| exact >= f64::from(band) - slack && exact < f64::from(band) + 1.0 + slack;
    #[allow(clippy::cast_possible_truncation, reason = "the logarithm of a number is below 1100")]
    before.filter(near).unwrap_or(exact.floor() as i32)
}

impl PartLevels {
    /// Has rows for the bands that are wanted, ascending; those that have one keep it.
    fn serve(&mut self, wanted: &[i32]) {
        let finest = &wanted[wanted.len().saturating_sub(self.rows.len())..];
        for band in &mut self.bands {
            *band = band.filter(|band| finest.contains(band));
        }
        for band in finest.iter().rev() {
            if !self.bands.contains(&Some(*band))
                && let Some(free) = self.bands.iter_mut().find(|band| band.is_none())
            {
                *free = Some(*band);
            }
        }
    }

    /// The row of a band: its own, or that of the next finer one that has a row.
    fn row(&self, band: i32) -> Option<PartId> {
        let served = self.bands.iter().zip(&self.rows).filter_map(|(served, row)| Some(((*served)?, *row)));
        served.filter(|(served, _)| *served >= band).min().map(|(_, row)| row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_bands_and_coarser_bands_share_the_next_finer_row() {
        let place = BoundingBox::EMPTY;
        let mut levels = PartLevels { rows: [3, 7, 8].map(PartId).to_vec(), bands: vec![None; 3], place };
        levels.serve(&[]);
        assert_eq!(levels.row(0), None);
        levels.serve(&[2, 5]);
        assert_eq!(
            [levels.row(5), levels.row(2), levels.row(1), levels.row(6)],
            [Some(3), Some(7), Some(7), None].map(|row| row.map(PartId))
        );
        levels.serve(&[1, 2, 3, 4]);
        let rows = [1, 2, 3, 4].map(|band| levels.row(band).unwrap());
        assert_eq!((rows[0], rows[1]), (PartId(7), PartId(7)));
        assert!(rows[2] != rows[3] && rows[2] != PartId(7) && rows[3] != PartId(7));
    }

    #[test]
    fn a_band_is_left_late() {
        assert_eq!([band_of(1.0, None), band_of(3.9, None), band_of(4.0, None), band_of(0.9, None)], [0, 0, 1, -1]);
        assert_eq!(
            [band_of(4.5, Some(0)), band_of(5.0, Some(0)), band_of(0.9, Some(0)), band_of(0.8, Some(0))],
            [0, 1, 0, -1]
        );
    }
}
