//! Small files whose lists lead to the same items many times, and files of extreme numbers.

#![allow(clippy::unwrap_used, reason = "writing to a string does not fail")]
#![allow(dead_code, reason = "not every test uses all of it")]

use std::fmt::Write as _;

/// A file of these instances, with a context #1 in millimetres, axes #7, and a product definition shape #16.
pub(crate) fn file(instances: &str) -> String {
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
         FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n\
         #1=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#2))REPRESENTATION_CONTEXT('',''));\n\
         #2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n#4=CARTESIAN_POINT('',(0.,0.,0.));\n\
         #5=DIRECTION('',(0.,0.,1.));\n#6=DIRECTION('',(1.,0.,0.));\n#7=AXIS2_PLACEMENT_3D('',#4,#5,#6);\n\
         #11=APPLICATION_CONTEXT('');\n#12=PRODUCT_CONTEXT('',#11,'');\n#13=PRODUCT('p','p','',(#12));\n\
         #14=PRODUCT_DEFINITION_FORMATION('','',#13);\n#15=PRODUCT_DEFINITION('','',#14,$);\n\
         #16=PRODUCT_DEFINITION_SHAPE('','',#15);\n{instances}ENDSEC;\nEND-ISO-10303-21;\n"
    )
}

/// References to `ids`, separated by commas.
fn links(ids: impl Iterator<Item = usize>) -> String {
    ids.map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}

/// `count` references to one instance.
fn again(id: usize, count: usize) -> String {
    links(std::iter::repeat_n(id, count))
}

/// The representation #92 of a surface model of the open shell of `faces`.
fn model_of(faces: &str) -> String {
    format!(
        "#90=OPEN_SHELL('',({faces}));\n#91=SHELL_BASED_SURFACE_MODEL('',(#90));\n\
         #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#91,#7),#1);\n#17=SHAPE_DEFINITION_REPRESENTATION(#16,#92);\n"
    )
}

/// A ball.
fn ball() -> String {
    "#81=SPHERICAL_SURFACE('',#7,1.);\n#80=ADVANCED_FACE('',(),#81,.T.);\n".to_owned() + &model_of("#80")
}

/// A plane face bounded by the oriented edges `uses`.
fn plane_face(uses: &str) -> String {
    format!(
        "#82=EDGE_LOOP('',({uses}));\n#83=FACE_OUTER_BOUND('',#82,.T.);\n#84=PLANE('',#7);\n\
         #85=ADVANCED_FACE('',(#83),#84,.T.);\n"
    ) + &model_of("#85")
}

/// Sets of sets of a tessellated triangle, `levels` deep, with ten references each.
pub(crate) fn tessellated_sets(levels: usize) -> String {
    let mut text = "#100=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)));\n\
        #101=TRIANGULATED_FACE('',#100,3,((0.,0.,1.)),$,(1,2,3),((1,2,3)));\n"
        .to_owned();
    for level in 0..levels {
        writeln!(text, "#{}=TESSELLATED_GEOMETRIC_SET('',({}));", 102 + level, again(101 + level, 10)).unwrap();
    }
    file(&(text + &format!("#900=TESSELLATED_SHAPE_REPRESENTATION('',(#{}),#1);\n", 101 + levels)))
}

/// An edge along a composite curve of composite curves, `levels` deep, with ten segments each.
pub(crate) fn composites(levels: usize) -> String {
    let mut text = "#100=CARTESIAN_POINT('',(1.,0.,0.));\n#101=CARTESIAN_POINT('',(0.,1.,0.));\n\
        #102=POLYLINE('',(#100,#101,#100));\n#103=VERTEX_POINT('',#100);\n"
        .to_owned();
    let mut curve = 102;
    for id in (110..).step_by(2).take(levels) {
        writeln!(text, "#{id}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{curve});").unwrap();
        writeln!(text, "#{}=COMPOSITE_CURVE('',({}),.U.);", id + 1, again(id, 10)).unwrap();
        curve = id + 1;
    }
    writeln!(text, "#200=EDGE_CURVE('',#103,#103,#{curve},.T.);\n#201=ORIENTED_EDGE('',*,*,#200,.T.);").unwrap();
    file(&(text + &plane_face("#201")))
}

