// Random sequences of calls: living, dead, foreign and null handles, structs of wrong sizes, NaN, nulls, callbacks that
// refuse, calls from within callbacks and from other threads. Every call returns a status with words; at the end of a
// sequence no handle and no room is left. Run under sanitizers (capi/test).
//
//     sequences [COUNT] [FIRST]
//
// Sequence n depends on n alone, except for those that use two threads.
#include <trimtess.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

namespace {

std::uint64_t sequence = 0;

[[noreturn]] void fail(const char *what, long long number) {
    std::fprintf(stderr, "sequence %llu: %s (%lld): %s\n", static_cast<unsigned long long>(sequence), what, number,
                 tt_last_error());
    std::abort();
}

// SplitMix64, as the sequences of the Rust tests.
struct Random {
    std::uint64_t state;

    static std::uint64_t scrambled(std::uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
        x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
        return x ^ (x >> 31);
    }
    std::uint64_t bits() { return scrambled(state += 0x9e3779b97f4a7c15); }
    std::uint64_t below(std::uint64_t n) { return bits() % n; }
    bool once_in(std::uint64_t n) { return below(n) == 0; }

    double number(double good) {
        static const double odd[] = {0, -0.0, -1, 1e300, -1e300, 1e-300, 5e-324, 1e9,
                                     std::numeric_limits<double>::infinity(), std::nan("")};
        if (once_in(60)) return odd[below(sizeof odd / sizeof *odd)];
        return good * (0.5 + static_cast<double>(below(1000)) / 1000);
    }
    std::uint32_t index(std::uint32_t good) {
        return once_in(10) ? static_cast<std::uint32_t>(bits()) : static_cast<std::uint32_t>(below(good + 1));
    }
    std::uint32_t flag() { return once_in(3) ? 1 : 0; }
    const char *text() {
        static const char *texts[] = {"a part", "", "\xff\xfe", "Größe", nullptr, "orbit", "box"};
        return texts[below(sizeof texts / sizeof *texts)];
    }
};

// Rooms of tiles: those that workers asked for, and those that the sink owns.
struct Rooms {
    std::mutex mutex;
    std::set<void *> asked, owned;

