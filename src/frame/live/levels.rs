//! Instances of one part, far and near -> levels of detail (LODs) of the part, each planned for instances of similar
//! scale on screen.
//!
//! One mesh for all instances would have to be as fine as the nearest needs. So a part with several instances has
//! several rows in the prepared model, one per LOD, which share its data. Each row serves a band of pixels per
//! millimetre: a factor of 4, which is a factor of 2 in lattice lines. Bands are absolute: when the camera moves,
//! instances change rows and the rows' meshes stay. The cost is the triangles of all rows in use, once each.

use super::culling::InstanceSight;
use super::placed::{PlacedInstances, Shown};
use crate::math::keyed::{matched, take_rows};
use crate::model::PartId;
use crate::prepare::Prepared;
use smallvec::SmallVec;
use std::collections::VecDeque;
use std::sync::Arc;

/// Width of a band, as the binary logarithm of the ratio of pixels per millimetre at its ends: a factor of 4.
const BAND: f64 = 2.0;
/// Hysteresis, in bands: log2(1.2), so an instance leaves its band once it is outside by a factor of 1.2.
const SLACK: f64 = 0.263_034_405_833_793_8 / BAND;

/// A band of screen-space scales; the higher, the finer. `None`: not assigned yet.
type Band = Option<i32>;

/// The LODs of each part, and the LOD that each instance uses.
#[derive(Debug)]
pub struct Levels {
    /// By part of the model.
    parts: Vec<PartLevels>,
    /// The part of the model, and the band, of each instance.
    instances: Vec<(PartId, Band)>,
    /// LODs of a part, at most.
    most: usize,
    /// Number of rows, with those of `new`.
    rows: usize,
    /// Parts of LODs that the prepared model does not have yet.
    new: Vec<PartId>,
    before: Before,
}

/// What the last assignment replaced, in the order in which it did.
#[derive(Debug, Default)]
struct Before {
    /// Bands of instances.
    bands: Vec<(usize, Band)>,
    /// Bands of parts and their LODs.
    served: Vec<(usize, usize, Band)>,
    /// LODs of instances.
    selected: Vec<(usize, PartId)>,
}

#[derive(Debug)]
struct PartLevels {
    /// Rows in the prepared model, one per LOD; the part's own first.
    rows: Vec<PartId>,
    /// The band that each row serves; `None` while the row is unused.
    bands: Vec<Band>,
    /// Number of instances.
    placed: usize,
}