/// A square whose loop lists the same use of its first edge `count` times.
pub(crate) fn repeated_use(count: usize) -> String {
    square(&again(106, count), "")
}

/// A square whose loop has `count` uses of its first edge.
pub(crate) fn repeated_edge(count: usize) -> String {
    let mut uses = String::new();
    (1000..1000 + count).for_each(|id| writeln!(uses, "#{id}=ORIENTED_EDGE('',*,*,#105,.T.);").unwrap());
    square(&links(1000..1000 + count), &uses)
}

/// A square whose loop begins with the uses `first` of its first edge, which `instances` define.
fn square(first: &str, instances: &str) -> String {
    let mut text = instances.to_owned();
    for (k, (x, y)) in [(0, 0), (9, 0), (9, 9), (0, 9)].into_iter().enumerate() {
        let (next, id) = ((k + 1) % 4, 100 + 10 * k);
        let (along, across) = [(1, 0), (0, 1), (-1, 0), (0, -1)][k];
        writeln!(text, "#{id}=CARTESIAN_POINT('',({x}.,{y}.,0.));\n#{}=VERTEX_POINT('',#{id});", id + 1).unwrap();
        writeln!(text, "#{}=DIRECTION('',({along}.,{across}.,0.));", id + 2).unwrap();
        writeln!(text, "#{}=VECTOR('',#{},1.);\n#{}=LINE('',#{id},#{0});", id + 3, id + 2, id + 4).unwrap();
        writeln!(text, "#{}=EDGE_CURVE('',#{},#{},#{},.T.);", id + 5, id + 1, 101 + 10 * next, id + 4).unwrap();
        writeln!(text, "#{}=ORIENTED_EDGE('',*,*,#{},.T.);", id + 6, id + 5).unwrap();
    }
    file(&(text + &plane_face(&format!("{first},#116,#126,#136"))))
}

/// An assembly of assemblies, `levels` deep, with ten occurrences each, of a ball with a long name.
pub(crate) fn named_assemblies(levels: usize, name: usize) -> String {
    let mut text = ball();
    let mut child = 15;
    for id in (100..).step_by(20).take(levels) {
        writeln!(text, "#{id}=PRODUCT_DEFINITION('','',#14,$);").unwrap();
        for use_of in id + 1..id + 11 {
            writeln!(text, "#{use_of}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#{id},#{child},$);").unwrap();
        }
        child = id;
    }
    file(&text).replace("PRODUCT('p','p'", &format!("PRODUCT('p','{}'", "n".repeat(name)))
}

/// A surface model that lists a shell `count` times, which lists a face `count` times.
pub(crate) fn repeated_shells(count: usize) -> String {
    let listed = [("('',(#80));", again(80, count)), ("('',(#90));", again(90, count))];
    listed.into_iter().fold(file(&ball()), |text, (once, often)| text.replacen(once, &format!("('',({often}));"), 1))
}

/// A ball in a unit of 1e306 metres.
pub(crate) fn huge_unit() -> String {
    let unit = "#2=(CONVERSION_BASED_UNIT('X',#8)LENGTH_UNIT()NAMED_UNIT(*));\n\
        #8=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E306),#9);\n#9=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));";
    file(&ball()).replace("#2=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));", unit)
}

/// A ball 10¹⁵ mm from the origin.
pub(crate) fn far_away() -> String {
    file(&ball()).replace("(0.,0.,0.)", "(1.E15,1.E15,1.E15)")
}

/// A representation that lists a geometric set `count` times, which lists what is not in the file `count` times.
pub(crate) fn missing_elements(count: usize) -> String {
    let (sets, missing) = (again(82, count), again(9, count));
    file(&format!(
        "#82=GEOMETRIC_SET('',({missing}));\n#84=SHAPE_REPRESENTATION('',({sets}),#1);\n\
         #17=SHAPE_DEFINITION_REPRESENTATION(#16,#84);\n"
    ))
}