    void *give(std::size_t bytes) {
        void *room = std::malloc(bytes ? bytes : 1);
        const std::lock_guard<std::mutex> lock(mutex);
        asked.insert(room);
        return room;
    }
    void back(std::set<void *> &from, void *room) {
        const std::lock_guard<std::mutex> lock(mutex);
        if (from.erase(room) == 0) fail("a room that is not there is given back", 0);
        std::free(room);
    }
} rooms;

std::mutex jobs_mutex;
std::vector<tt_job> jobs;
// How many more callbacks succeed, and the session that they belong to.
std::atomic<int> left{1 << 30};
std::atomic<std::uint64_t> busy{0};
std::atomic<std::uint64_t> tiles{0};

bool refuses() { return left.fetch_sub(1) <= 0; }

void from_within() {
    const tt_session session{busy.load()};
    if (session.id == 0) return;
    if (tt_session_cancel(session) != TT_ERROR_BUSY) fail("a call from within a callback", 0);
    if (tt_session_free(session) != TT_ERROR_BUSY) fail("a session freed from within a callback", 0);
}

// Vertices and indices in one block, behind its address as place.
std::int32_t room(void *, const tt_tile *tile, tt_room *room) {
    if (refuses()) return 7;
    const std::size_t vertices = std::size_t{tile->vertices} * tile->stride;
    void *block = rooms.give(vertices + std::size_t{3} * tile->triangles * tile->index_bytes);
    room->vertices = block;
    room->indices = static_cast<unsigned char *>(block) + vertices;
    room->place = reinterpret_cast<std::uintptr_t>(block);
    return 0;
}
void release(void *, const tt_tile *tile) { rooms.back(rooms.asked, reinterpret_cast<void *>(tile->place)); }

std::int32_t on_begin(void *, const tt_scene *scene) {
    for (std::uint32_t k = 0; k < scene->instances; k++) {
        if (scene->placed[k].part >= scene->parts) fail("an instance of no part", k);
    }
    if (scene->first_instance > scene->instances || scene->first_part > scene->parts) fail("news beyond the end", 0);
    for (std::uint32_t k = 0; k < scene->changed_count; k++) {
        if (scene->changed[k] >= scene->first_instance) fail("a change of what is new", scene->changed[k]);
    }
    std::set<std::uint64_t> keys(scene->keys, scene->keys + scene->instances);
    for (std::uint32_t k = 0; k < scene->removed_count; k++) {
        if (!keys.insert(scene->removed[k]).second) fail("a key that stays or goes twice", k);
    }
    std::set<std::uint32_t> kept;
    for (std::uint32_t k = 0; scene->from && k < scene->parts; k++) {
        if (scene->from[k] != TT_NONE && !kept.insert(scene->from[k]).second) fail("a part that goes on twice", k);
    }
    from_within();
    return refuses();
}
std::int32_t on_tile(void *, const tt_tile *tile) {
    tiles++;
    if (tile->triangles > 0 && tile->place != 0) {
        const auto *bytes = reinterpret_cast<unsigned char *>(tile->place);
        const std::size_t vertices = std::size_t{tile->vertices} * tile->stride;
        for (std::size_t k = 0; k < std::size_t{3} * tile->triangles; k++) {
            std::uint32_t index = 0;
            std::memcpy(&index, bytes + vertices + k * tile->index_bytes, tile->index_bytes);
            if (index >= tile->vertices) fail("an index of no vertex", index);
        }
        const std::lock_guard<std::mutex> lock(rooms.mutex);
        void *block = reinterpret_cast<void *>(tile->place);
        if (rooms.asked.erase(block) == 0) fail("a tile without a room", 0);
        rooms.owned.insert(block);
    }
    if (tile->positions) {
        for (std::uint32_t k = 0; k < 3 * tile->triangles; k++) {
            if (tile->indices[k] >= tile->vertices) fail("an index of no vertex", tile->indices[k]);
        }
        for (std::uint32_t k = 0; k < 3 * tile->vertices; k++) {
            if (!std::isfinite(tile->positions[k])) fail("a position that is no number", k);
        }
    }
    return refuses();
}
std::int32_t on_line(void *, const tt_line *line) { return line->count < 2 ? 9 : refuses(); }
std::int32_t on_drawn(void *, const tt_drawn *drawn) {
    std::uint64_t bits = 0;
    for (std::uint32_t k = 0; k < drawn->count; k++) {
        const tt_drawn_row &row = drawn->rows[k];
        for (std::uint32_t word = 0; word < row.count; word++) bits += drawn->words[row.start + word];
    }
    // What appears is drawn, and what disappears is not.
    const auto is_drawn = [&](const tt_drawn_row &of, std::uint32_t word) -> std::uint64_t {
        for (std::uint32_t k = 0; k < drawn->count; k++) {
            const tt_drawn_row &row = drawn->rows[k];
            if (row.view == of.view && row.instance == of.instance && word < row.count) {
                return drawn->words[row.start + word];
            }
        }
        return 0;
    };
    for (std::uint32_t k = 0; k < drawn->appeared_count; k++) {
        const tt_drawn_row &row = drawn->appeared[k];
        for (std::uint32_t word = 0; word < row.count; word++) {
            if (drawn->words[row.start + word] & ~is_drawn(row, word)) fail("a tile that appears, not drawn", word);
        }
    }
    for (std::uint32_t k = 0; k < drawn->disappeared_count; k++) {
        const tt_drawn_row &row = drawn->disappeared[k];
        for (std::uint32_t word = 0; word < row.count; word++) {
            if (drawn->words[row.start + word] & is_drawn(row, word)) fail("a tile that disappears, drawn", word);
        }
    }
    return bits == 1 ? 0 : refuses();
}
std::int32_t on_end(void *) {
    from_within();
    return refuses();
}
void on_abort(void *) {}
void on_progress(void *, std::uint32_t, std::uint64_t done, std::uint64_t total) {
    if (done > total) fail("more done than there is", static_cast<long long>(done));
}
void on_log(void *, std::uint32_t, const char *text) {
    if (std::strlen(text) > 1 << 20) fail("a long log", 0);
}
std::int32_t spawn(void *, tt_job job) {
    const std::lock_guard<std::mutex> lock(jobs_mutex);
    if (refuses()) return 1;
    jobs.push_back(job);
    return 0;
}
std::int32_t spawn_at_once(void *, tt_job job) { return tt_job_run(job); }
std::int32_t each_backwards(void *, std::uint32_t count, tt_body body, void *of) {
    while (count > 0) body(of, --count);
    return 0;
}
std::int32_t each_on_threads(void *, std::uint32_t count, tt_body body, void *of) {
    std::thread other([=] {
        for (std::uint32_t k = 0; k < count; k += 2) body(of, k);
    });
    for (std::uint32_t k = 1; k < count; k += 2) body(of, k);
    other.join();
    return 0;
}
// Leaves calls out, makes some twice, and some that there are not.
std::int32_t each_carelessly(void *, std::uint32_t count, tt_body body, void *of) {
    for (std::uint32_t k = 0; k < count + 2; k += 2) body(of, k), body(of, k);
    body(of, 0xffffffff);
    body(nullptr, 0);
    return 9;
}

enum Kind { CONTROL = 1, MODEL, BUILDER, PREPARED, MESH, SESSION, JOB, KINDS };

// A sequence, or what another thread does at the same time.
struct Run {
    Random random;
    bool alone;
    std::vector<std::uint64_t> live[KINDS], dead;
    // Structs of the current call.
    std::vector<std::unique_ptr<unsigned char[]>> held;
    bool dead_used = false;
    // Calls, and those that succeeded.
    std::uint64_t calls = 0, good = 0;
    // The key that was heard of last, of an instance of any session.
    std::uint64_t instance = 0;

