//! Plates with holes whose tessellants change -> updated triangles are valid triangulations of the plates.

use super::*;
use crate::sequence::random::SplitMix;

/// A plate with holes: circles with tessellants at given parameters.
struct Plate {
    points: Vec<DVec2>,
    starts: Vec<u32>,
    /// By tessellant: its loop and its parameter.
    keys: Vec<(usize, f64)>,
}

impl Plate {
    /// Loops (centre, radius, parameters); a negative radius is a hole. Parameters ascend within 0..1.
    fn of(loops: &[(DVec2, f64, Vec<f64>)]) -> Self {
        let mut plate = Self { points: Vec::new(), starts: vec![0], keys: Vec::new() };
        for (l, (centre, radius, ts)) in loops.iter().enumerate() {
            for &t in ts {
                let angle = std::f64::consts::TAU * t * radius.signum();
                plate.points.push(*centre + radius.abs() * DVec2::from_angle(angle));
                plate.keys.push((l, t));
            }
            plate.starts.push(plate.points.len() as u32);
        }
        plate
    }

    fn tile(&self) -> TrimInput<'_> {
        TrimInput { cells: (1, 1), points: &self.points, loop_starts: &self.starts, places: &[] }
    }

    fn made(&self) -> Vec<[u32; 3]> {
        let mut out = TrimOutput::default();
        trim_tile(&self.tile(), &mut TrimScratch::default(), &mut out).unwrap();
        out.triangles
    }

    fn from(&self, old: &Self) -> Vec<u32> {
        let find = |key: &(usize, f64)| old.keys.iter().position(|k| k == key).map_or(NONE, |v| v as u32);
        self.keys.iter().map(find).collect()
    }

    /// Updates a weave of `old` to this plate.
    fn update(&self, old: &Self, weave: &mut Weave) -> Option<()> {
        let from = self.from(old);
        let changed = LoopMapping { tile: self.tile(), old_starts: &old.starts, from: &from };
        weave.update(&changed, &mut TrimScratch::default(), &mut WeaveScratch::default())
    }

    fn check(&self, weave: &Weave) {
        assert_eq!(weave.triangles.len(), self.points.len() + 2 * self.starts.len() - 6);
        for t in &weave.triangles {
            let [a, b, c] = t.map(|v| self.points[v as usize]);
            assert!(orient2d(a, b, c) > 0.0);
        }
        // The adjacency matches the triangles, and their boundary is the loops.
        let again = Weave::of(&weave.triangles, &self.starts).unwrap();
        assert_eq!((&again.beside, &again.first), (&weave.beside, &weave.first));
        assert!(weave.covers(&self.tile()));
    }
}

fn even(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 / count as f64).collect()
}

fn loops(counts: [usize; 4]) -> [(DVec2, f64, Vec<f64>); 4] {
    let middle = DVec2::splat(0.5);
    let hole = |k: usize| (middle + 0.28 * DVec2::from_angle(2.1 * k as f64), -0.09, even(counts[k]));
    [(middle, 0.5, even(counts[0])), hole(1), hole(2), hole(3)]
}

#[test]
fn updates_are_valid_and_keep_distant_triangles() {
    let mut old = Plate::of(&loops([120, 24, 30, 17]));
    let mut weave = Weave::of(&old.made(), &old.starts).unwrap();
    let mut random = SplitMix(7);
    let mut counts = [120, 24, 30, 17];
    for step in 0..200 {
        let l = random.below(4) as usize;
        counts[l] = match random.below(3) {
            0 => counts[l] * 2,
            1 => (counts[l] / 2).max(5),
            _ => counts[l] + random.below(9) as usize - 4,
        }
        .clamp(5, 200);
        let new = Plate::of(&loops(counts));
        let from = new.from(&old);
        let before = weave.clone();
        assert!(new.update(&old, &mut weave).is_some(), "{step}: {counts:?}");
        new.check(&weave);
        // Most triangles without a vertex on the changed loop stay.
        if l > 0 {
            let to = |v: u32| from.iter().position(|&old| old == v);
            let stays = |t: &&[u32; 3]| t.iter().all(|&v| old.keys[v as usize].0 != l);
            let kept: Vec<[u32; 3]> =
                before.triangles.iter().filter(stays).map(|t| t.map(|v| to(v).unwrap() as u32)).collect();
            let left = kept.iter().filter(|t| weave.triangles.contains(t)).count();
            assert!(2 * left > kept.len(), "{step}: {left} of {}", kept.len());
        }
        old = new;
    }
}

#[test]
fn all_of_a_loop_but_one_tessellant_may_change() {
    let old = Plate::of(&loops([90, 20, 20, 20]));
    let mut weave = Weave::of(&old.made(), &old.starts).unwrap();
    let new = Plate::of(&loops([7, 3, 3, 31]));
    new.update(&old, &mut weave).unwrap();
    new.check(&weave);
    // No change.
    let same = weave.clone();
    new.update(&new, &mut weave).unwrap();
    assert_eq!((same.triangles, same.first), (weave.triangles.clone(), weave.first.clone()));
    // A loop that keeps no tessellant cannot be updated.
    let (mut other, turned) = (loops([7, 3, 3, 31]), vec![0.1, 0.4, 0.8]);
    other[1].2 = turned;
    assert!(Plate::of(&other).update(&new, &mut weave).is_none());
}

#[test]
fn loops_that_meet_are_refused() {
    // A hole close to the border: a coarser border cuts it.
    let near = |border: usize| {
        let middle = DVec2::splat(0.5);
        Plate::of(&[(middle, 0.5, even(border)), (DVec2::new(0.5, 0.12), -0.1, even(24))])
    };
    let fine = near(64);
    let mut weave = Weave::of(&fine.made(), &fine.starts).unwrap();
    assert!(near(5).update(&fine, &mut weave).is_none(), "the border's chord cuts the hole");
    let mut weave = Weave::of(&fine.made(), &fine.starts).unwrap();
    near(32).update(&fine, &mut weave).unwrap();
    near(32).check(&weave);
    // A boundary that touches itself.
    let tooth = |tip: f64| {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.6, 1.0), (0.5, tip), (0.4, 1.0), (0.0, 1.0)];
        let keys = (0..7).map(|k| (0, if k == 4 { tip } else { -f64::from(k) })).collect();
        Plate { points: corners.map(DVec2::from).to_vec(), starts: vec![0, 7], keys }
    };
    let old = tooth(0.3);
    let mut weave = Weave::of(&old.made(), &old.starts).unwrap();
    assert!(tooth(0.0).update(&old, &mut weave.clone()).is_none(), "the tip stands on the border");
    tooth(0.7).update(&old, &mut weave).unwrap();
    tooth(0.7).check(&weave);
}

#[test]
fn triangles_that_do_not_conform_are_refused() {
    let square = [0, 4];
    assert!(Weave::of(&[[0, 1, 2], [0, 2, 3]], &square).is_some());
    let bad: [&[[u32; 3]]; 4] =
        [&[[0, 1, 2]], &[[0, 1, 2], [0, 1, 2], [0, 2, 3]], &[[0, 1, 3], [0, 2, 3]], &[[0, 1, 9]]];
    for triangles in bad {
        assert!(Weave::of(triangles, &square).is_none(), "{triangles:?}");
    }
}