impl Levels {
    /// Returns the model with up to `most` LODs for each part that has several instances. Further LODs are appended
    /// after the model's parts and share their data.
    ///
    /// Memory: in a planner, about 200 bytes per tile and edge of each LOD that a view has shown.
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
                rows.push(add_level(&mut out, PartId::new(p)));
            }
            let bands = vec![None; rows.len()];
            parts.push(PartLevels { rows, bands, placed });
        }
        let instances = prepared.scene.instances.iter().map(|i| (i.part, None)).collect();
        let rows = out.parts.len();
        (Arc::new(out), Self { parts, instances, most, rows, new: Vec::new(), before: Before::default() })
    }

    /// Switches to another model. Returns that with its LODs, and for each of its rows the same part's row in `before`;
    /// `None` for rows of parts that the model before did not have. `before` is what was returned last.
    ///
    /// Rows that both have keep their bands. So do instances, by their order among those of their part.
    #[must_use]
    pub fn update(&mut self, before: &Prepared, model: &Arc<Prepared>) -> (Arc<Prepared>, Vec<Option<PartId>>) {
        let [old, new] = [&before.parts[..self.parts.len()], &model.parts]
            .map(|parts| parts.iter().map(|part| part.content()).collect::<Vec<_>>());
        let parts = matched(&old, &new);
        let (prepared, mut next) = Self::of(model, self.most);
        let mut from = vec![None; prepared.parts.len()];
        for (new, old) in next.parts.iter_mut().zip(&parts) {
            let Some(old) = old.map(|old| &self.parts[old]) else { continue };
            for (k, (row, band)) in old.rows.iter().zip(&old.bands).take(new.rows.len()).enumerate() {
                from[new.rows[k].index()] = Some(*row);
                new.bands[k] = *band;
            }
        }
        let mut bands: Vec<VecDeque<Band>> = vec![VecDeque::new(); self.parts.len()];
        self.instances.iter().for_each(|(part, band)| bands[part.index()].push_back(*band));
        for (part, band) in &mut next.instances {
            let old = parts[part.index()].and_then(|old| bands[old].pop_front());
            *band = old.flatten();
        }
        *self = next;
        (prepared, from)
    }

    /// Appends an instance of `part`. Returns whether its instances can use one more LOD, which is then the last row
    /// once [`grown`](Self::grown) has appended it.
    pub fn push(&mut self, part: PartId) -> bool {
        self.instances.push((part, None));
        let levels = &mut self.parts[part.index()];
        levels.placed += 1;
        if levels.rows.len() >= levels.placed.min(self.most) {
            return false;
        }
        levels.rows.push(PartId::new(self.rows));
        levels.bands.push(None);
        self.rows += 1;
        self.new.push(part);
        true
    }

    /// Appends the LODs of instances that came since the last call: returns `prepared` with them after all other parts,
    /// and the parts that they are of. `None` if there are none. Cost: one pass over the parts, however many came.
    pub fn grown(&mut self, prepared: &Prepared) -> Option<(Arc<Prepared>, Vec<PartId>)> {
        let new = std::mem::take(&mut self.new);
        if new.is_empty() {
            return None;
        }
        let mut out = Prepared::clone(prepared);
        new.iter().for_each(|part| _ = add_level(&mut out, *part));
        Some((Arc::new(out), new))
    }

    /// Removes instances, whose indices ascend. Those of later instances decrease.
    pub fn remove(&mut self, instances: &[usize]) {
        let gone = take_rows(&mut self.instances, instances);
        gone.into_iter().for_each(|(part, _)| self.parts[part.index()].placed -= 1);
    }

    /// Selects the LOD of each instance by its largest scale in the valid views, which may show `shown`. Instances that
    /// no view shows keep theirs.
    ///
    /// Where there are more bands than LODs, the coarser bands share an LOD, at the tolerance of the finest of them.
    /// The result depends on the views and on earlier assignments. Cost: about 20 ns per view and instance that it may
    /// show, for parts with several LODs.
    pub(crate) fn assign(&mut self, placed: &mut PlacedInstances, shown: &Shown) {
        let Before { bands, served, selected } = &mut self.before;
        bands.clear();
        served.clear();
        selected.clear();
        if self.rows == self.parts.len() {
            return;
        }
        // The largest scale of each instance that is shown, ascending.
        let several = |sight: &&InstanceSight| self.parts[self.instances[sight.instance].0.index()].rows.len() > 1;
        let scales = shown.sights.iter().filter(several).map(|sight| (sight.instance, sight.most));
        let mut scales: Vec<(usize, f64)> = scales.filter(|(_, most)| *most > 0.0 && most.is_finite()).collect();
        scales.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        scales.dedup_by_key(|(instance, _)| *instance);
        let mut wanted = Vec::with_capacity(scales.len());
        for &(instance, most) in &scales {
            let (part, band) = &mut self.instances[instance];
            let now = band_of(most, *band);
            if *band != Some(now) {
                bands.push((instance, band.replace(now)));
            }
            wanted.push((part.index(), now));
        }
        wanted.sort_unstable();
        wanted.dedup();
        for of_part in wanted.chunk_by(|a, b| a.0 == b.0) {
            let part = of_part[0].0;
            let bands: SmallVec<[i32; 8]> = of_part.iter().map(|(_, band)| *band).collect();
            self.parts[part].serve(&bands, |row, before| served.push((part, row, before)));
        }
        for (instance, _) in scales {
            let (part, band) = self.instances[instance];
            let row = band.and_then(|band| self.parts[part.index()].row(band));
            let before = row.and_then(|row| placed.select(instance, row));
            selected.extend(before.map(|before| (instance, before)));
        }
    }

    /// Takes back the last assignment. Neither instances nor parts changed since.
    pub(crate) fn revert(&mut self, placed: &mut PlacedInstances) {
        let Before { bands, served, selected } = &mut self.before;
        bands.drain(..).for_each(|(instance, band)| self.instances[instance].1 = band);
        served.drain(..).rev().for_each(|(part, row, band)| self.parts[part].bands[row] = band);
        selected.drain(..).rev().for_each(|(instance, part)| placed.unselect(instance, part));
    }
}

