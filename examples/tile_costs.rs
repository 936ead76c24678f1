use std::time::Instant;
use trimtess::frame::*;
use trimtess::model::shapes;
use trimtess::prepare::*;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let model = match name.strip_prefix("builtin:") {
            Some(n) => shapes::by_name(n).ok_or("no")?,
            None => trimtess::import::step::read_file(name.as_ref(), &Default::default())?,
        };
        let short = name.rsplit('/').next().unwrap();
        let prepared = prepare(model, &PrepareOptions::DEFAULT)?;
        let Some(bounds) = prepared.bounds else { continue };
        let picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: 30f64.to_radians() };
        let mut scratch = Scratch::default();
        let n = prepared.tiles().count();
        // reference plans
        let rel = |c: f64| {
            plan(&prepared, &Tolerance { chord: c * prepared.diagonal, angle: 30f64.to_radians(), max_edge: None })
        };
        let t = Instant::now();
        let refs = [rel(1e-3), rel(1e-4)];
        eprintln!("{short}: {n} tiles, two plans {:?}", t.elapsed());
        for f in 0..6 {
            let view = CameraPath::Orbit.view(bounds, f, 6, &picture);
            let plan = plan_for_view(&prepared, &view);
            let mut costs = vec![f64::INFINITY; n];
            let mut tris = vec![0; n];
            for _ in 0..4 {
                for (k, (part, tile, _)) in prepared.tiles().enumerate() {
                    let b = Instant::now();
                    let o = tessellate_tile(&prepared, &plan, part, tile, &mut scratch);
                    costs[k] = costs[k].min(b.elapsed().as_nanos() as f64);
                    tris[k] = o.mesh.triangles.len();
                }
            }
            for (k, (part, tile, row)) in prepared.tiles().enumerate() {
                let p = &prepared.parts[part.index()];
                let face = &p.faces[p.face_of(row)];
                let feat = |plan: &Plan| {
                    let pp = &plan.parts[part.index()];
                    let (nu, nv) = pp.tiles[tile.0 as usize].cells();
                    let tess: u32 = row
                        .loops
                        .iter()
                        .flatten()
                        .map(|u| {
                            let b = &pp.edges[u.edge as usize].breaks;
                            b[u.from as usize].abs_diff(b[u.to as usize])
                        })
                        .sum();
                    (nu, nv, tess)
                };
                let a = feat(&plan);
                let r = refs.each_ref().map(feat);
                let br: u32 = row.loops.iter().flatten().map(|u| u.from.abs_diff(u.to)).sum();
                let pieces = |breaks: &[f64], lo: f64, hi: f64| {
                    breaks.windows(2).filter(|w| w[0] < hi && w[1] > lo).count().max(1)
                };
                let inside = pieces(&face.patches.breaks_u, row.min.x, row.max.x)
                    * pieces(&face.patches.breaks_v, row.min.y, row.max.y);
                println!(
                    "{short},{f},{k},{:?},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    face.kind,
                    costs[k],
                    tris[k],
                    a.0,
                    a.1,
                    a.2,
                    r[0].0,
                    r[0].1,
                    r[0].2,
                    r[1].0,
                    r[1].1,
                    r[1].2,
                    br,
                    inside,
                    row.weight,
                    row.loops.len(),
                    row.entangled
                );
            }
        }
    }
    Ok(())
}
