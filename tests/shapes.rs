//! Every named shape -> a mesh with the area, volume and closedness of its closed form, decade by decade.

mod common;

use common::{prepared_clean, whole_frame};
use std::f64::consts::PI;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{MeshFacts, check_scene};

/// Area, and the volume of solids.
fn exact(name: &str) -> (Option<f64>, Option<f64>) {
    let washer = (2.0 * PI * (100.0 - 36.0) + 2.0 * PI * 16.0 * 3.0, PI * (100.0 - 36.0) * 3.0);
    let cylinder = (2.0 * PI * 25.0 + 2.0 * PI * 5.0 * 8.0, PI * 25.0 * 8.0);
    match name {
        "square" => (Some(400.0 - 36.0 * PI), None),
        "box" => (Some(2.0 * (600.0 + 300.0 + 200.0)), Some(6000.0)),
        "cylinder" => (Some(cylinder.0), Some(cylinder.1)),
        "washer" => (Some(washer.0), Some(washer.1)),
        "cone" => (Some(PI * 25.0 * (1.0 + 2.0_f64.sqrt())), Some(PI * 125.0 / 3.0)),
        "sphere" => (Some(4.0 * PI * 25.0), Some(4.0 / 3.0 * PI * 125.0)),
        "torus" => (Some(4.0 * PI * PI * 8.0 * 3.0), Some(2.0 * PI * PI * 8.0 * 9.0)),
        "pair" => (Some(2.0 * washer.0 + cylinder.0), Some(2.0 * washer.1 + cylinder.1)),
        _ => (None, None),
    }
}

fn mesh(name: &str, chord: f64) -> MeshFacts {
    let model = trimtess_models::by_name(name).unwrap_or_else(|| panic!("no shape {name}"));
    let prepared = prepared_clean(model);
    let plan = frame::plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
    check_scene(&whole_frame(&prepared, &plan, false)).total
}

#[test]
fn meshes_have_the_area_and_volume_of_their_shape() {
    // The paper's models have their own tests: models/tests/builtin.
    for name in trimtess_models::names().filter(|name| !name.contains('-')) {
        for chord in [0.1, 0.01, 0.001] {
            let facts = mesh(name, chord);
            assert!(facts.is_well_formed(), "{name} at {chord}: {facts}");
            let (area, volume) = exact(name);
            // A chord of c on a radius r changes the area by about c/r; the smallest radius here is 3.
            let near = |got: f64, want: f64| (got / want - 1.0).abs() <= chord / 3.0 * 1.5 + 1e-12;
            if let Some(area) = area {
                assert!(near(facts.area, area), "{name} at {chord}: area {}, exact {area}", facts.area);
            }
            match volume {
                Some(volume) => {
                    assert!(facts.is_closed(), "{name} at {chord}: {facts}");
                    assert_eq!(facts.negative_components, 0, "{name} at {chord}: {facts}");
                    assert!(near(facts.volume, volume), "{name} at {chord}: volume {}, exact {volume}", facts.volume);
                }
                None => assert!(facts.unbalanced_edges > 0, "{name} is a sheet: {facts}"),
            }
        }
    }
}