/// A representation that maps a ball `count` times and belongs to `count` products.
pub(crate) fn shared_representation(count: usize) -> String {
    let mut text = ball() + "#100=REPRESENTATION_MAP(#7,#92);\n";
    (1000..1000 + count).for_each(|id| writeln!(text, "#{id}=MAPPED_ITEM('',#100,#7);").unwrap());
    writeln!(text, "#101=SHAPE_REPRESENTATION('',({}),#1);", links(1000..1000 + count)).unwrap();
    for id in (10_000..).step_by(3).take(count) {
        writeln!(text, "#{id}=PRODUCT_DEFINITION('','',#14,$);").unwrap();
        writeln!(text, "#{}=PRODUCT_DEFINITION_SHAPE('','',#{id});", id + 1).unwrap();
        writeln!(text, "#{}=SHAPE_DEFINITION_REPRESENTATION(#{},#101);", id + 2, id + 1).unwrap();
    }
    file(&text)
}

/// A loop of `edges` edges that share a polyline of `points` points.
pub(crate) fn shared_curve(points: usize, edges: usize) -> String {
    let mut text = String::new();
    for k in 0..points {
        writeln!(text, "#{}=CARTESIAN_POINT('',({}.,{k}.,0.));", 1000 + k, k % 2).unwrap();
    }
    let (last, first_edge) = (999 + points, 2000 + points);
    writeln!(text, "#100=POLYLINE('',({}));", links(1000..1000 + points)).unwrap();
    writeln!(text, "#101=VERTEX_POINT('',#1000);\n#102=VERTEX_POINT('',#{last});").unwrap();
    for id in (first_edge..).step_by(2).take(edges) {
        writeln!(text, "#{id}=EDGE_CURVE('',#101,#102,#100,.T.);\n#{}=ORIENTED_EDGE('',*,*,#{id},.T.);", id + 1)
            .unwrap();
    }
    file(&(text + &plane_face(&links((first_edge + 1..).step_by(2).take(edges)))))
}

/// `faces` faces of one spline surface of `side` by `side` points.
pub(crate) fn shared_surface(side: usize, faces: usize) -> String {
    let mut text = String::new();
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        writeln!(text, "#{}=CARTESIAN_POINT('',({i}.,{j}.,0.));", 1000 + i * side + j).unwrap();
    }
    let row = |i: usize| format!("({})", links(1000 + i * side..1000 + (i + 1) * side));
    let rows = (0..side).map(row).collect::<Vec<_>>().join(",");
    let once = ",1".repeat(side - 4);
    let knots = (0..side - 2).map(|k| format!("{k}.")).collect::<Vec<_>>().join(",");
    writeln!(
        text,
        "#100=B_SPLINE_SURFACE_WITH_KNOTS('',3,3,({rows}),.UNSPECIFIED.,.F.,.F.,.F.,(4{once},4),(4{once},4),({knots}),\
         ({knots}),.UNSPECIFIED.);"
    )
    .unwrap();
    (9000..9000 + faces).for_each(|id| writeln!(text, "#{id}=ADVANCED_FACE('',(),#100,.T.);").unwrap());
    file(&(text + &model_of(&links(9000..9000 + faces))))
}

/// A list of `count` numbers.
pub(crate) fn numbers(count: usize) -> String {
    file(&format!("#100=A(({}1));\n", "1,".repeat(count)))
}

/// `side` by `side` points, triangulated.
pub(crate) fn triangulation(side: usize) -> String {
    let grid = |side: usize| (0..side).flat_map(move |i| (0..side).map(move |j| (i, j)));
    let points = grid(side).map(|(i, j)| format!("({i}.,{j}.,{}.)", (i * j) % 7)).collect::<Vec<_>>().join(",");
    let corner = |(i, j): (usize, usize)| i * side + j + 1;
    let two = |at: (usize, usize)| {
        let [a, b] = [corner(at), corner((at.0 + 1, at.1))];
        format!("({a},{},{b}),({},{},{b})", a + 1, a + 1, b + 1)
    };
    let triangles = grid(side - 1).map(two).collect::<Vec<_>>().join(",");
    let count = side * side;
    file(&format!(
        "#100=COORDINATES_LIST('',{count},({points}));\n\
         #101=TRIANGULATED_FACE('',#100,{count},((0.,0.,1.)),$,(),({triangles}));\n\
         #102=TESSELLATED_SHELL('',(#101),$);\n#103=TESSELLATED_SHAPE_REPRESENTATION('',(#102),#1);\n"
    ))
}