    // A handle of a kind; sometimes one that is none.
    template <class H> H pick(Kind kind) {
        const auto odd = random.below(16);
        std::uint64_t id = 0;
        if (odd > 2 && !live[kind].empty()) return H{live[kind][random.below(live[kind].size())]};
        if (odd == 0 && !dead.empty()) id = dead[random.below(dead.size())];
        if (odd == 1) id = random.bits();
        const auto &other = live[1 + random.below(KINDS - 1)];
        if (odd == 2 && !other.empty()) id = other[random.below(other.size())];
        const auto &same = live[kind];
        dead_used |= std::find(same.begin(), same.end(), id) == same.end();
        return H{id};
    }
    template <class H> H pick_or_none(Kind kind) { return random.once_in(2) ? H{0} : pick<H>(kind); }

    // A copy of a struct on the heap, with as many bytes as it states; sometimes null, or of another size.
    template <class T> T *given(T value) {
        if (random.once_in(24)) return nullptr;
        std::uint32_t stated = sizeof(T), bytes = sizeof(T);
        unsigned char tail = 0;
        switch (random.below(24)) {
        case 0: stated = bytes = static_cast<std::uint32_t>(4 + random.below(sizeof(T))); break;
        case 1: stated = 0; break;
        case 2: stated = 0xffffffff; break;
        case 3: stated = bytes = sizeof(T) + 16; break;
        case 4: stated = bytes = sizeof(T) + 16, tail = 1; break;
        default: break;
        }
        auto block = std::make_unique<unsigned char[]>(bytes);
        std::memset(block.get(), tail, bytes);
        value.size = stated;
        std::memcpy(block.get(), &value, std::min<std::size_t>(bytes, sizeof(T)));
        held.push_back(std::move(block));
        return reinterpret_cast<T *>(held.back().get());
    }
    template <class T> T *empty() {
        T value;
        std::memset(&value, 0, sizeof value);
        return given(value);
    }
    // Exactly these numbers on the heap; sometimes null.
    template <class T> T *numbers(const std::vector<T> &values) {
        if (random.once_in(30)) return nullptr;
        held.push_back(std::make_unique<unsigned char[]>(values.size() * sizeof(T)));
        if (!values.empty()) std::memcpy(held.back().get(), values.data(), values.size() * sizeof(T));
        return reinterpret_cast<T *>(held.back().get());
    }
    double *some(std::size_t count, double good) {
        std::vector<double> values(count);
        for (auto &value : values) value = random.number(good);
        return numbers(values);
    }

