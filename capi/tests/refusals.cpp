// Bad input through C, one case after the other: each returns a status with words, and nothing changes.
#include <trimtess.hpp>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <thread>

namespace {

int cases = 0;

void refused(int line, tt_status status, tt_status wanted, const char *words) {
    cases++;
    const char *told = tt_last_error();
    if (status == wanted && std::strstr(told, words)) return;
    std::fprintf(stderr, "line %d: status %d, \"%s\"; expected %d, \"%s\"\n", line, status, told, wanted, words);
    std::exit(1);
}
void holds(int line, bool condition) {
    cases++;
    if (condition) return;
    std::fprintf(stderr, "line %d does not hold\n", line);
    std::exit(1);
}
#define REFUSED(call, wanted, words) refused(__LINE__, call, wanted, words)
#define HOLDS(condition) holds(__LINE__, condition)

const double NONE = std::nan("");

template <class Call> tt_status thrown(int line, Call call) {
    try {
        call();
    } catch (const trimtess::Error &error) {
        cases++;
        return error.status();
    }
    holds(line, false);
    return TT_OK;
}

tt_view view_of(tt_prepared prepared) {
    auto view = trimtess::sized<tt_view>();
    view.width_px = 640, view.height_px = 480;
    trimtess::check(tt_view_along_path(prepared, "orbit", 0, 8, &view));
    return view;
}

trimtess::Sink all_tiles() {
    trimtess::Sink sink;
    sink.tile = [](const tt_tile &) {};
    return sink;
}

void handles() {
    tt_model model{};
    REFUSED(tt_model_shape("box", nullptr), TT_ERROR_ARGUMENT, "model is null");
    REFUSED(tt_model_shape(nullptr, &model), TT_ERROR_ARGUMENT, "name is null");
    REFUSED(tt_model_shape("\xff", &model), TT_ERROR_ARGUMENT, "name is not UTF-8 after 0 bytes");
    REFUSED(tt_model_shape("kettle", &model), TT_ERROR_ARGUMENT, "no shape \"kettle\"");
    HOLDS(model.id == 0);
    HOLDS(tt_model_shape("box", &model) == TT_OK);
    HOLDS(tt_live_handles() == 1);
    tt_model_info info{};
    REFUSED(tt_model_get_info(model, &info), TT_ERROR_ARGUMENT, "info.size is 0; the struct of this version has 40");
    REFUSED(tt_model_get_info(model, nullptr), TT_ERROR_ARGUMENT, "info is null");
    info.size = sizeof info;
    REFUSED(tt_model_get_info({}, &info), TT_ERROR_HANDLE, "the model's handle is null");
    REFUSED(tt_model_get_info({12345}, &info), TT_ERROR_HANDLE, "the model's handle was freed, or is none");
    tt_prepared prepared{};
    REFUSED(tt_prepare({}, nullptr, {}, &prepared), TT_ERROR_HANDLE, "null");
    HOLDS(tt_prepare(model, nullptr, {}, &prepared) == TT_OK);
    tt_prepare_options like{};
    like.size = sizeof like, like.like.id = model.id;
    tt_prepared again{};
    REFUSED(tt_prepare(model, &like, {}, &again), TT_ERROR_HANDLE, "is that of a model");
    like.like = prepared;
    HOLDS(tt_prepare(model, &like, {}, &again) == TT_OK && tt_prepared_free(again) == TT_OK);
    REFUSED(tt_session_update({}, prepared), TT_ERROR_HANDLE, "the session's handle is null");
    REFUSED(tt_session_update({}, {}), TT_ERROR_HANDLE, "the prepared model's handle is null");
    REFUSED(tt_model_get_info({prepared.id}, &info), TT_ERROR_HANDLE, "is that of a prepared model");
    HOLDS(tt_model_free(model) == TT_OK);
    REFUSED(tt_model_free(model), TT_ERROR_HANDLE, "was freed");
    REFUSED(tt_prepare(model, nullptr, {}, &prepared), TT_ERROR_HANDLE, "was freed");
    HOLDS(tt_model_free({}) == TT_OK);
    unsigned char bytes[sizeof(tt_model_info) + 8] = {};
    auto *askew = reinterpret_cast<tt_prepared_info *>(bytes + 1);
    REFUSED(tt_prepared_get_info(prepared, askew), TT_ERROR_ARGUMENT, "info is not a multiple of 8");
    HOLDS(tt_prepared_free(prepared) == TT_OK);
    REFUSED(tt_job_run({99}), TT_ERROR_HANDLE, "job's handle was freed");
    REFUSED(tt_control_cancel({}), TT_ERROR_HANDLE, "control's handle is null");
}

void structs() {
    const auto model = trimtess::Model::shape("washer");
    const trimtess::Prepared prepared(model);
    tt_mesh mesh{};
    auto tolerance = trimtess::sized<tt_tolerance>();
    const auto made = [&] { return tt_tessellate(prepared.get(), &tolerance, nullptr, {}, &mesh); };
    REFUSED(made(), TT_ERROR_ARGUMENT, "one of tolerance.chord and chord_rel must be above 0");
    tolerance.chord = NONE;
    REFUSED(made(), TT_ERROR_ARGUMENT, "tolerance.chord is NaN");
    tolerance.chord = -1;
    REFUSED(made(), TT_ERROR_ARGUMENT, "tolerance.chord is -1");
    tolerance.chord = INFINITY;
    REFUSED(made(), TT_ERROR_ARGUMENT, "tolerance.chord is inf");
    tolerance.chord = 0.1, tolerance.angle = NONE;
    REFUSED(made(), TT_ERROR_ARGUMENT, "tolerance.angle is NaN");
    tolerance.angle = 0, tolerance.max_edge = INFINITY;
    REFUSED(made(), TT_ERROR_ARGUMENT, "tolerance.max_edge is inf");
    tolerance.max_edge = 0, tolerance.max_triangles = 3;
    REFUSED(made(), TT_ERROR_LIMIT, "the limit is 3");
    tolerance.coarsen = 1;
    HOLDS(made() == TT_OK && tt_mesh_free(mesh) == TT_OK);
    tolerance = trimtess::sized<tt_tolerance>(), tolerance.chord = 1e-30;
    REFUSED(made(), TT_ERROR_LIMIT, "too small for the model");
    // A later version of the struct, without and with a value in what is new.
    struct Later {
        tt_tolerance known;
        double more;
    } later{};
    later.known.size = sizeof later, later.known.chord = 0.1;
    HOLDS(tt_tessellate(prepared.get(), &later.known, nullptr, {}, &mesh) == TT_OK && tt_mesh_free(mesh) == TT_OK);
    later.more = 1;
    REFUSED(tt_tessellate(prepared.get(), &later.known, nullptr, {}, &mesh), TT_ERROR_ARGUMENT, "all known here");
    char text[4] = "abc";
    std::size_t length = 0;
    HOLDS(tt_model_get_name(model.get(), text, sizeof text, &length) == TT_OK);
    HOLDS(length == 6 && !std::strcmp(text, "was"));
    REFUSED(tt_model_get_name(model.get(), nullptr, 5, &length), TT_ERROR_ARGUMENT, "text is null");
    REFUSED(tt_model_get_part_name(model.get(), 1, text, 4, nullptr), TT_ERROR_ARGUMENT, "no part 1; there are 1");
    auto options = trimtess::sized<tt_read_options>();
    options.threads = 100000;
    tt_model read{};
    REFUSED(tt_read_memory("x", 1, nullptr, &options, {}, &read), TT_ERROR_ARGUMENT, "100000 threads");
    const trimtess::Loops loops(trimtess::Jobs{2, {}, {}});
    options.threads = 2, options.jobs = loops.get();
    REFUSED(tt_read_memory("x", 1, nullptr, &options, {}, &read), TT_ERROR_ARGUMENT, "threads is 2, and there are jobs");
    REFUSED(tt_read_memory(nullptr, 1, nullptr, nullptr, {}, &read), TT_ERROR_ARGUMENT, "bytes is null");
    REFUSED(tt_read_memory("solid x", 7, nullptr, nullptr, {}, &read), TT_ERROR_READ, "not a STEP file");
    REFUSED(tt_read_file("no/such/file.step", nullptr, {}, &read), TT_ERROR_READ, "cannot read no/such/file.step");
    options = trimtess::sized<tt_read_options>(), options.fit_tolerance = INFINITY;
    REFUSED(tt_read_memory("x", 1, nullptr, &options, {}, &read), TT_ERROR_ARGUMENT, "options.fit_tolerance is inf; it");
    options = trimtess::sized<tt_read_options>(), options.max_bytes = 3;
    REFUSED(tt_read_file(std::getenv("SEQUENCES_FILE"), &options, {}, &read), TT_ERROR_LIMIT, "the limit is 3");
}

void views_and_sessions() {
    const trimtess::Prepared prepared(trimtess::Model::shape("pair"));
    trimtess::Session session(prepared);
    auto view = view_of(prepared.get());
    view.eye[1] = NONE;
    REFUSED(tt_session_begin(session.get(), &view, 1), TT_ERROR_ARGUMENT, "view 0: the camera is at");
    view = view_of(prepared.get()), view.deviation_px = -1;
    REFUSED(tt_session_begin(session.get(), &view, 1), TT_ERROR_ARGUMENT, "views[0].deviation_px is -1");
    // A camera at (0, 0, 50) that looks down; the middle of its picture is a tenth of the picture to the left of the axis.
    double matrix[16] = {1, 0, 0, 0, 0, 2, 0, 0, -0.2, 0, 0, -1, 10, 0, 0, 50};
    const auto from_matrix = [&](std::uint32_t width) { return tt_view_from_matrix(matrix, width, 100, &view); };
    view = view_of(prepared.get()), view.deviation_px = 3;
    HOLDS(from_matrix(200) == TT_OK && tt_session_begin(session.get(), &view, 1) == TT_OK);
    HOLDS(view.width_px == 248 && view.height_px == 100 && view.deviation_px == 3 && view.near == 0);
    HOLDS(std::abs(view.eye[0]) < 1e-12 && std::abs(view.eye[2] - 50) < 1e-12 && std::abs(view.forward[2] + 1) < 1e-12);
    HOLDS(std::abs(view.fov_y - 2 * std::atan(0.5)) < 1e-12 && view.orthographic == 0);
    REFUSED(from_matrix(100), TT_ERROR_ARGUMENT, "differs from that of a camera with square pixels");
    REFUSED(from_matrix(0), TT_ERROR_ARGUMENT, "the picture has 0 x 100 pixels");
    REFUSED(tt_view_from_matrix(nullptr, 1, 1, &view), TT_ERROR_ARGUMENT, "matrix is null");
    matrix[3] = NONE;
    REFUSED(from_matrix(200), TT_ERROR_ARGUMENT, "differs from that of a camera");
    for (double tt_view::*number : {&tt_view::deviation_px, &tt_view::size_px, &tt_view::angle}) {
        view = view_of(prepared.get()), view.*number = INFINITY;
        REFUSED(tt_session_begin(session.get(), &view, 1), TT_ERROR_ARGUMENT, "is inf; it must be finite");
    }
    tt_view two[2] = {view_of(prepared.get()), view_of(prepared.get())};
    two[1].size = 12;
    REFUSED(tt_session_begin(session.get(), two, 2), TT_ERROR_ARGUMENT, "views[1].size is 12");
    REFUSED(tt_session_finish_within(session.get(), NONE, nullptr, nullptr), TT_ERROR_ARGUMENT, "seconds is NaN");
    REFUSED(tt_session_finish(session.get(), nullptr, nullptr), TT_ERROR_ARGUMENT, "sink is null");
    auto sink = trimtess::sized<tt_sink>();
    REFUSED(tt_session_finish(session.get(), &sink, nullptr), TT_ERROR_ARGUMENT, "sink.tile must be a function");
    auto layout = trimtess::sized<tt_layout>();
    std::uint32_t stride = 0;
    layout.reserved = 1;
    REFUSED(tt_layout_get_stride(&layout, &stride), TT_ERROR_ARGUMENT, "layout.reserved is 1; it must be 0");
    layout.reserved = 0, layout.position = 9;
    REFUSED(tt_layout_get_stride(&layout, &stride), TT_ERROR_ARGUMENT, "no format of positions 9");
    auto placement = trimtess::sized<tt_placement>();
    placement.part = 2;
    const auto added = [&] { return tt_session_add_instance(session.get(), &placement, nullptr); };
    REFUSED(added(), TT_ERROR_ARGUMENT, "no part 2; the model has 2");
    placement.part = 0, placement.transform[0] = 1;
    REFUSED(added(), TT_ERROR_ARGUMENT, "not a rigid motion");
    std::uint64_t key = 0;
    REFUSED(tt_session_get_instance_key(session.get(), 7, &key), TT_ERROR_ARGUMENT, "no instance 7; there are 3");
    const auto gone = session.add_instance(trimtess::sized<tt_placement>());
    session.remove_instance(gone);
    std::uint32_t index = 0;
    REFUSED(tt_session_find_instance(session.get(), gone, &index), TT_ERROR_ARGUMENT, "removed, or never added");
    REFUSED(tt_session_remove_instance(session.get(), gone), TT_ERROR_ARGUMENT, "removed, or never added");
    REFUSED(tt_session_remove_instance(session.get(), 0), TT_ERROR_ARGUMENT, "removed, or never added");
    const std::uint64_t pair[2] = {session.instance_key(0), gone};
    REFUSED(tt_session_remove_instances(session.get(), pair, 2), TT_ERROR_ARGUMENT, "removed, or never added");
    HOLDS(session.find_instance(pair[0]) == 0);
    double transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, NONE, 0, 0, 0};
    key = session.instance_key(2);
    HOLDS(session.find_instance(key) == 2);
    REFUSED(tt_session_move_instance(session.get(), key, transform), TT_ERROR_ARGUMENT, "must be finite");
    auto pool = trimtess::sized<tt_jobs>();
    tt_session other{};
    REFUSED(tt_session_new(prepared.get(), nullptr, &pool, &other), TT_ERROR_ARGUMENT, "jobs.spawn must be a function");
    const trimtess::Loops loops(trimtess::Jobs{2, {}, {}});
    auto options = trimtess::sized<tt_session_options>();
    options.workers = 5000;
    REFUSED(tt_session_new(prepared.get(), &options, nullptr, &other), TT_ERROR_ARGUMENT, "workers is 5000");
    options.workers = 0, options.budget = INFINITY;
    REFUSED(tt_session_new(prepared.get(), &options, nullptr, &other), TT_ERROR_ARGUMENT, "options.budget is inf; it");
    options.budget = 0, options.threads = 2;
    REFUSED(tt_session_new(prepared.get(), &options, loops.get(), &other), TT_ERROR_ARGUMENT, "threads is 2, and there are jobs");
    const trimtess::Loops wide(trimtess::Jobs{1025, {}, {}});
    REFUSED(tt_session_new(prepared.get(), nullptr, wide.get(), &other), TT_ERROR_ARGUMENT, "1025 threads; there may be 1024");
    // It still works.
    HOLDS(session.view({view_of(prepared.get())}, all_tiles()).triangles > 0);
}

