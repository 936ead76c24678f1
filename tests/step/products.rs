//! Product structure: assemblies, mapped items, units, colours, and entities without a product.

use crate::{assert_near, clean, model, placement, world};
use glam::DVec3;
use std::sync::Arc;
use trimtess::import::step::{StepError, StepOptions, read};
use trimtess::model::{Model, Severity};

/// A product definition #id (and id+1..id+4) named `name`, whose shape is representation `shape`.
pub(crate) fn product(id: u32, name: &str, shape: u32) -> String {
    let [formation, product, property, link] = [1, 2, 3, 4].map(|k| id + k);
    format!(
        "#{id}=PRODUCT_DEFINITION('','',#{formation},$);#{formation}=PRODUCT_DEFINITION_FORMATION('','',#{product});\
         #{product}=PRODUCT('{name}','{name}','',());\
         #{property}=PRODUCT_DEFINITION_SHAPE('','',#{id});\
         #{link}=SHAPE_DEFINITION_REPRESENTATION(#{property},#{shape});\n"
    )
}

/// An unbounded sphere of radius 1 as solid #id, with its shell, face and surface.
fn ball(id: u32) -> String {
    let [shell, face, surface] = [1, 2, 3].map(|k| id + k);
    format!(
        "#{id}=MANIFOLD_SOLID_BREP('',#{shell});#{shell}=CLOSED_SHELL('',(#{face}));\
         #{face}=ADVANCED_FACE('',(),#{surface},.T.);#{surface}=SPHERICAL_SURFACE('',#20,1.);\n"
    )
}

/// Occurrence #id of `child` in `parent` placed by relationship #id+3 between `first` and `second`.
fn occurrence(id: u32, [parent, child]: [u32; 2], [first, second]: [u32; 2], [from, to]: [u32; 2]) -> String {
    let [property, link, relation, motion] = [1, 2, 3, 4].map(|k| id + k);
    format!(
        "#{id}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('{id}','use {id}','',#{parent},#{child},$);\
         #{property}=PRODUCT_DEFINITION_SHAPE('','',#{id});\
         #{link}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{property});\
         #{relation}=(REPRESENTATION_RELATIONSHIP('','',#{first},#{second})\
         REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{motion})SHAPE_REPRESENTATION_RELATIONSHIP());\
         #{motion}=ITEM_DEFINED_TRANSFORMATION('','',#{from},#{to});\n"
    )
}