    // Checks what a call returned.
    bool ended(tt_status status) {
        if (status < TT_ERROR_PANIC || status > TT_PENDING) fail("no status", status);
        if (status == TT_ERROR_PANIC || status == TT_ERROR_LOST) fail("an internal error", status);
        calls++;
        good += status >= TT_OK;
        if (status < TT_OK && *tt_last_error() == 0) fail("an error without words", status);
        if (alone && dead_used && status >= TT_OK) fail("a dead handle was taken", status);
        held.clear();
        dead_used = false;
        return status >= TT_OK;
    }
    template <class H> void made(Kind kind, tt_status status, const H &handle) {
        if (ended(status)) live[kind].push_back(handle.id);
    }
    template <class H> void freed(Kind kind, H handle, tt_status status) {
        auto &all = live[kind];
        const auto found = std::find(all.begin(), all.end(), handle.id);
        dead_used &= handle.id != 0;
        if (ended(status) && found != all.end()) {
            dead.push_back(handle.id);
            all.erase(found);
        }
    }

    tt_view view() {
        tt_view view{};
        view.orthographic = random.flag();
        for (int k = 0; k < 3; k++) {
            view.eye[k] = random.number(30), view.up[k] = random.number(k == 1 ? -5 : 1);
            view.forward[k] = -view.eye[k] + random.number(1);
        }
        view.fov_y = random.number(0.7), view.near = random.number(0.1), view.height = random.number(30);
        view.width_px = random.index(640), view.height_px = random.index(480);
        if (!random.once_in(20)) view.width_px = 640, view.height_px = 480;
        view.deviation_px = random.number(2), view.angle = random.number(0.5);
        view.size_px = random.once_in(4) ? random.number(200) : 0;
        return view;
    }
    const tt_sink *sink() {
        tt_sink sink{};
        sink.begin = on_begin, sink.drawn = on_drawn;
        sink.tile = random.once_in(20) ? nullptr : on_tile;
        if (random.flag()) sink.line = on_line, sink.end = on_end, sink.abort = on_abort;
        left = random.once_in(6) ? static_cast<int>(random.below(12)) : 1 << 30;
        return given(sink);
    }
    tt_jobs loops() {
        tt_jobs pool{};
        pool.width = random.index(3), pool.spawn = spawn_at_once;
        switch (random.below(4)) {
        case 0: pool.each = each_backwards; break;
        case 1: pool.each = each_on_threads; break;
        case 2: pool.each = each_carelessly; break;
        default: break;
        }
        return pool;
    }
    tt_attributes attributes() {
        tt_attributes of{};
        of.hidden = random.once_in(3), of.has_colour = random.once_in(4);
        for (float &share : of.colour) share = static_cast<float>(random.once_in(12) ? random.number(2) : 0.5);
        of.tolerance_scale = random.number(0.7), of.priority = random.number(3);
        return of;
    }
    tt_placement placement() {
        tt_placement placement{};
        placement.part = random.index(1), placement.has_colour = random.flag(), placement.name = random.text();
        if (random.once_in(2)) {
            for (int k = 0; k < 12; k++) placement.transform[k] = k % 4 == 0 ? 1 : k > 8 ? random.number(5) : 0;
        }
        return placement;
    }

    void models();
    void building();
    void preparing();
    void sessions();
    void frames();
    void other_thread();
    void end();