void limits() {
    const trimtess::Prepared prepared(trimtess::Model::shape("pair"));
    const auto view = view_of(prepared.get());
    auto tolerance = trimtess::sized<tt_tolerance>();
    tolerance.chord_rel = 1e-4;
    trimtess::Session session(prepared);
    auto report = session.view({view}, all_tiles());
    HOLDS(report.coarsened == 0 && report.needed == 0 && report.reserved == 0);
    auto options = trimtess::sized<tt_session_options>();
    options.max_triangles = 100;
    trimtess::Session limited(prepared, &options);
    // The second frame changes nothing, and is as coarse.
    for (const bool changes : {true, false}) {
        report = limited.view({view}, all_tiles());
        HOLDS(report.coarsened == 1 && report.needed > 100 && (report.triangles > 0) == changes);
    }
    report = limited.tessellate(tolerance, all_tiles());
    HOLDS(report.coarsened == 0 && report.needed == 0);
    tolerance.max_triangles = 100, tolerance.coarsen = 1;
    report = session.tessellate(tolerance, all_tiles());
    HOLDS(report.coarsened == 1 && report.needed > 100);
}

void attributes() {
    const trimtess::Prepared prepared(trimtess::Model::shape("pair"));
    trimtess::Session session(prepared);
    const auto key = session.instance_key(0);
    auto of = trimtess::sized<tt_attributes>();
    const auto part = [&] { return tt_session_set_part(session.get(), 0, &of); };
    const auto instance = [&] { return tt_session_set_instance(session.get(), key, &of); };
    of.size = 4;
    REFUSED(part(), TT_ERROR_ARGUMENT, "attributes.size is 4");
    of.size = sizeof of, of.reserved = 1;
    REFUSED(instance(), TT_ERROR_ARGUMENT, "attributes.reserved is 1; it must be 0");
    of.reserved = 0, of.tolerance_scale = -1;
    REFUSED(part(), TT_ERROR_ARGUMENT, "attributes.tolerance_scale is -1; it must be 0 or more");
    of.tolerance_scale = NONE;
    REFUSED(instance(), TT_ERROR_ARGUMENT, "attributes.tolerance_scale is NaN");
    of.tolerance_scale = std::numeric_limits<double>::infinity();
    REFUSED(part(), TT_ERROR_ARGUMENT, "tolerance_scale is inf; it must be finite and above 0");
    of.tolerance_scale = 0.5, of.priority = -std::numeric_limits<double>::infinity();
    REFUSED(instance(), TT_ERROR_ARGUMENT, "attributes.priority is -inf");
    of.priority = 3, of.colour[3] = 2;
    HOLDS(part() == TT_OK); // Without `has_colour`, the numbers are not read.
    of.has_colour = 1;
    REFUSED(part(), TT_ERROR_ARGUMENT, "its numbers must be from 0 to 1");
    of.colour[3] = 1, of.hidden = 1;
    REFUSED(tt_session_set_part(session.get(), 2, &of), TT_ERROR_ARGUMENT, "no part 2; the model has 2");
    REFUSED(tt_session_get_part_attributes(session.get(), 2, &of), TT_ERROR_ARGUMENT, "no part 2; the model has 2");
    REFUSED(tt_session_set_instance(session.get(), 7, &of), TT_ERROR_ARGUMENT, "removed, or never added");
    REFUSED(tt_session_get_instance_attributes(session.get(), 7, &of), TT_ERROR_ARGUMENT, "removed, or never added");
    REFUSED(tt_session_get_instance_attributes(session.get(), key, nullptr), TT_ERROR_ARGUMENT, "attributes is null");
    REFUSED(tt_session_set_part({}, 0, &of), TT_ERROR_HANDLE, "the session's handle is null");
    const auto before = session.part_attributes(0);
    HOLDS(before.hidden == 0 && before.has_colour == 0 && before.tolerance_scale == 0.5 && before.priority == 3);
    // A hidden instance is in the scene, and draws nothing; null shows it again.
    session.set_instance(key, of);
    HOLDS(session.instance_attributes(key).hidden == 1 && session.instance_attributes(key).colour[3] == 1);
    std::uint32_t hidden = 0, first = 0;
    auto sink = all_tiles();
    sink.begin = [&](const tt_scene &scene) { hidden = scene.placed[0].hidden; };
    sink.drawn = [&](const tt_drawn &drawn) { first = drawn.rows[0].instance; };
    session.view({view_of(prepared.get())}, sink);
    HOLDS(hidden == 1 && first == 1);
    HOLDS(tt_session_set_instance(session.get(), key, nullptr) == TT_OK);
    session.view({view_of(prepared.get())}, sink);
    HOLDS(hidden == 0 && first == 0 && session.instance_attributes(key).tolerance_scale == 1);
}

