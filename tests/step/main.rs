//! The STEP reader on hand-written texts, one small file per kind of entity.
#![cfg(feature = "step")]

#[path = "../attacks/mod.rs"]
mod attacks;
mod bodies;
mod broken;
#[path = "../common/mod.rs"]
mod common;
mod curves;
mod deep;
mod derived;
mod editions;
mod forms;
mod poles;
mod products;
mod repeats;
mod supplemental;
mod surfaces;
mod topology;

use glam::DVec3;
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{Diagnostic, Edge, Face, Model, Part, Severity, StepTrouble};

/// Two solids, each a whole sphere.
const BALLS: &str = "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60,#70),#1);\n\
    #60=MANIFOLD_SOLID_BREP('',#61);\n#61=CLOSED_SHELL('',(#62));\n#62=ADVANCED_FACE('',(),#63,.T.);\n\
    #63=SPHERICAL_SURFACE('',#20,1.);\n\
    #70=MANIFOLD_SOLID_BREP('',#71);\n#71=CLOSED_SHELL('',(#72));\n#72=ADVANCED_FACE('',(),#73,.T.);\n\
    #73=SPHERICAL_SURFACE('',#20,2.);\n";

/// Number of faces that are not lost.
fn faces(model: &Model) -> usize {
    model.parts.iter().flat_map(|part| &part.faces).filter(|face| !face.lost).count()
}

/// Millimetres and radians as context #1; with degrees as #2; with inches as #3.
const UNITS: &str = "
#1=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#10))
  GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#6,#7))REPRESENTATION_CONTEXT('',''));
#2=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#8))REPRESENTATION_CONTEXT('',''));
#3=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#9,#6))REPRESENTATION_CONTEXT('',''));
#5=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#6=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#7=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());
#8=(CONVERSION_BASED_UNIT('DEGREE',#11)NAMED_UNIT(#13)PLANE_ANGLE_UNIT());
#9=(CONVERSION_BASED_UNIT('INCH',#12)LENGTH_UNIT()NAMED_UNIT(#13));
#10=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-5),#5,'distance_accuracy_value','');
#11=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#6);
#12=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#5);
#13=DIMENSIONAL_EXPONENTS(0.,0.,0.,0.,0.,0.,0.);
";

/// Whether a diagnostic states that something was not read, for a reason of this kind.
fn is(told: &Diagnostic, of: impl Fn(&StepTrouble) -> bool) -> bool {
    told.kind.step_trouble().is_some_and(of)
}

/// A whole file around a data section.
fn file(data: &str) -> String {
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{UNITS}{data}\nENDSEC;\nEND-ISO-10303-21;\n"
    )
}

fn model(data: &str) -> Model {
    model_of_file(&file(data))
}

fn model_of_file(text: &str) -> Model {
    let model = read(text.as_bytes(), &StepOptions::default()).expect("a readable file");
    common::documented(&model.diagnostics);
    model
}

/// Asserts that there is no diagnostic worse than a note.
fn clean(model: &Model) {
    let bad: Vec<_> = model.diagnostics.iter().filter(|d| d.severity > Severity::Note).collect();
    assert!(bad.is_empty(), "{bad:?}");
    let refused: Vec<_> = model.parts.iter().flat_map(|p| &p.faces).filter_map(|face| face.refused.as_ref()).collect();
    assert!(refused.is_empty(), "{refused:?}");
}

fn only_part(model: &Model) -> &Part {
    assert_eq!(model.parts.len(), 1, "{:?}", model.diagnostics);
    &model.parts[0]
}

fn only_face(model: &Model) -> &Face {
    assert_eq!(only_part(model).faces.len(), 1, "{:?}", model.diagnostics);
    &model.parts[0].faces[0]
}

fn edge_of(part: &Part, entity: u64) -> &Edge {
    part.edges.iter().find(|edge| edge.entity == entity).unwrap_or_else(|| panic!("no edge #{entity}"))
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!(a.distance(b) < 1e-9, "{a} is not {b}");
}

fn point(id: u32, p: [f64; 3]) -> String {
    format!("#{id}=CARTESIAN_POINT('',({:.20},{:.20},{:.20}));\n", p[0], p[1], p[2])
}

/// An `AXIS2_PLACEMENT_3D` #id using #id+1..#id+3.
fn placement(id: u32, origin: [f64; 3], axis: [f64; 3], reference: [f64; 3]) -> String {
    let direction = |id: u32, d: [f64; 3]| format!("#{id}=DIRECTION('',({:?},{:?},{:?}));\n", d[0], d[1], d[2]);
    format!("#{id}=AXIS2_PLACEMENT_3D('',#{},#{},#{});\n", id + 1, id + 2, id + 3)
        + &point(id + 1, origin)
        + &direction(id + 2, axis)
        + &direction(id + 3, reference)
}

/// The world's axes as placement #20.
fn world() -> String {
    placement(20, [0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
}

/// Vertices #id (point #id+1) at `p`.
fn vertex(id: u32, p: [f64; 3]) -> String {
    format!("#{id}=VERTEX_POINT('',#{});\n", id + 1) + &point(id + 1, p)
}

/// An open shell #90 of the one face #91, in the representation #92 with context `#context`.
fn shell(face: &str, context: u32) -> String {
    format!(
        "#91={face};\n#90=OPEN_SHELL('',(#91));\n#93=SHELL_BASED_SURFACE_MODEL('',(#90));\n\
         #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#93),#{context});\n"
    )
}

/// The face #91 on surface `#surface`, in an open shell. Its bound #76 has the loop #75 of `edges`, with oriented edges
/// from #70 on; a negative edge is used against its direction.
fn bounded_face(edges: &[i32], surface: u32, context: u32) -> String {
    let uses: Vec<String> = (70..).take(edges.len()).map(|id| format!("#{id}")).collect();
    let mut text = format!("#75=EDGE_LOOP('',({}));#76=FACE_OUTER_BOUND('',#75,.T.);", uses.join(","));
    for (id, edge) in uses.iter().zip(edges) {
        text += &format!("{id}=ORIENTED_EDGE('',*,*,#{},.{}.);", edge.abs(), if *edge > 0 { 'T' } else { 'F' });
    }
    text + &shell(&format!("ADVANCED_FACE('',(#76),#{surface},.T.)"), context)
}

/// A square in the plane #60 at height `z`: vertices #30, #32, #34, #36 counter-clockwise, edges #50..#53 from each to
/// the next, oriented edges #70..#73 along them, their loop #75 and bound #76.
fn square(side: f64, z: f64) -> String {
    let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
    let mut text =
        world() + "#60=PLANE('',#20);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));#63=LINE('',#21,#61);";
    for (i, [x, y]) in corners.into_iter().enumerate() {
        text += &vertex(30 + 2 * u32::try_from(i).expect("small"), [x, y, z]);
        let (from, to) = (30 + 2 * i, 30 + 2 * ((i + 1) % 4));
        text += &format!("#{}=EDGE_CURVE('',#{from},#{to},#63,.T.);", 50 + i);
        text += &format!("#{}=ORIENTED_EDGE('',*,*,#{},.T.);", 70 + i, 50 + i);
    }
    text + "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);"
}