/// Two nested assemblies: the ball at (1,0,0), rotated by 90° about z, in "pair"; "pair" at (0,10,0) and (0,20,0) in
/// "all".
fn nested(swap: bool) -> String {
    let places = placement(30, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
        + &placement(34, [0.0, 10.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + &placement(38, [0.0, 20.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let shapes = "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);#51=SHAPE_REPRESENTATION('',(#20,#30),#1);\
                  #52=SHAPE_REPRESENTATION('',(#34,#38),#1);";
    let order = |child, parent| if swap { [parent, child] } else { [child, parent] };
    world()
        + &places
        + shapes
        + &ball(60)
        + &product(100, "ball", 50)
        + &product(110, "pair", 51)
        + &product(120, "all", 52)
        + &occurrence(200, [110, 100], order(50, 51), order(20, 30))
        + &occurrence(210, [120, 110], order(51, 52), order(20, 34))
        + &occurrence(220, [120, 110], order(51, 52), order(20, 38))
}

fn origins(model: &Model) -> Vec<DVec3> {
    model.instances.iter().map(|i| i.transform.translation).collect()
}

#[test]
fn nested_assemblies_share_their_part() {
    for swap in [false, true] {
        let model = model(&nested(swap));
        clean(&model);
        assert_eq!((model.parts.len(), model.parts[0].name.as_str()), (1, "ball"));
        assert_eq!(origins(&model), [DVec3::new(1.0, 10.0, 0.0), DVec3::new(1.0, 20.0, 0.0)], "swapped: {swap}");
        assert_near(model.instances[1].transform.transform_point3(DVec3::X * 2.0), DVec3::new(1.0, 22.0, 0.0));
        assert_eq!(&*model.instances[0].name, "use 200");
        let assemblies = |k: usize| model.instances[k].assembly.as_ref().expect("an assembly");
        let names = |k| assemblies(k).ancestors().map(|assembly| &*assembly.name).collect::<Vec<_>>();
        assert_eq!([names(0), names(1)], [["use 210", "all"], ["use 220", "all"]]);
        let parents = [0, 1].map(|k| assemblies(k).parent.as_ref().expect("an assembly"));
        assert!(Arc::ptr_eq(parents[0], parents[1]), "one assembly, one allocation");
    }
}

#[test]
fn each_representation_has_its_own_units() {
    // The ball's lengths are inches, the assemblies' millimetres.
    let text = nested(false).replace("(#20,#60),#1)", "(#20,#60),#3)");
    let model = model(&text);
    clean(&model);
    assert_eq!(model.millimetres_per_unit, 25.4);
    let trimtess::model::Surface::Sphere { radius, .. } = model.parts[0].faces[0].surface else { panic!("no ball") };
    assert_eq!(radius, 25.4);
    assert_eq!(origins(&model)[0], DVec3::new(1.0, 10.0, 0.0));
}

#[test]
fn a_geometry_representation_may_be_separate_from_the_products() {
    // The product's own representation is empty; another one in the same coordinates contains the solid.
    let text = world()
        + &ball(60)
        + "#50=SHAPE_REPRESENTATION('',(#20),#1);#51=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);\
           #52=SHAPE_REPRESENTATION_RELATIONSHIP('','',#50,#51);"
        + &product(100, "ball", 50);
    let model = model(&text);
    clean(&model);
    assert_eq!((model.parts.len(), model.parts[0].name.as_str(), model.instances.len()), (1, "ball", 1));
    assert_eq!(model.instances[0].transform, glam::DAffine3::IDENTITY);
}

#[test]
fn mapped_items_place_representations() {
    let text = world()
        + &ball(60)
        + &placement(30, [5.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#50=SHAPE_REPRESENTATION('ball',(#60),#1);#51=REPRESENTATION_MAP(#20,#50);#52=MAPPED_ITEM('left',#51,#20);\
           #53=MAPPED_ITEM('right',#51,#30);#54=SHAPE_REPRESENTATION('',(#52,#53),#1);"
        + &product(100, "two balls", 54);
    let model = model(&text);
    clean(&model);
    assert_eq!((model.parts.len(), model.parts[0].name.as_str()), (1, "ball"));
    assert_eq!(origins(&model), [DVec3::ZERO, DVec3::X * 5.0]);
    assert_eq!(&*model.instances[1].name, "right");
}

#[test]
fn a_mapping_operator_may_scale() {
    let text = world()
        + &ball(60)
        + "#30=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',$,$,#31,2.,$);#31=CARTESIAN_POINT('',(5.,0.,0.));\
           #50=SHAPE_REPRESENTATION('ball',(#60),#1);#51=REPRESENTATION_MAP(#20,#50);#52=MAPPED_ITEM('big',#51,#30);\
           #54=SHAPE_REPRESENTATION('',(#52),#1);"
        + &product(100, "big ball", 54);
    let model = model(&text);
    clean(&model);
    assert_near(model.instances[0].transform.transform_point3(DVec3::X), DVec3::X * 7.0);
}

#[test]
fn a_negative_scale_reflects() {
    let stated = "#214=ITEM_DEFINED_TRANSFORMATION('','',#20,#34)";
    // As OpenCASCADE 8 writes them: a reflection in the plane x = -2, and one in a point.
    for (axes, image) in
        [("#230,#231,#232,-1.,#233", DVec3::new(-5.0, 2.0, 3.0)), ("$,$,#232,-2.,$", DVec3::new(2.0, -4.0, -6.0))]
    {
        let operator = format!("#214=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',{axes})");
        let text = nested(false).replace(stated, &operator)
            + "#230=DIRECTION('',(1.,0.,0.));#231=DIRECTION('',(0.,-1.,0.));#232=CARTESIAN_POINT('',(4.,0.,0.));\
             #233=DIRECTION('',(0.,0.,-1.));";
        let model = model(&text);
        clean(&model);
        assert_eq!(model.instances.len(), 2);
        // The ball is at (1, 0, 0) in the reflected assembly, rotated by 90° about z.
        let placed = &model.instances[0].transform;
        assert_near(placed.transform_point3(DVec3::new(2.0, 0.0, 3.0)), image);
        assert!(placed.matrix3.determinant() < 0.0, "{placed}");
    }
}

#[test]
fn an_assembly_in_itself_ends() {
    let text = nested(false) + &occurrence(230, [100, 120], [52, 50], [34, 20]);
    let model = model(&text);
    assert_eq!(model.parts.len(), 1);
    assert!(!model.instances.is_empty() && model.instances.len() < 10);
    assert!(
        model
            .diagnostics
            .iter()
            .any(|d| { d.severity == Severity::Error && d.kind.code() == "step-assembly-cycle" && d.entity > 0 })
    );
}

#[test]
fn exploding_assemblies_stop_at_the_limit() {
    // Each of 40 assemblies uses the next one twice: 2^40 balls.
    let mut text = world() + &ball(60) + "#50=SHAPE_REPRESENTATION('',(#20,#60),#1);";
    for level in 0..40 {
        let id = 1000 + 10 * level;
        text += &product(id, "level", if level == 39 { 50 } else { 51 });
        if level < 39 {
            for copy in 0..2 {
                text += &format!(
                    "#{}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#{id},#{},$);",
                    5000 + 2 * level + copy,
                    id + 10
                );
            }
        }
    }
    let options = StepOptions::DEFAULT.with_max_instances(1000);
    let error = read(crate::file(&text).as_bytes(), &options).expect_err("2^40 balls");
    assert!(matches!(error, StepError::TooManyInstances { limit: 1000 }), "{error}");
    assert!(error.to_string().contains("more than 1000") && error.to_string().contains("max_instances"), "{error}");
}

#[test]
fn representations_without_shape_are_not_searched_for_bodies() {
    // No shape lists the solid. It is read as loose geometry, whose part has no name.
    let model = model(&(world() + &ball(60) + "#50=DEFINITIONAL_REPRESENTATION('parameters',(#60),#1);"));
    clean(&model);
    assert_eq!((model.parts.len(), model.parts[0].name.as_str()), (1, ""));
}

#[test]
fn relationships_without_an_occurrence_place_a_shape_once_per_transformation() {
    let moved = |id: u32, to: u32| {
        format!(
            "#{id}=(REPRESENTATION_RELATIONSHIP('','',#50,#51)\
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{})SHAPE_REPRESENTATION_RELATIONSHIP());\
             #{}=ITEM_DEFINED_TRANSFORMATION('','',#20,#{to});",
            id + 1,
            id + 1
        )
    };
    let text = world()
        + &placement(30, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + &placement(34, [2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#50=SHAPE_REPRESENTATION('ball',(#20,#60),#1);#51=SHAPE_REPRESENTATION('all',(#30,#34),#1);"
        + &ball(60)
        + &product(100, "ball", 50)
        + &product(110, "all", 51)
        + &moved(200, 30)
        + &moved(210, 34)
        + &moved(220, 30);
    let model = model(&text);
    clean(&model);
    assert_eq!(origins(&model), [DVec3::X, DVec3::X * 2.0]);
}

#[test]
fn an_occurrence_is_where_an_unnamed_relationship_of_the_pair_places_it() {
    // "all" has "pair" twice; nothing says which relationship places which of the two.
    for swap in [false, true] {
        let without = |text: String, id: u32| {
            text.replace(&format!("#{}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(", id + 2), &format!("#{}=NONE(", id + 2))
        };
        let model = model(&without(without(without(nested(swap), 200), 210), 220));
        clean(&model);
        assert_eq!(origins(&model), [DVec3::new(1.0, 10.0, 0.0), DVec3::new(1.0, 20.0, 0.0)], "swapped: {swap}");
        assert_eq!(&*model.instances[0].name, "use 200");
    }
}

#[test]
fn an_occurrence_whose_own_shape_maps_the_component_is_one_instance() {
    let maps = "#300=REPRESENTATION_MAP(#20,#50);#301=MAPPED_ITEM('',#300,#30);\
                #302=SHAPE_REPRESENTATION('',(#20,#301),#1);#303=SHAPE_DEFINITION_REPRESENTATION(#201,#302);";
    let (named, placed) = ("#202=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(", "#203=(REPRESENTATION_RELATIONSHIP(");
    let alone = nested(false).replace(named, "#202=NONE(").replace(placed, "#203=(NONE(");
    for text in [nested(false), alone] {
        let model = model(&(text + maps));
        clean(&model);
        assert_eq!(origins(&model), [DVec3::new(1.0, 10.0, 0.0), DVec3::new(1.0, 20.0, 0.0)]);
    }
    // What else it maps is no repeat: another ball in each pair.
    let more = maps.replace("#301),", "#301,#305),")
        + "#304=REPRESENTATION_MAP(#20,#306);#305=MAPPED_ITEM('',#304,#20);#306=SHAPE_REPRESENTATION('',(#70),#1);";
    let model = model(&(nested(false) + &more + &ball(70)));
    clean(&model);
    assert_eq!((model.parts.len(), model.instances.len()), (2, 4));
}

#[test]
fn entities_without_a_product_are_read_once() {
    // A solid in a representation; a solid and a face in none.
    let text = world()
        + &ball(60)
        + &ball(70)
        + "#80=ADVANCED_FACE('loose',(),#81,.T.);#81=SPHERICAL_SURFACE('',#20,9.);\
           #50=ADVANCED_BREP_SHAPE_REPRESENTATION('free',(#60),#1);";
    let model = model(&text);
    clean(&model);
    assert_eq!(model.parts.iter().map(|p| p.faces.len()).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(model.instances.len(), 2);
    assert_eq!(model.parts[0].name, "free");
}

/// A style #id that paints surfaces.
pub(crate) fn paint(id: u32, rgb: [f64; 3]) -> String {
    format!(
        "#{id}=PRESENTATION_STYLE_ASSIGNMENT((#{},#{}));#{}=SURFACE_STYLE_USAGE(.BOTH.,#{});\
         #{}=SURFACE_SIDE_STYLE('',(#{}));#{}=SURFACE_STYLE_FILL_AREA(#{});#{}=FILL_AREA_STYLE('',(#{}));\
         #{}=FILL_AREA_STYLE_COLOUR('',#{});#{}=COLOUR_RGB('',{:?},{:?},{:?});\
         #{}=CURVE_STYLE('',$,$,#{});#{}=DRAUGHTING_PRE_DEFINED_COLOUR('green');\n",
        id + 7,
        id + 1,
        id + 1,
        id + 2,
        id + 2,
        id + 3,
        id + 3,
        id + 4,
        id + 4,
        id + 5,
        id + 5,
        id + 6,
        id + 6,
        rgb[0],
        rgb[1],
        rgb[2],
        id + 7,
        id + 8,
        id + 8
    )
}

#[test]
fn colours_come_from_the_face_then_its_shell_then_its_solid() {
    let solids = world()
        + &ball(60)
        + &ball(70)
        + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60,#70),#1);"
        + &paint(300, [1.0, 0.0, 0.5])
        + &paint(310, [0.0, 0.0, 1.0]);
    let styled = "#330=STYLED_ITEM('',(#300),#60);#331=STYLED_ITEM('',(#310),#72);#332=STYLED_ITEM('',(#300),#71);";
    let text = solids.clone() + styled;
    let part = &model(&text).parts[0];
    assert_eq!(part.faces[0].colour, Some([1.0, 0.0, 0.5, 1.0]));
    assert_eq!(part.faces[1].colour, Some([0.0, 0.0, 1.0, 1.0]));
    let over = solids + "#330=STYLED_ITEM('',(#300),#62);#331=OVER_RIDING_STYLED_ITEM('',(#310),#62,#330);";
    assert_eq!(model(&over).parts[0].faces[0].colour, Some([0.0, 0.0, 1.0, 1.0]));
}

#[test]
fn hidden_solids_are_read_with_a_note() {
    for hidden in [
        "#332=INVISIBILITY((#330,#331,#330));",
        "#332=INVISIBILITY((#333));#333=PRESENTATION_LAYER_ASSIGNMENT('','',(#330,#60));",
        "#332=INVISIBILITY((#50));",
        "#332=INVISIBILITY((#333));#333=STYLED_ITEM('',(#300),#334);#334=MAPPED_ITEM('',#335,#20);\
         #335=REPRESENTATION_MAP(#20,#50);",
    ] {
        let text = world()
            + &ball(60)
            + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);"
            + &paint(300, [0.0, 0.0, 1.0])
            + "#330=STYLED_ITEM('',(#300),#60);#331=STYLED_ITEM('',(#300),#20);"
            + hidden;
        let model = model(&text);
        let told: Vec<_> = model.diagnostics.iter().map(|d| (d.severity, d.kind.to_string())).collect();
        let note = "1 bodies, shells or faces are hidden in the file; they are read".to_owned();
        assert_eq!((model.parts.len(), told), (1, vec![(Severity::Note, note)]), "{hidden}");
    }
}

#[test]
fn a_face_with_a_colour_for_each_side_has_that_of_its_positive_side() {
    let (blue, red) = (paint(300, [0.0, 0.0, 1.0]), paint(310, [1.0, 0.0, 0.0]));
    for (front, back, colour) in [("POSITIVE", "NEGATIVE", 0), ("NEGATIVE", "POSITIVE", 1), ("NEGATIVE", "NEGATIVE", 0)]
    {
        let text = world()
            + &ball(60)
            + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);"
            + &blue.replace(".BOTH.", &format!(".{front}."))
            + &red.replace(".BOTH.", &format!(".{back}."))
            + "#330=STYLED_ITEM('',(#331),#60);#331=PRESENTATION_STYLE_ASSIGNMENT((#301,#311));";
        let expected = [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0]][colour];
        assert_eq!(model(&text).parts[0].faces[0].colour, Some(expected), "{front} {back}");
    }
}

#[test]
fn transparency_and_named_colours_are_read() {
    let text = world()
        + &ball(60)
        + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);#300=PRESENTATION_STYLE_ASSIGNMENT((#301));\
           #301=SURFACE_STYLE_USAGE(.BOTH.,#302);#302=SURFACE_SIDE_STYLE('',(#303));\
           #303=SURFACE_STYLE_RENDERING_WITH_PROPERTIES($,#304,(#305));#304=DRAUGHTING_PRE_DEFINED_COLOUR('yellow');\
           #305=SURFACE_STYLE_TRANSPARENT(0.75);#330=STYLED_ITEM('',(#300),#50);";
    assert_eq!(model(&text).parts[0].colour, Some([1.0, 1.0, 0.0, 0.25]));
}

#[test]
fn an_occurrence_may_have_its_own_colour() {
    let text = nested(false)
        + &paint(300, [0.0, 1.0, 1.0])
        + "#330=STYLED_ITEM('',(#300),#60);#331=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#300),#60,#330,(#213));";
    let model = model(&text);
    assert_eq!(model.instances[0].colour, Some([0.0, 1.0, 1.0, 1.0]));
    assert_eq!(model.instances[1].colour, None);
}

#[test]
fn a_style_may_be_for_the_shape_of_one_occurrence() {
    let context = "#340=SHAPE_REPRESENTATION('',(#20),#1);#341=SHAPE_DEFINITION_REPRESENTATION(#211,#340);";
    let paint = paint(300, [0.0, 1.0, 1.0]).replace("PRESENTATION_STYLE_ASSIGNMENT(", "PRESENTATION_STYLE_BY_CONTEXT(");
    let paint = paint.replacen(");", ",#340);", 1);
    for styled in ["#330=STYLED_ITEM('',(#300),#60);", "#330=OVER_RIDING_STYLED_ITEM('',(#300),#60,#329);"] {
        let model = model(&(nested(false) + &paint + context + styled));
        clean(&model);
        let colours: Vec<_> = model.instances.iter().map(|instance| instance.colour).collect();
        assert_eq!((colours, model.parts[0].colour), (vec![Some([0.0, 1.0, 1.0, 1.0]), None], None), "{styled}");
    }
}

#[test]
fn an_occurrence_without_a_transformation_is_where_its_assembly_maps_it() {
    let place = placement(30, [5.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let shapes = "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);#51=REPRESENTATION_MAP(#20,#50);\
                  #52=MAPPED_ITEM('',#51,#30);#54=SHAPE_REPRESENTATION('',(#52),#1);\
                  #200=NEXT_ASSEMBLY_USAGE_OCCURRENCE('1','use','',#110,#100,$);";
    let text = world() + &place + shapes + &ball(60) + &product(100, "ball", 50) + &product(110, "all", 54);
    let once = model(&text);
    clean(&once);
    assert_eq!(origins(&once), [DVec3::new(5.0, 0.0, 0.0)]);
    // One that it does not map is not lost.
    let twice = model(&(text + "#201=NEXT_ASSEMBLY_USAGE_OCCURRENCE('2','use','',#110,#100,$);"));
    let told: Vec<_> = twice.diagnostics.iter().map(|d| (d.entity, d.kind.code())).collect();
    assert_eq!((twice.instances.len(), told), (2, vec![(201, "step-occurrence-at-origin")]));
}

#[test]
fn items_that_cannot_be_placed_are_left_out_with_an_error_and_appear_nowhere() {
    let scaled = |scale: &str| format!("#30=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,$,#21,{scale},$);");
    let mapped = "#50=SHAPE_REPRESENTATION('ball',(#60),#1);#51=REPRESENTATION_MAP(#20,#50);\
                  #52=MAPPED_ITEM('',#51,#30);\
                  #54=SHAPE_REPRESENTATION('',(#52),#1);";
    let replica = "#52=SOLID_REPLICA('',#60,#30);#54=SHAPE_REPRESENTATION('',(#52),#1);";
    for (text, entity) in [
        (mapped.to_owned() + &scaled("0."), 52),
        (mapped.to_owned() + &scaled("1.E200"), 52),
        (mapped.to_owned(), 52),
        (mapped.replace("(#20,#50)", "(#20,#99)") + &scaled("1."), 52),
        (replica.to_owned() + &scaled("0."), 52),
        (replica.to_owned() + &scaled("-1.E-200"), 52),
        (replica.replace("#60,#30", "#99,#30") + &scaled("1."), 52),
        (replica.replace("#60,#30", "#52,#30") + &scaled("1."), 52),
    ] {
        let model = model(&(world() + &ball(60) + &text + &product(100, "all", 54)));
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning).collect();
        assert!(
            told.iter().all(|d| d.severity == Severity::Error && d.kind.code() != "step-no-faces"),
            "{text}: {told:?}"
        );
        assert!(told.iter().any(|d| d.entity == entity), "{text}: {told:?}");
        // A solid without another owner is still read by itself, unless it is the one to be placed.
        let free = text.contains("#99") || text.contains("#52,#30,") || text.contains("#52,#30)");
        assert_eq!(model.instances.is_empty(), !free || text.contains("#60,#30"), "{text}: {told:?}");
    }
    // A good placement next to a bad one remains.
    let both = mapped.replace("(#52)", "(#52,#53)") + &scaled("0.") + "#53=MAPPED_ITEM('',#51,#20);";
    let model = model(&(world() + &ball(60) + &both + &product(100, "all", 54)));
    assert_eq!((model.instances.len(), model.parts[0].faces.len()), (1, 1), "{:?}", model.diagnostics);
}

#[test]
fn an_occurrence_with_a_bad_transformation_is_left_out() {
    let bad = nested(false)
        .replace("#214=ITEM_DEFINED_TRANSFORMATION('','',#20,#34)", "#214=ITEM_DEFINED_TRANSFORMATION('','',#20,#99)");
    let model = model(&bad);
    let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning).collect();
    assert!(told.len() == 1 && told[0].severity == Severity::Error && told[0].entity == 210, "{told:?}");
    assert_eq!(told[0].place, Some(DVec3::ZERO), "a point of the unplaced item");
    assert_eq!(origins(&model), [DVec3::new(1.0, 20.0, 0.0)]);
}

#[test]
fn replicas_may_depend_on_many_others() {
    let mut text =
        world() + &placement(30, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]) + "#60=SPHERE('',1.,#21);";
    text += "#40=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,$,#31,1.,$);";
    for id in 61..=110 {
        text += &format!("#{id}=SOLID_REPLICA('',#{},#40);", id - 1);
    }
    let model = model(&(text + "#54=SHAPE_REPRESENTATION('',(#110),#1);"));
    clean(&model);
    assert_eq!(origins(&model), [DVec3::X * 50.0]);
}