    void call() {
        switch (random.below(12)) {
        case 0: return models();
        case 1: case 2: case 3: return building();
        case 4: return preparing();
        case 5: case 6: return sessions();
        default: return frames();
        }
    }
};

std::vector<unsigned char> file;

void Run::models() {
    char text[16];
    std::size_t length = 0;
    tt_model model{};
    switch (random.below(10)) {
    case 0: return made(MODEL, tt_model_shape(random.text(), &model), model);
    case 1: ended(tt_model_get_info(pick<tt_model>(MODEL), empty<tt_model_info>())); return;
    case 2: ended(tt_model_get_name(pick<tt_model>(MODEL), text, random.below(sizeof text + 1), &length)); return;
    case 3: ended(tt_model_get_part_name(pick<tt_model>(MODEL), random.index(1), text, 16, nullptr)); return;
    case 4: {
        auto *told = empty<tt_diagnostic>();
        ended(tt_model_get_diagnostic(pick<tt_model>(MODEL), random.index(1), told, text, 16, &length));
        return;
    }
    case 5: {
        if (live[MODEL].size() < 2) return;
        const auto handle = pick<tt_model>(MODEL);
        return freed(MODEL, handle, tt_model_free(handle));
    }
    case 6: {
        tt_control control{};
        tt_progress progress{};
        progress.report = random.flag() ? on_progress : nullptr;
        return made(CONTROL, tt_control_new(random.flag() ? given(progress) : nullptr, &control), control);
    }
    case 7: {
        const auto handle = pick<tt_control>(CONTROL);
        if (random.flag()) return freed(CONTROL, handle, tt_control_free(handle));
        ended(tt_control_cancel(handle));
        return;
    }
    case 8:
        ended(tt_set_log(random.index(5), random.flag() ? on_log : nullptr, nullptr));
        return;
    default: {
        if (!random.once_in(8)) return;
        // The file with some bytes changed, or random ones.
        std::vector<unsigned char> bytes = file;
        const bool no_step = bytes.empty() || random.once_in(3);
        if (no_step) bytes.assign(random.below(300), static_cast<unsigned char>(random.bits()));
        for (auto k = random.below(4); k > 0 && !bytes.empty(); k--) {
            bytes[random.below(bytes.size())] = static_cast<unsigned char>(random.bits());
        }
        tt_read_options options{};
        options.threads = 1, options.fit_tolerance = random.number(1e-3);
        options.max_bytes = random.once_in(8) ? random.below(1000) : 0;
        if (random.flag()) options.jobs = given(loops()), options.threads = random.once_in(9);
        const auto *given_options = random.flag() ? given(options) : nullptr;
        const auto control = pick_or_none<tt_control>(CONTROL);
        // An optional handle may be none.
        dead_used &= control.id != 0;
        made(MODEL, tt_read_memory(numbers(bytes), bytes.size(), random.text(), given_options, control, &model), model);
    }
    }
}

void Run::building() {
    std::uint32_t index = 0;
    const auto part = random.index(0);
    const auto builder = pick<tt_builder>(BUILDER);
    tt_curve curve{};
    curve.degree = random.index(3), curve.count = 2 + random.below(5);
    curve.points = some(3 * curve.count, 5);
    std::vector<double> knots(curve.count + curve.degree % 8 + 1);
    for (std::size_t k = 0; k < knots.size(); k++) knots[k] = k <= curve.degree % 8 ? 0 : random.number(1) + double(k);
    curve.degree %= 8;
    curve.knots = numbers(knots);
    curve.weights = random.flag() ? some(curve.count, 1) : nullptr;
    switch (random.below(16)) {
    case 0: {
        tt_builder next{};
        dead_used = false;
        return made(BUILDER, tt_builder_new(random.text(), &next), next);
    }
    case 1: ended(tt_builder_add_part(builder, random.text(), &index)); return;
    case 2: case 3:
        ended(tt_builder_add_vertex(builder, part, random.number(9), random.number(9), random.number(9), &index));
        return;
    case 4: case 5: ended(tt_builder_add_line(builder, part, random.index(5), random.index(5), nullptr)); return;
    case 6:
        ended(tt_builder_add_circle(builder, part, some(3, 1), some(3, 1), some(3, 1), random.number(4), &index));
        return;
    case 7: ended(tt_builder_add_edge(builder, part, given(curve), random.index(5), random.index(5), &index)); return;
    case 8: ended(tt_builder_add_shell(builder, part, random.index(3), &index)); return;
    case 9: case 10: {
        tt_surface surface{};
        surface.kind = random.index(7);
        for (double *three : {surface.origin, surface.axis, surface.reference, surface.direction}) {
            for (int k = 0; k < 3; k++) three[k] = random.number(1);
        }
        surface.radius = random.number(5), surface.minor_radius = random.number(2);
        surface.half_angle = random.number(0.4);
        surface.curve = given(curve);
        surface.degree_u = surface.degree_v = 1, surface.count_u = surface.count_v = 2;
        surface.points = some(12, 8), surface.knots_u = some(4, 1), surface.knots_v = numbers<double>({0, 0, 1, 1});
        if (random.flag()) surface.knots_u = surface.knots_v;
        ended(tt_builder_add_face(builder, part, given(surface), random.index(0), random.flag(), &index));
        return;
    }
    case 11: {
        std::vector<tt_coedge> coedges(random.below(5));
        for (auto &coedge : coedges) coedge = {random.index(4), random.flag()};
        ended(tt_builder_add_loop(builder, part, random.index(1), numbers(coedges), coedges.size()));
        return;
    }
    case 12: {
        const std::size_t count = random.below(6);
        const auto face = random.index(1), rule = random.index(2);
        if (random.flag()) ended(tt_builder_add_trim(builder, part, face, rule, given(curve)));
        else ended(tt_builder_add_polyline_trim(builder, part, face, rule, some(2 * count, 3), count));
        return;
    }
    case 13: ended(tt_builder_place(builder, given(placement()), &index)); return;
    case 14: {
        tt_model model{};
        return made(MODEL, tt_builder_finish(builder, random.once_in(20) ? nullptr : &model), model);
    }
    default: return freed(BUILDER, builder, tt_builder_free(builder));
    }
}

void Run::preparing() {
    char text[16];
    switch (random.below(8)) {
    case 0: {
        tt_prepare_options options{};
        options.threads = 1, options.border_tolerance = random.once_in(4) ? random.number(1e-4) : 0;
        options.max_patches = random.once_in(8) ? 1 : 0;
        options.keep_faces = random.flag();
        if (random.flag()) options.jobs = given(loops()), options.threads = random.once_in(9);
        if (!live[PREPARED].empty()) options.like.id = live[PREPARED][random.below(live[PREPARED].size())];
        tt_prepared prepared{};
        const auto model = pick<tt_model>(MODEL);
        const bool dead_model = dead_used;
        const auto control = pick_or_none<tt_control>(CONTROL);
        if (control.id == 0) dead_used = dead_model;
        return made(PREPARED, tt_prepare(model, given(options), control, &prepared), prepared);
    }
    case 1: ended(tt_prepared_get_info(pick<tt_prepared>(PREPARED), empty<tt_prepared_info>())); return;
    case 2: ended(tt_prepared_get_part(pick<tt_prepared>(PREPARED), random.index(1), empty<tt_part>())); return;
    case 3: {
        tt_instance instance;
        ended(tt_prepared_get_instance(pick<tt_prepared>(PREPARED), random.index(2), &instance));
        return;
    }
    case 4: {
        double matrix[16];
        for (double &number : matrix) number = random.number(2) - 1;
        ended(tt_view_from_matrix(matrix, random.index(9), random.index(9), given(this->view())));
        const auto view = given(this->view());
        ended(tt_view_along_path(pick<tt_prepared>(PREPARED), random.text(), random.index(9), random.index(9), view));
        return;
    }
    case 5: {
        if (live[PREPARED].size() < 3) return;
        const auto handle = pick<tt_prepared>(PREPARED);
        return freed(PREPARED, handle, tt_prepared_free(handle));
    }
    case 6: {
        tt_tolerance tolerance{};
        tolerance.chord_rel = random.number(0.02), tolerance.angle = random.number(0.6);
        tolerance.max_triangles = 20000, tolerance.coarsen = random.flag();
        tt_tessellate_options options{};
        options.threads = 1, options.edge_lines = random.flag();
        tt_mesh mesh{};
        const auto prepared = pick<tt_prepared>(PREPARED);
        return made(MESH, tt_tessellate(prepared, given(tolerance), given(options), {}, &mesh), mesh);
    }
    default: {
        const auto mesh = pick<tt_mesh>(MESH);
        switch (random.below(5)) {
        case 0: ended(tt_mesh_get_info(mesh, empty<tt_mesh_info>())); return;
        case 1: ended(tt_mesh_get_part(mesh, random.index(1), empty<tt_mesh_part>())); return;
        case 2: ended(tt_mesh_get_line(mesh, random.index(1), random.index(3), empty<tt_line>())); return;
        case 3: ended(tt_mesh_get_diagnostic(mesh, random.index(1), empty<tt_diagnostic>(), text, 16, nullptr)); return;
        default: return freed(MESH, mesh, tt_mesh_free(mesh));
        }
    }
    }
}

void Run::sessions() {
    const auto session = pick<tt_session>(SESSION);
    switch (random.below(9)) {
    case 0: case 1: case 2: {
        dead_used = false;
        tt_session_options options{};
        const bool own = random.once_in(12);
        options.threads = own ? 2 : 0, options.workers = random.index(3) % 5, options.no_threads = !own;
        options.edge_lines = random.flag(), options.levels = random.index(3) % 9;
        options.rebalance_every = random.index(2), options.cull_back_faces = random.flag();
        options.budget = random.once_in(3) ? random.number(1e-4) : 0;
        options.max_triangles = 20000;
        tt_jobs pool{};
        pool.width = random.index(4), pool.spawn = random.flag() ? spawn : random.once_in(9) ? nullptr : spawn_at_once;
        const tt_jobs *given_pool = !own && random.flag() ? given(pool) : nullptr;
        if (given_pool) options.no_threads = random.once_in(9);
        left = 1 << 30;
        tt_session next{};
        const auto prepared = pick<tt_prepared>(PREPARED);
        return made(SESSION, tt_session_new(prepared, given(options), given_pool, &next), next);
    }
    case 3: case 4: {
        tt_layout layout{};
        layout.position = random.index(2), layout.normal = random.index(2), layout.uv = random.flag();
        layout.tangent = random.flag(), layout.origin = random.flag(), layout.wide_indices = random.flag();
        tt_memory memory{};
        memory.room = random.once_in(20) ? nullptr : room, memory.release = release;
        ended(tt_session_write_into(session, given(layout), given(memory)));
        return;
    }
    case 5: ended(tt_session_get_info(session, empty<tt_session_info>())); return;
    case 6: return freed(SESSION, session, tt_session_free(session));
    default: {
        // Jobs in any order; some are dropped.
        dead_used = false;
        tt_job job{random.bits()};
        {
            const std::lock_guard<std::mutex> lock(jobs_mutex);
            if (!jobs.empty()) {
                std::swap(jobs[random.below(jobs.size())], jobs.back());
                job = jobs.back();
                if (!random.once_in(20)) jobs.pop_back();
            }
        }
        ended(random.once_in(8) ? tt_job_drop(job) : tt_job_run(job));
    }
    }
}

void Run::frames() {
    const auto session = pick<tt_session>(SESSION);
    auto *report = random.flag() ? empty<tt_report>() : nullptr;
    std::vector<tt_view> views(1 + random.below(2), view());
    for (auto &view : views) view.size = sizeof view;
    if (random.once_in(20)) views.back().size = 4;
    const auto *given_views = numbers(views);
    busy = alone && !dead_used ? session.id : 0;
    switch (random.below(14)) {
    case 0: case 1: ended(tt_session_begin(session, given_views, views.size())); break;
    case 2: case 3: ended(tt_session_finish(session, sink(), report)); break;
    case 4: {
        const double seconds = random.once_in(4) ? random.number(1e-5) : 1e-4;
        ended(tt_session_finish_within(session, seconds, sink(), report));
        break;
    }
    case 5: ended(tt_session_view(session, given_views, views.size(), sink(), report)); break;
    case 6: {
        tt_tolerance tolerance{};
        tolerance.chord_rel = random.number(0.02), tolerance.max_triangles = 20000, tolerance.coarsen = random.flag();
        ended(tt_session_tessellate(session, given(tolerance), {}, sink(), report));
        break;
    }
    case 7: ended(random.flag() ? tt_session_cancel(session) : tt_session_forget(session)); break;
    case 10: {
        const auto prepared = pick<tt_prepared>(PREPARED);
        busy = alone && !dead_used ? session.id : 0;
        ended(tt_session_update(session, prepared));
        break;
    }
    case 8: {
        if (random.flag()) ended(tt_session_add_instance(session, given(placement()), &instance));
        else ended(tt_session_remove_instance(session, instance));
        break;
    }
    case 9: {
        std::uint32_t index = random.index(2);
        ended(tt_session_get_instance_key(session, index, &instance));
        ended(tt_session_find_instance(session, instance, &index));
        break;
    }
    case 11: {
        const auto part = random.index(1);
        ended(tt_session_set_part(session, part, random.once_in(8) ? nullptr : given(attributes())));
        ended(tt_session_get_part_attributes(session, part, empty<tt_attributes>()));
        break;
    }
    case 12: {
        ended(tt_session_set_instance(session, instance, random.once_in(8) ? nullptr : given(attributes())));
        ended(tt_session_get_instance_attributes(session, instance, empty<tt_attributes>()));
        break;
    }
    default: {
        std::vector<double> transform(12);
        for (int k = 0; k < 12; k++) transform[k] = k % 4 == 0 ? 1 : k > 8 ? random.number(5) : 0;
        ended(tt_session_move_instance(session, instance, numbers(transform)));
    }
    }
    busy = 0;
}

// The same handles from two threads: whatever is in use is busy.
void Run::other_thread() {
    Run other{Random{random.bits()}, false, {}, dead, {}, false, 0, 0, 0};
    for (int kind = 0; kind < KINDS; kind++) other.live[kind] = live[kind];
    const bool was_alone = std::exchange(alone, false);
    std::thread thread([&] {
        for (int k = 0; k < 8; k++) other.call();
    });
    for (int k = 0; k < 8; k++) call();
    thread.join();
    alone = was_alone;
    for (int kind = 0; kind < KINDS; kind++) {
        // What one of them freed is dead, what one of them made is alive: frees tell.
        auto &all = live[kind];
        all.insert(all.end(), other.live[kind].begin(), other.live[kind].end());
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
    }
    other.held.clear();
}

void Run::end() {
    left = 1 << 30;
    const bool strict = alone;
    const auto gone = [&](tt_status status) {
        if (status != TT_OK && (strict || status != TT_ERROR_HANDLE)) fail("a handle is not freed", status);
    };
    for (const auto id : live[SESSION]) gone(tt_session_free({id}));
    for (const auto id : live[MESH]) gone(tt_mesh_free({id}));
    for (const auto id : live[PREPARED]) gone(tt_prepared_free({id}));
    for (const auto id : live[BUILDER]) gone(tt_builder_free({id}));
    for (const auto id : live[MODEL]) gone(tt_model_free({id}));
    for (const auto id : live[CONTROL]) gone(tt_control_free({id}));
    for (const auto job : jobs) tt_job_drop(job);
    jobs.clear();
    if (!rooms.asked.empty()) fail("rooms are lost", static_cast<long long>(rooms.asked.size()));
    for (void *room : rooms.owned) std::free(room);
    rooms.owned.clear();
    if (tt_live_handles() != 0) fail("handles are left", static_cast<long long>(tt_live_handles()));
}

} // namespace

