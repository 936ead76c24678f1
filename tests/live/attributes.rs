//! Attributes of a session's parts and instances, as the device draws them: pictures of a model that states the same.

use super::{SIZE, picture, renderer};
use glam::{DAffine3, DVec3};
use std::sync::Arc;
use trimtess::control::Alone;
use trimtess::frame::Attributes;
use trimtess::model::{Colour, Instance, InstanceId, Model, PartId, shapes};
use trimtess::out::wgpu::{ColourBy, Image, LiveScene, RenderOptions, Renderer};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};
use trimtess::view::{Camera, Projection, View};

const RED: Colour = [0.9, 0.1, 0.1, 1.0];
const BLUE: Colour = [0.1, 0.2, 0.9, 1.0];

/// A washer, and a torus twice; the first torus is blue.
fn model() -> Model {
    let part = |name: &str| shapes::by_name(name).unwrap().parts.swap_remove(0);
    let place = |(k, part): (usize, u32)| Instance {
        colour: (k == 1).then_some(BLUE),
        ..Instance::new(PartId(part), DAffine3::from_translation(DVec3::X * 45.0 * k as f64))
    };
    let instances = [0, 1, 1].into_iter().enumerate().map(place).collect();
    Model { parts: ["washer", "torus"].map(part).into(), instances, ..Model::default() }
}

fn view() -> View {
    let (eye, target) = (DVec3::new(20.0, -170.0, 90.0), DVec3::X * 45.0);
    let camera = Camera::looking_at(eye, target, DVec3::Z, Projection::Perspective { fov_y: 0.7, near: 1.0 });
    View { camera, size: SIZE, deviation_px: 0.5, size_px: None, angle: 0.5 }
}

fn start(model: Model) -> Session {
    let prepared = prepare(model, &PrepareOptions::DEFAULT).unwrap();
    Session::start_on(Arc::new(Alone), Arc::new(prepared), &SessionOptions::DEFAULT)
}

fn looks() -> RenderOptions {
    RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(view().camera)).with_edges(true)
}

/// The picture of a session's next frame, and how many bytes of tiles it has sent.
fn shown(renderer: &Renderer, session: &mut Session, live: &mut LiveScene) -> (Image, u64) {
    let before = session.view(&[view()], live).unwrap();
    let sent = if before.tiles > 0 { live.uploaded() } else { 0 };
    (picture(renderer, live, &looks()), sent)
}

/// The picture of a model that states the colours, and lacks what is hidden.
fn stated(renderer: &Renderer, change: impl Fn(&mut Model)) -> Image {
    let mut model = model();
    change(&mut model);
    let mut live = renderer.live();
    shown(renderer, &mut start(model), &mut live).0
}

#[test]
fn attributes_are_drawn_as_if_the_model_stated_them() {
    let Some(renderer) = renderer() else { return };
    let (mut session, mut live) = (start(model()), renderer.live());
    let (plain, sent) = shown(renderer, &mut session, &mut live);
    assert!(sent > 0 && plain == stated(renderer, |_| {}));
    let [first, second] = [0, 1].map(|row| session.instance_key(row).unwrap());
    let painted = |colour| Attributes::DEFAULT.with_colour(Some(colour));
    session.set_part(PartId(1), &painted(RED)).unwrap();
    session.set_instance(first, &painted(BLUE)).unwrap();
    let (image, sent) = shown(renderer, &mut session, &mut live);
    let expected = stated(renderer, |model| {
        model.instances.iter_mut().zip([BLUE, RED, RED]).for_each(|(of, colour)| of.colour = Some(colour));
    });
    assert!(image == expected && image != plain && sent == 0, "colours: {sent} bytes of tiles");
    // Edges go, too, and so they do where everything is drawn that no view culls.
    session.set_instance(second, &Attributes::DEFAULT.with_visible(false)).unwrap();
    let (image, sent) = shown(renderer, &mut session, &mut live);
    let lacking = |model: &mut Model| {
        model.instances.iter_mut().zip([BLUE, RED, RED]).for_each(|(of, colour)| of.colour = Some(colour));
        model.instances.remove(1);
    };
    assert!(image == stated(renderer, lacking) && sent == 0, "hidden: {sent} bytes of tiles");
    assert!(renderer.picture(&mut live, 9, &looks()).unwrap().0 == image, "a view that no frame has");
    live.set_visible(InstanceId(1), true);
    assert!(picture(renderer, &mut live, &looks()) == image, "the scene hides it");
    // As it was.
    session.set_part(PartId(1), &Attributes::DEFAULT).unwrap();
    for key in [first, second] {
        session.set_instance(key, &Attributes::DEFAULT).unwrap();
    }
    let (image, sent) = shown(renderer, &mut session, &mut live);
    assert!(image == plain && sent == 0, "{sent} bytes of tiles");
    // Palettes go before attributes.
    let by_part = looks().with_colour_by(ColourBy::Part);
    let palette = picture(renderer, &mut live, &by_part);
    session.set_part(PartId(1), &painted(RED)).unwrap();
    session.view(&[view()], &mut live).unwrap();
    assert!(picture(renderer, &mut live, &by_part) == palette);
}
