//! A point in space -> its feet on the whole surface.

use super::Projector;
use crate::model::Surface;
use crate::prepare::uv::foot::Foot;
use crate::prepare::uv::seeds::Seeds;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;

impl Projector<'_> {
    /// The foot of `p` nearest to it, or the first one found on the surface.
    pub(super) fn search(&self, p: DVec3) -> Foot {
        if let (Surface::Nurbs(net), [None, None], []) = (self.surface, self.period, &self.poles[..]) {
            // Most vertices are corners of the net, or not far from a control point. A lattice of seeds takes thousands
            // of points.
            let found = self.newton(p, net.nearest_control(p));
            if found.off <= self.tolerance {
                return found;
            }
        }
        let seeds = self.seeds.get_or_init(|| Seeds::of(self.surface, self.domain, self.period));
        let mut answer = Foot::none(DVec2::ZERO);
        for start in seeds.starts(p) {
            let found = self.newton(p, start);
            if found.off < answer.off {
                answer = found;
            }
            if answer.off <= self.tolerance {
                break;
            }
        }
        answer
    }

    /// Parameters of the surface points at `p`, one on each sheet that passes there.
    pub(crate) fn sheets_at(&self, p: DVec3) -> SmallVec<[DVec2; 2]> {
        let mut sheets: SmallVec<[Foot; 2]> = SmallVec::new();
        let seeds = self.seeds.get_or_init(|| Seeds::of(self.surface, self.domain, self.period));
        for start in seeds.starts(p) {
            let found = self.newton(p, start);
            let is_same = |foot: &Foot| self.length(foot.uv, self.unwrap(found.uv, foot.uv) - foot.uv) <= self.near();
            if found.off <= self.near() && !sheets.iter().any(is_same) {
                sheets.push(found);
            }
        }
        sheets.sort_by(|a, b| a.off.total_cmp(&b.off));
        sheets.iter().map(|foot| foot.uv).collect()
    }
}