void callbacks() {
    const trimtess::Prepared prepared(trimtess::Model::shape("pair"));
    trimtess::Session session(prepared);
    const auto view = view_of(prepared.get());
    // A callback that refuses, in C.
    auto c = trimtess::sized<tt_sink>();
    c.tile = [](void *, const tt_tile *) -> std::int32_t { return 42; };
    REFUSED(tt_session_view(session.get(), &view, 1, &c, nullptr), TT_ERROR_CALLBACK, "tt_sink.tile: it returned 42");
    // One that throws, in C++: the exception itself comes back.
    auto sink = all_tiles();
    int aborts = 0;
    sink.tile = [](const tt_tile &) { throw 7; };
    sink.abort = [&] { aborts++; };
    int caught = 0;
    try {
        session.view({view}, sink);
    } catch (int number) {
        caught = number;
    }
    HOLDS(caught == 7 && aborts == 1);
    // A call of the same session from its callback, and of another thread meanwhile.
    sink = all_tiles();
    tt_status within = TT_OK, elsewhere = TT_OK, freed = TT_OK;
    bool words = false;
    sink.tile = [&](const tt_tile &) {
        within = tt_session_cancel(session.get());
        freed = tt_session_free(session.get());
        std::thread([&] {
            elsewhere = tt_session_forget(session.get());
            words = std::strstr(tt_last_error(), "another call uses the session") != nullptr;
        }).join();
    };
    HOLDS(session.view({view}, sink).whole == 1);
    HOLDS(within == TT_ERROR_BUSY && elsewhere == TT_ERROR_BUSY && freed == TT_ERROR_BUSY && words);
    // Memory that throws, and is asked again in the next frame.
    std::atomic<bool> full{true}, threw{false};
    std::atomic<int> rooms{0};
    const trimtess::Memory memory{[&](const tt_tile &tile, tt_room &room) {
                                      threw = full.load();
                                      if (threw) throw std::bad_alloc();
                                      rooms++;
                                      const auto vertices = std::size_t{tile.vertices} * tile.stride;
                                      auto *block = new unsigned char[vertices + std::size_t{12} * tile.triangles];
                                      room.vertices = block, room.indices = block + vertices;
                                      room.place = reinterpret_cast<std::uintptr_t>(block);
                                  },
                                  [&](const tt_tile &tile) {
                                      rooms--;
                                      delete[] reinterpret_cast<unsigned char *>(tile.place);
                                  }};
    session.write_into(trimtess::sized<tt_layout>(), memory);
    sink.tile = [&](const tt_tile &tile) { memory.release(tile); };
    bool refused = false;
    try {
        session.view({view}, sink);
    } catch (const std::bad_alloc &) {
        refused = true;
    }
    full = false;
    HOLDS(refused && session.view({view}, sink).whole == 1 && rooms == 0);
    // Its exception in a frame that another one replaces is of no call.
    trimtess::check(tt_session_forget(session.get()));
    full = true, threw = false;
    session.begin({view});
    while (!threw) std::this_thread::yield();
    full = false;
    session.begin({view});
    HOLDS(session.finish(sink).whole == 1 && rooms == 0);
    // A grid that is too coarse.
    auto layout = trimtess::sized<tt_layout>();
    layout.position = TT_POSITION_GRID;
    session.write_into(layout, memory);
    auto tolerance = trimtess::sized<tt_tolerance>();
    tolerance.chord_rel = 1e-6;
    HOLDS(thrown(__LINE__, [&] { session.tessellate(tolerance, sink); }) == TT_ERROR_GRID && rooms == 0);
    // Progress that throws cancels.
    const trimtess::Control control([](tt_stage, std::uint64_t, std::uint64_t) { throw std::logic_error("enough"); });
    bool enough = false;
    try {
        const trimtess::Prepared again(trimtess::Model::shape("box"), nullptr, &control);
    } catch (const std::logic_error &error) {
        enough = !std::strcmp(error.what(), "enough");
    }
    HOLDS(enough);
    // A control that is cancelled already.
    trimtess::Control stop;
    stop.cancel();
    HOLDS(thrown(__LINE__, [&] { session.tessellate(tolerance, sink, &stop); }) == TT_ERROR_CANCELLED);
}

