// Reads a STEP file, flies a camera around it, receives tiles packed in its own memory, and prints what the last
// picture has, and a hash of all pictures: that of
// `trimtess bench FILE --hash --frames 60 --size 1280x720 --angle 30`.
//
//     view FILE [PATH] [FRAMES] [THREADS]
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <trimtess.h>

// A tile in our memory. A renderer would have an offset into its buffers here.
typedef struct block {
    tt_tile tile;
    unsigned char *vertices, *indices;
} block;

// The tiles of a part, by their numbers.
typedef struct part {
    block **tiles;
    size_t count;
} part;

typedef struct scene {
    part *parts;
    size_t part_count;
    uint32_t *drawn_parts; // of each instance
    size_t instance_count;
    // Of the last frame.
    uint64_t triangles;
    // Of all frames.
    uint64_t hash;
} scene;

static void check(tt_status status, const char *what) {
    if (status >= TT_OK) return;
    fprintf(stderr, "%s: %s\n", what, tt_last_error());
    exit(1);
}

// --- Memory: one block per tile. Called by workers, on any thread; malloc is safe there.

static void free_block(block *of) {
    if (!of) return;
    free(of->vertices);
    free(of->indices);
    free(of);
}

static int32_t room(void *user, const tt_tile *tile, tt_room *room) {
    (void)user;
    block *of = calloc(1, sizeof *of);
    if (!of) return 1;
    of->tile = *tile;
    of->vertices = malloc((size_t)tile->vertices * tile->stride);
    of->indices = malloc((size_t)3 * tile->triangles * tile->index_bytes);
    if (!of->vertices || !of->indices) {
        free_block(of);
        return 1;
    }
    room->vertices = of->vertices;
    room->indices = of->indices;
    room->place = (uint64_t)(uintptr_t)of;
    return 0;
}

static void release(void *user, const tt_tile *tile) {
    (void)user;
    free_block((block *)(uintptr_t)tile->place);
}

// --- Sink: keeps the tiles. Called on our thread, within tt_session_finish.

static void forget(scene *all) {
    for (size_t p = 0; p < all->part_count; p++) {
        for (size_t t = 0; t < all->parts[p].count; t++) free_block(all->parts[p].tiles[t]);
        free(all->parts[p].tiles);
    }
    free(all->parts);
    all->parts = NULL;
    all->part_count = 0;
}

static int32_t on_begin(void *user, const tt_scene *frame) {
    scene *all = user;
    if (frame->whole) forget(all);
    if (frame->parts > all->part_count) { // The first frame, and where an instance brings another level of detail.
        part *parts = realloc(all->parts, frame->parts * sizeof *parts);
        if (!parts) return 1;
        memset(parts + all->part_count, 0, (frame->parts - all->part_count) * sizeof *parts);
        all->parts = parts;
        all->part_count = frame->parts;
    }
    if (frame->whole || frame->instances != all->instance_count) {
        uint32_t *drawn = realloc(all->drawn_parts, (frame->instances + 1) * sizeof *drawn);
        if (!drawn) return 1;
        all->drawn_parts = drawn;
        all->instance_count = frame->instances;
    }
    // Indices shift where instances go. Else only those differ that are listed, and those that are new.
    uint32_t first = frame->removed_count > 0 ? 0 : frame->first_instance;
    for (uint32_t i = first; i < frame->instances; i++) all->drawn_parts[i] = frame->placed[i].part;
    for (uint32_t k = 0; k < frame->changed_count; k++) {
        all->drawn_parts[frame->changed[k]] = frame->placed[frame->changed[k]].part;
    }
    return 0;
}

static int32_t on_tile(void *user, const tt_tile *tile) {
    scene *all = user;
    part *of = &all->parts[tile->part];
    if (tile->tile >= of->count) {
        size_t count = 2 * (size_t)tile->tile + 16;
        block **tiles = realloc(of->tiles, count * sizeof *tiles);
        if (!tiles) { // Its room is ours already.
            free_block((block *)(uintptr_t)tile->place);
            return 1;
        }
        memset(tiles + of->count, 0, (count - of->count) * sizeof *tiles);
        of->tiles = tiles;
        of->count = count;
    }
    free_block(of->tiles[tile->tile]);
    of->tiles[tile->tile] = tile->triangles ? (block *)(uintptr_t)tile->place : NULL;
    return 0;
}