/// Appends an LOD of a part, and returns its row.
pub(crate) fn add_level(prepared: &mut Prepared, part: PartId) -> PartId {
    let row = PartId::new(prepared.parts.len());
    let of_part = Arc::clone(&prepared.parts[part.index()]);
    Arc::make_mut(&mut prepared.parts).push(of_part);
    prepared.scene.add_level(part);
    row
}

/// The band of a scale, in pixels of the allowed deviation per millimetre. Keeps `before` within the hysteresis.
fn band_of(most: f64, before: Band) -> i32 {
    let exact = libm::log2(most) / BAND;
    let near = |&band: &i32| exact >= f64::from(band) - SLACK && exact < f64::from(band) + 1.0 + SLACK;
    #[allow(clippy::cast_possible_truncation, reason = "the logarithm of a number is below 1100")]
    before.filter(near).unwrap_or(exact.floor() as i32)
}

impl PartLevels {
    /// Assigns rows to the finest of the `wanted` bands, which ascend. A band keeps its row, with the tiles made for
    /// it, until another band needs the row. Tells `replaced` of each row that changes, and its band before.
    fn serve(&mut self, wanted: &[i32], mut replaced: impl FnMut(usize, Band)) {
        let finest = &wanted[wanted.len().saturating_sub(self.rows.len())..];
        for band in finest.iter().rev() {
            if self.bands.contains(&Some(*band)) {
                continue;
            }
            let unused = |band: &Band| band.is_none_or(|band| !finest.contains(&band));
            let row = self.bands.iter().position(Option::is_none).or_else(|| self.bands.iter().position(unused));
            if let Some(row) = row {
                replaced(row, self.bands[row].replace(*band));
            }
        }
    }

    /// The row of a band: its own, else that of the next finer band with a row.
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
        let mut levels = PartLevels { rows: [3, 7, 8].map(PartId).to_vec(), bands: vec![None; 3], placed: 9 };
        levels.serve(&[], |_, _| ());
        assert_eq!(levels.row(0), None);
        levels.serve(&[2, 5], |_, _| ());
        assert_eq!(
            [levels.row(5), levels.row(2), levels.row(1), levels.row(6)],
            [Some(3), Some(7), Some(7), None].map(|row| row.map(PartId))
        );
        // Whatever is shown meanwhile.
        [&[2][..], &[], &[5]].into_iter().for_each(|shown| levels.serve(shown, |_, _| ()));
        assert_eq!([levels.row(5), levels.row(2)], [Some(3), Some(7)].map(|row| row.map(PartId)));
        levels.serve(&[1, 2, 3, 4], |_, _| ());
        let rows = [1, 2, 3, 4].map(|band| levels.row(band).unwrap());
        assert_eq!((rows[0], rows[1]), (PartId(7), PartId(7)));
        assert!(rows[2] != rows[3] && rows[2] != PartId(7) && rows[3] != PartId(7));
    }

    #[test]
    fn bands_have_hysteresis() {
        assert_eq!([band_of(1.0, None), band_of(3.9, None), band_of(4.0, None), band_of(0.9, None)], [0, 0, 1, -1]);
        assert_eq!(
            [band_of(4.5, Some(0)), band_of(5.0, Some(0)), band_of(0.9, Some(0)), band_of(0.8, Some(0))],
            [0, 1, 0, -1]
        );
    }
}