void building() {
    tt_builder builder{};
    std::uint32_t part = 0, shell = 0, face = 0, rim = 0;
    HOLDS(tt_builder_new("disks", &builder) == TT_OK && tt_builder_add_part(builder, "disk", &part) == TT_OK);
    HOLDS(tt_builder_add_shell(builder, part, TT_SHELL_OPEN, &shell) == TT_OK);
    REFUSED(tt_builder_add_shell(builder, part, 5, nullptr), TT_ERROR_ARGUMENT, "no kind of shell 5");
    REFUSED(tt_builder_add_vertex(builder, part, NONE, 0, 0, nullptr), TT_ERROR_ARGUMENT, "vertex is [NaN, 0.0, 0.0]");
    REFUSED(tt_builder_add_line(builder, part, 0, 1, nullptr), TT_ERROR_ARGUMENT, "no vertex 0; there are 0");
    const double origin[3] = {0, 0, 0}, z[3] = {0, 0, 1}, x[3] = {1, 0, 0};
    const auto nowhere = tt_builder_add_circle(builder, part, origin, origin, x, 5, &rim);
    REFUSED(nowhere, TT_ERROR_ARGUMENT, "axis has no direction");
    HOLDS(tt_builder_add_circle(builder, part, origin, z, x, 5, &rim) == TT_OK);
    auto plane = trimtess::sized<tt_surface>();
    plane.kind = TT_PLANE, plane.axis[2] = 1, plane.reference[0] = 1;
    HOLDS(tt_builder_add_face(builder, part, &plane, shell, 0, &face) == TT_OK);
    tt_model model{};
    REFUSED(tt_builder_finish(builder, &model), TT_ERROR_MODEL, "part 0: face 0 has neither loops nor trimming curves");
    const tt_coedge missing{3, 0}, whole{rim, 0};
    REFUSED(tt_builder_add_loop(builder, part, face, &missing, 1), TT_ERROR_ARGUMENT, "no edge 3; there are 1");
    HOLDS(tt_builder_add_loop(builder, part, face, &whole, 1) == TT_OK);
    const auto green = [&](float share) { return tt_builder_set_colour(builder, part, face, 0, share, 0, 1); };
    REFUSED(green(static_cast<float>(NONE)), TT_ERROR_ARGUMENT, "its numbers must be finite");
    HOLDS(green(2) == TT_OK);
    REFUSED(tt_builder_finish(builder, &model), TT_ERROR_MODEL, "part 0: face 0 has the colour [0.0, 2.0, 0.0, 1.0]");
    HOLDS(green(1) == TT_OK);
    // Next to it, a quarter of a NURBS plane, kept by a triangle in (u,v).
    const double knots[4] = {0, 0, 1, 1}, net[12] = {9, 0, 0, 9, 8, 0, 17, 0, 0, 17, 8, 0};
    auto nurbs = trimtess::sized<tt_surface>();
    nurbs.kind = TT_NURBS, nurbs.degree_u = nurbs.degree_v = 1, nurbs.knots_u = nurbs.knots_v = knots;
    nurbs.points = net, nurbs.count_u = nurbs.count_v = 2;
    const double corners[8] = {0, 0, 1, 0, 0, 1, 0, 0};
    HOLDS(tt_builder_add_face(builder, part, &nurbs, shell, 0, &face) == TT_OK);
    HOLDS(tt_builder_add_polyline_trim(builder, part, face, TT_TRIM_HANDEDNESS, corners, 4) == TT_OK);
    auto placement = trimtess::sized<tt_placement>();
    HOLDS(tt_builder_place(builder, &placement, nullptr) == TT_OK);
    HOLDS(tt_builder_finish(builder, &model) == TT_OK);
    placement.has_colour = 1, placement.colour[3] = static_cast<float>(NONE);
    HOLDS(tt_builder_place(builder, &placement, nullptr) == TT_OK);
    tt_model none{};
    REFUSED(tt_builder_finish(builder, &none), TT_ERROR_MODEL, "instance 1 has the colour [0.0, 0.0, 0.0, NaN]");
    HOLDS(tt_builder_free(builder) == TT_OK);
    const trimtess::Prepared prepared(trimtess::Model::take(model));
    auto tolerance = trimtess::sized<tt_tolerance>();
    tolerance.chord = 0.01;
    const trimtess::Mesh mesh(prepared, tolerance);
    const auto made = mesh.part(0);
    double area[2] = {0, 0};
    for (std::uint64_t k = 0; k < made.triangles; k++) {
        const double *a = made.positions + 3 * made.indices[3 * k], *b = made.positions + 3 * made.indices[3 * k + 1];
        const double *c = made.positions + 3 * made.indices[3 * k + 2];
        area[made.faces[k]] += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
    }
    HOLDS(std::abs(area[0] - 25 * 3.14159265) < 0.4 && std::abs(area[1] - 32) < 1e-9);
}

} // namespace

int main() {
    HOLDS(*tt_last_error() == 0);
    handles();
    structs();
    views_and_sessions();
    attributes();
    limits();
    callbacks();
    building();
    std::atomic<int> logged{0};
    trimtess::set_log(TT_LOG_TRACE, [&](tt_log_level, const char *) { logged++; });
    {
        const trimtess::Prepared prepared(trimtess::Model::shape("box"));
        trimtess::Session session(prepared);
        session.view({view_of(prepared.get())}, all_tiles());
    }
    const int before = logged;
    trimtess::set_log(TT_LOG_OFF, {});
    HOLDS(before > 0);
    REFUSED(tt_set_log(9, nullptr, nullptr), TT_ERROR_ARGUMENT, "no log level 9");
    HOLDS(tt_live_handles() == 0);
    std::printf("%d cases\n", cases);
}