// FNV-1a.
static void hash(scene *all, const void *bytes, size_t count) {
    const unsigned char *at = bytes;
    for (size_t k = 0; k < count; k++) all->hash = (all->hash ^ at[k]) * UINT64_C(0x100000001b3);
}

static void draw(scene *all, uint32_t instance, const block *of) {
    if (!of) return; // A tile without triangles.
    const tt_tile *tile = &of->tile;
    uint32_t words[] = {instance, tile->part, tile->face, tile->tile, tile->vertices, tile->triangles};
    hash(all, words, sizeof words);
    hash(all, of->vertices, (size_t)tile->vertices * tile->stride);
    hash(all, of->indices, (size_t)3 * tile->triangles * tile->index_bytes);
    all->triangles += tile->triangles;
}

static int32_t on_drawn(void *user, const tt_drawn *drawn) {
    scene *all = user;
    all->triangles = 0;
    for (uint32_t k = 0; k < drawn->count; k++) {
        const tt_drawn_row *row = &drawn->rows[k];
        const part *of = &all->parts[all->drawn_parts[row->instance]];
        for (uint32_t tile = 0; tile < 64 * row->count && tile < of->count; tile++) {
            bool is_drawn = drawn->words[row->start + tile / 64] >> tile % 64 & 1;
            if (is_drawn) draw(all, row->instance, of->tiles[tile]);
        }
    }
    return 0;
}

static void on_abort(void *user) { forget(user); }

static void on_progress(void *user, uint32_t stage, uint64_t done, uint64_t total) {
    (void)user;
    if (done == total) fprintf(stderr, "%s: %" PRIu64 "\n", stage == TT_STAGE_READ ? "parts" : "faces", total);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: view FILE [PATH] [FRAMES] [THREADS]\n");
        return 2;
    }
    const char *path = argc > 2 ? argv[2] : "orbit";
    uint32_t frames = argc > 3 ? (uint32_t)atoi(argv[3]) : 60;

    tt_control control;
    tt_progress progress = {.size = sizeof progress, .report = on_progress};
    check(tt_control_new(&progress, &control), "progress");
    tt_model model;
    check(tt_read_file(argv[1], NULL, control, &model), "read");
    tt_prepared prepared;
    check(tt_prepare(model, NULL, control, &prepared), "prepare");
    check(tt_model_free(model), "free");
    check(tt_control_free(control), "free");

    tt_session session;
    tt_session_options options = {.size = sizeof options, .threads = argc > 4 ? (uint32_t)atoi(argv[4]) : 0};
    check(tt_session_new(prepared, &options, NULL, &session), "session");
    tt_layout layout = {.size = sizeof layout}; // f32 positions, octahedral normals: 16 bytes
    scene all = {.hash = UINT64_C(0xcbf29ce484222325)};
    tt_memory memory = {.size = sizeof memory, .room = room, .release = release};
    check(tt_session_write_into(session, &layout, &memory), "layout");

    tt_sink sink = {.size = sizeof sink,
                    .user = &all,
                    .begin = on_begin,
                    .tile = on_tile,
                    .drawn = on_drawn,
                    .abort = on_abort};
    tt_view view = {.size = sizeof view, .width_px = 1280, .height_px = 720};
    uint64_t made = 0;
    for (uint32_t k = 0; k < frames; k++) {
        check(tt_view_along_path(prepared, path, k, frames, &view), "path");
        check(tt_session_begin(session, &view, 1), "begin");
        // An engine does other work here, while the frame is made.
        tt_report report = {.size = sizeof report};
        check(tt_session_finish(session, &sink, &report), "finish");
        made += report.tiles;
    }

    check(tt_session_free(session), "free");
    check(tt_prepared_free(prepared), "free");
    forget(&all);
    free(all.drawn_parts);
    printf("%" PRIu32 " frames, %" PRIu64 " tiles made, %" PRIu64 " handles left\n", frames, made, tt_live_handles());
    printf("triangles %" PRIu64 " hash %016" PRIx64 "\n", all.triangles, all.hash);
    return tt_live_handles() != 0;
}