int main(int argc, char **argv) {
    const std::uint64_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 5000;
    const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
    if (const char *path = std::getenv("SEQUENCES_FILE")) {
        if (std::FILE *in = std::fopen(path, "rb")) {
            for (int byte; (byte = std::fgetc(in)) != EOF;) file.push_back(static_cast<unsigned char>(byte));
            std::fclose(in);
        }
    }
    std::uint64_t calls = 0, good = 0, threaded = 0;
    for (sequence = first; sequence < first + count; sequence++) {
        Run run{Random{Random::scrambled(sequence)}, true, {}, {}, {}, false, 0, 0, 0};
        static const char *shapes[] = {"box", "pair", "washer", "sphere", "flower", "cone"};
        tt_model model{};
        run.made(MODEL, tt_model_shape(shapes[run.random.below(6)], &model), model);
        tt_prepared prepared{};
        tt_prepare_options options{};
        options.size = sizeof options, options.threads = 1;
        run.made(PREPARED, tt_prepare(model, &options, {}, &prepared), prepared);
        const bool threads = run.random.once_in(16);
        const auto length = 1 + run.random.below(40);
        // Most calls are of sessions, which need one.
        while (run.live[SESSION].empty() && !run.random.once_in(16)) run.sessions();
        for (std::uint64_t k = 0; k < length; k++) run.call();
        if (threads) run.other_thread(), run.alone = false, threaded++;
        calls += run.calls;
        good += run.good;
        run.end();
    }
    const auto shown = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
    std::printf("%llu sequences from %llu on, %llu on two threads, %llu calls, of which %llu succeeded, %llu tiles: "
                "0 findings\n",
                shown(count), shown(first), shown(threaded), shown(calls), shown(good), shown(tiles));
}
