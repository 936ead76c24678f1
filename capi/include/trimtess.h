// trimtess: trimmed NURBS models (CAD B-reps, STEP files) to crack-free triangles.
//
// Made of capi/src by cbindgen; docs/c.md is its guide.
//
// Handles are structs of one number. Zeros are no object: freeing it does nothing, other functions return
// TT_ERROR_HANDLE. So they do with a handle that was freed, or is of another kind: handles are never given twice.
//
// Status: functions return TT_OK or an error, and tt_last_error the words. After an error, what was to be written is as
// it was, unless it says otherwise.
//
// Structs that begin with `size` may grow in later versions. The caller sets it to sizeof of the struct, and fields
// that it does not know to 0; zeros are defaults. Fields named `reserved` are 0. Structs that the library gives to
// callbacks have the size of the library's version. "Will not grow" stands where a struct has no size.
//
// Texts are UTF-8. Those passed in end with a zero byte and are copied. Those passed out are copied into `text`, which
// has `capacity` bytes: cut between characters, with a zero byte at the end. `length` gets the bytes of the whole text
// without that one. `text` may be null if `capacity` is 0, `length` may always be.
//
// Pointers are not null unless a function says so. They are aligned, point to as much as the function says, and stay
// valid until it returns; longer where it says so. Null and misaligned ones are errors, others that are wrong cannot be
// seen.
//
// Threads: any function may be called from any thread at any time. Sessions and builders serve one call at a time,
// others return TT_ERROR_BUSY. Where the library starts threads, 0 stands for one per core, or for as many as the
// environment variable RAYON_NUM_THREADS says.
//
// Callbacks return to the library: no exception leaves them, and no longjmp. `user` is passed on as it is.
//
// Lengths are millimetres, angles radians. Matrices are stored by columns.

#ifndef TRIMTESS_H
#define TRIMTESS_H

#include <stddef.h>
#include <stdint.h>

// Version of this header. `tt_version` has that of the library. While the first number is 0, programs need a library
// of the same first and second number.
#define TT_VERSION_MAJOR 0

#define TT_VERSION_MINOR 1

#define TT_VERSION_PATCH 0

// "None" where a number of 32 bits stands for a part, face, edge or entity.
#define TT_NONE UINT32_MAX

// What every function returns. Errors are below 0; `tt_last_error` has the words.
typedef enum {
    // Done.
    TT_OK = 0,
    // Not made yet: `tt_session_finish_within` waited for as long as it was told.
    TT_PENDING = 1,
    // An argument is null, of an unknown size or kind, out of range, NaN, or not UTF-8. Nothing has changed.
    TT_ERROR_ARGUMENT = -1,
    // A handle is null, was freed, or is of another kind. Nothing has changed.
    TT_ERROR_HANDLE = -2,
    // Another call uses the object: of another thread, or the call that this callback belongs to. Nothing has changed.
    TT_ERROR_BUSY = -3,
    // The file cannot be read, or is no STEP file.
    TT_ERROR_READ = -4,
    // A limit is exceeded. The words name it.
    TT_ERROR_LIMIT = -5,
    // The work was cancelled.
    TT_ERROR_CANCELLED = -6,
    // What was built is not a valid model.
    TT_ERROR_MODEL = -7,
    // A callback returned another number than 0, or gave no memory.
    TT_ERROR_CALLBACK = -8,
    // A tile does not fit the grid of 16 bits that the layout asks for, or the grid is too coarse for the tolerance.
    TT_ERROR_GRID = -9,
    // The system refused a thread.
    TT_ERROR_THREADS = -10,
    // An internal error ended the session. It can only be freed.
    TT_ERROR_LOST = -11,
    // An internal error. The words should be reported, with the file that caused it.
    TT_ERROR_PANIC = -12,
} tt_status;

// How much is told.
typedef enum {
    TT_LOG_OFF = 0,
    // Errors.
    TT_LOG_ERROR = 1,
    // And warnings.
    TT_LOG_WARN = 2,
    // And what happens once per call.
    TT_LOG_INFO = 3,
    // And the stages of each frame.
    TT_LOG_DEBUG = 4,
    // And what happens in each tile.
    TT_LOG_TRACE = 5,
} tt_log_level;

// What a call is at.
typedef enum {
    // Reading. Counts parts, once the syntax is parsed.
    TT_STAGE_READ = 0,
    // Preparing. Counts faces, each part once.
    TT_STAGE_PREPARE = 1,
    // Tessellating. Counts tiles, each part once.
    TT_STAGE_TESSELLATE = 2,
} tt_stage;

// How bad a diagnostic is.
typedef enum {
    // Nothing is lost; something was repaired or approximated.
    TT_SEVERITY_NOTE = 0,
    // Something other than geometry is lost (a colour, a name), a face differs from the file, or the mesh is coarser
    // than asked.
    TT_SEVERITY_WARNING = 1,
    // Geometry is lost or may be wrong: a face, a hole, an occurrence, the unit, or the mesh fails its check.
    TT_SEVERITY_ERROR = 2,
} tt_severity;

// Kinds of surfaces. `O` is the origin; x, y and z are the axes of the frame; angles are radians.
typedef enum {
    // `S(u,v) = O + u x + v y`; the normal is z.
    TT_PLANE = 0,
    // `S(u,v) = O + r (cos u x + sin u y) + v z`; the normal points outwards.
    TT_CYLINDER = 1,
    // `S(u,v) = O + (r + v tan a) (cos u x + sin u y) + v z`, with `a` the half angle.
    TT_CONE = 2,
    // `S(u,v) = O + r cos v (cos u x + sin u y) + r sin v z`.
    TT_SPHERE = 3,
    // `S(u,v) = O + (R + r cos v) (cos u x + sin u y) + r sin v z`, with `r` the minor radius.
    TT_TORUS = 4,
    // `S(u,v) = C(u) + v d`, with `d` the direction.
    TT_EXTRUSION = 5,
    // `S(u,v)` is `C(v)`, turned by the angle u about z through `O`.
    TT_REVOLUTION = 6,
    // A B-spline surface, rational or not.
    TT_NURBS = 7,
} tt_surface_kind;

// What a shell bounds.
typedef enum {
    // Open, not known to be closed, or loose faces.
    TT_SHELL_OPEN = 0,
    // The outer boundary of a solid: normals point outwards.
    TT_SHELL_OUTER = 1,
    // A void of a solid: normals point into the void.
    TT_SHELL_VOID = 2,
} tt_shell_kind;

// Which points of a surface free trims keep. With u to the right and v up, a curve keeps its left side.
typedef enum {
    // What lies left of all curves.
    TT_TRIM_HANDEDNESS = 0,
    // Where the winding numbers of all curves do not sum to 0.
    TT_TRIM_NON_ZERO = 1,
    // Where they sum to an odd number.
    TT_TRIM_EVEN_ODD = 2,
} tt_trim_rule;

// Format of positions. Equal positions of a part are equal in every tile, so borders stay closed.
typedef enum {
    // 3 floats, relative to the part's centre, millimetres: 12 bytes.
    TT_POSITION_F32 = 0,
    // 3 doubles, part coordinates, millimetres: 24 bytes.
    TT_POSITION_F64 = 1,
    // 4 unsigned integers of 16 bits, the last one 0: steps from the tile's corner, see `tt_tile`. 8 bytes. A frame is
    // refused with TT_ERROR_GRID if rounding would take more than a tenth of its tolerance.
    TT_POSITION_GRID = 2,
} tt_position;

// Format of normals.
typedef enum {
    // 2 normalised integers of 16 bits: octahedral coordinates, off by less than 0.01 degrees. 4 bytes.
    TT_NORMAL_OCTAHEDRAL = 0,
    // 3 floats: 12 bytes.
    TT_NORMAL_F32 = 1,
    // None.
    TT_NORMAL_NONE = 2,
} tt_normal;

// Who hears of progress.
typedef struct {
    // `sizeof(tt_progress)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Passed to `report`. Valid until the control is freed and the calls that have it returned.
    void *user;
    // Called at most once per part, face or tile, from the threads that do the work: with 0 first, then with larger
    // and larger numbers, and last with `total`. Calls come one at a time; those of several calls of the library that
    // have the same control may overlap. `stage` is a `tt_stage`; `done` is from 0 to `total`. It returns at once.
    void (*report)(void *user, uint32_t stage, uint64_t done, uint64_t total);
} tt_progress;

// Hears of the progress of calls, and stops them from another thread. One may serve several calls.
typedef struct {
    uint64_t id;
} tt_control;

// A model: parts (B-reps) in their own coordinates, and their instances. It does not change, and any number of threads
// may use it at the same time.
typedef struct {
    uint64_t id;
} tt_model;

// What a model has.
typedef struct {
    // `sizeof(tt_model_info)`.
    uint32_t size;
    // Number of parts.
    uint32_t parts;
    // Number of placed parts.
    uint32_t instances;
    // Number of diagnostics of reading.
    uint32_t diagnostics;
    // Number of faces, each part once.
    uint64_t faces;
    // Number of edges, each part once.
    uint64_t edges;
    // Length unit of the file. Lengths of the model are already millimetres.
    double millimetres_per_unit;
} tt_model_info;

// Tells of something that was not understood, repaired or lost.
typedef struct {
    // `sizeof(tt_diagnostic)`.
    uint32_t size;
    // A `tt_severity`.
    uint32_t severity;
    // 1 if the mesh is not what the file states: an error, or a warning about a face. Else 0.
    uint32_t is_fault;
    // The part concerned, or TT_NONE.
    uint32_t part;
    // The face concerned, within the part, or TT_NONE.
    uint32_t face;
    // The edge concerned, within the part, or TT_NONE.
    uint32_t edge;
    // Number of the entity in the file, or 0.
    uint64_t entity;
    // 1 if `place` is one.
    uint32_t has_place;
    // 0.
    uint32_t reserved;
    // Where, in the part's coordinates, millimetres.
    double place[3];
    // Stable name of its kind, as "face-off-surface", with a zero byte at the end. docs/diagnostics.md lists them.
    char code[64];
} tt_diagnostic;

// Work that the library gave to a pool, to be run once: `tt_job_run`. A pool that does not want it calls
// `tt_job_drop`; whoever waits for the work does it then.
typedef struct {
    uint64_t id;
} tt_job;

// One call of a loop: `of` is what `tt_jobs.each` got, `number` is below its `count`.
typedef void (*tt_body)(void *of, uint32_t number);

// A pool of threads. Jobs may run in any order, at any time, also within `spawn`. They wait at most for one that runs
// on another thread, so a pool of one thread suffices.
typedef struct {
    // `sizeof(tt_jobs)`.
    uint32_t size;
    // How many threads can work at the same time, the caller's included while it makes a frame or helps, 1 to 1024.
    uint32_t width;
    // Passed to the functions. Valid until the session is freed, or the call returns.
    void *user;
    // Takes a job, on any thread, several at the same time, and returns 0. Another number refuses the job.
    int32_t (*spawn)(void *user, tt_job job);
    // A loop, for reading and preparing: calls `body` once with each number below `count`, on any threads and in any
    // order, and returns 0 when all calls have returned. `body` may come back here: whoever waits for a loop within
    // must make calls meanwhile, or have made all of them itself. The library makes the calls that are left out.
    //
    // May be null: then the thread that reads or prepares does all the work.
    int32_t (*each)(void *user, uint32_t count, tt_body body, void *of);
} tt_jobs;

// Options of reading. Zeros are the defaults.
typedef struct {
    // `sizeof(tt_read_options)`.
    uint32_t size;
    // Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    // file.
    uint32_t threads;
    // 1 reads construction geometry that has bounds, too.
    uint32_t supplemental;
    // Syntax errors that are cut out before the file is refused; 0 = 16.
    uint32_t max_syntax_repairs;
    // Largest error of curves and surfaces that have no exact form, millimetres; 0 = 0.001.
    double fit_tolerance;
    // Length of the file at most; 0 = 2 GiB.
    uint64_t max_bytes;
    // Memory of reading at most, bytes, estimated before it is taken; 0 = 16 GiB.
    uint64_t max_memory;
    // Instances (`#n=`) in the file at most; 0 = 50 million.
    uint64_t max_entities;
    // Placed parts and assemblies at most; 0 = 1 million.
    uint64_t max_instances;
    // A pool that reads, instead of threads that end with the call; or null.
    const tt_jobs *jobs;
} tt_read_options;

// A model while it is built, by one thread at a time: another one gets TT_ERROR_BUSY.
//
// Parts, vertices, edges, shells, faces and instances have indices from 0, in the order in which they were added. What
// is wrong with numbers and gaps is told by `tt_builder_finish`.
typedef struct {
    uint64_t id;
} tt_builder;

// A NURBS curve. Knots are finite and do not decrease, inner ones repeat at most `degree` times. Weights are above 0.
typedef struct {
    // `sizeof(tt_curve)`.
    uint32_t size;
    // 1 to 60.
    uint32_t degree;
    // `count + degree + 1` of them, repeated by multiplicity.
    const double *knots;
    // `count` control points, not multiplied by weights: 3 numbers each in space, 2 in (u,v).
    const double *points;
    // `count` weights from 1e-30 to 1e30, or null for a polynomial curve.
    const double *weights;
    // Number of control points.
    size_t count;
} tt_curve;

// The surface of a face. Fields that its kind does not name are not read.
typedef struct {
    // `sizeof(tt_surface)`.
    uint32_t size;
    // A `tt_surface_kind`.
    uint32_t kind;
    // All kinds but extrusions and B-splines: where the frame is, millimetres.
    double origin[3];
    // As `origin`: the z axis, of any length above 0.
    double axis[3];
    // As `origin`: the x axis, or any direction nearest to it. Where it is along z, any perpendicular is taken.
    double reference[3];
    // Cylinders and spheres: above 0. Cones: at v = 0, 0 or more. Tori: of the ring, R, 0 or more.
    double radius;
    // Tori: of the tube, above 0.
    double minor_radius;
    // Cones: between -pi/2 and pi/2, not 0.
    double half_angle;
    // Extrusions: the sweep per unit of v.
    double direction[3];
    // Extrusions and revolutions: the curve in space.
    const tt_curve *curve;
    // B-splines: 1 to 60.
    uint32_t degree_u;
    // B-splines: 1 to 60.
    uint32_t degree_v;
    // B-splines: `count_u + degree_u + 1` knots.
    const double *knots_u;
    // B-splines: `count_v + degree_v + 1` knots.
    const double *knots_v;
    // B-splines: `count_u * count_v` control points of 3 numbers. Point (i, j) is number `i * count_v + j`.
    const double *points;
    // B-splines: weights in the same order, from 1e-30 to 1e30, or null.
    const double *weights;
    // B-splines: number of control points along u.
    size_t count_u;
    // B-splines: number of control points along v.
    size_t count_v;
} tt_surface;

// One use of an edge by a loop. Will not grow.
typedef struct {
    // The edge.
    uint32_t edge;
    // 1 if the loop runs against the edge, else 0.
    uint32_t reversed;
} tt_coedge;

// A placed part.
typedef struct {
    // `sizeof(tt_placement)`.
    uint32_t size;
    // The part.
    uint32_t part;
    // Part to world, millimetres: x, y and z axis, then the origin, 3 numbers each. A rigid motion with an optional
    // reflection and uniform scale. All zeros stand for the identity.
    double transform[12];
    // 1 if `colour` overrides the colours of the faces.
    uint32_t has_colour;
    // Red, green, blue (sRGB) and opacity, 0 to 1.
    float colour[4];
    // 0.
    uint32_t reserved;
    // Name; null for none. Copied.
    const char *name;
} tt_placement;

// A model that is ready for tessellation at any tolerance. It does not change, and any number of threads and sessions
// may use it at the same time.
typedef struct {
    uint64_t id;
} tt_prepared;

// Options of preparing. Zeros are the defaults.
typedef struct {
    // `sizeof(tt_prepare_options)`.
    uint32_t size;
    // Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    // file.
    uint32_t threads;
    // Bezier patches at most; 0 = 16 million.
    uint64_t max_patches;
    // Memory at most, bytes, estimated; 0 = 16 GiB.
    uint64_t max_memory;
    // Distance up to which borders of faces without edges, and edges of faces in open shells, become one, as a
    // fraction of the part's diagonal, up to 1; 0 = 1e-6, below 0 = they never do, which 0 says in Rust and Python.
    double border_tolerance;
    // A pool that prepares, instead of threads that end with the call; or null.
    const tt_jobs *jobs;
    // Another prepared model, of which parts that both have are taken over: faster, and the same. Or a null handle.
    tt_prepared like;
    // Whether to keep the drafts of faces, and to take over those of `like` for faces of a changed part, 0 or 1. Costs
    // memory: a seventh of the prepared model.
    uint32_t keep_faces;
    // 0.
    uint32_t reserved;
} tt_prepare_options;

// What a prepared model has.
typedef struct {
    // `sizeof(tt_prepared_info)`.
    uint32_t size;
    // Number of parts.
    uint32_t parts;
    // Number of placed parts.
    uint32_t instances;
    // Number of diagnostics, those of reading included.
    uint32_t diagnostics;
    // Number of tiles, each part once.
    uint64_t tiles;
    // 1 if something is placed, so that there are bounds.
    uint32_t has_bounds;
    // 0.
    uint32_t reserved;
    // Lower corner of the box of the placed model, millimetres, to about 0.1 %.
    double low[3];
    // Upper corner.
    double high[3];
    // Diagonal of that box.
    double diagonal;
} tt_prepared_info;

// A part.
typedef struct {
    // `sizeof(tt_part)`.
    uint32_t size;
    // Number of faces.
    uint32_t faces;
    // Number of tiles.
    uint32_t tiles;
    // 1 if it is closed, so that its meshes are, else 0.
    uint32_t closed;
    // Centre of its box, in its own coordinates, millimetres. f32 positions count from it.
    double centre[3];
    // Half the diagonal of that box.
    double radius;
} tt_part;

// A placed part. Will not grow.
typedef struct {
    // The part, or the level of detail of it that this frame draws.
    uint32_t part;
    // Index of its first face where faces are numbered across all instances.
    uint32_t first_face;
    // Part to world, millimetres: x, y and z axis, then the origin, 3 numbers each.
    double transform[12];
    // 1 if `colour` overrides the colours of the faces.
    uint32_t has_colour;
    // Red, green, blue (sRGB) and opacity, 0 to 1.
    float colour[4];
    // 1 if views do not draw it: `tt_session_set_instance`, `tt_session_set_part`.
    uint32_t hidden;
} tt_instance;

// How close a mesh is to the surfaces, and limits of its size. Numbers are finite.
typedef struct {
    // `sizeof(tt_tolerance)`.
    uint32_t size;
    // 1 makes a coarser mesh where limits do not allow the tolerance; 0 refuses with TT_ERROR_LIMIT.
    uint32_t coarsen;
    // Largest distance between triangles and surface, millimetres; 0 if `chord_rel` is given.
    double chord;
    // The same as a fraction of the diagonal of the placed model; 0 if `chord` is given.
    double chord_rel;
    // Largest turn of the normal across a lattice cell, radians; 0 = 20 degrees.
    double angle;
    // Longest diagonal of a lattice cell and segment of an edge, millimetres; 0 = any.
    double max_edge;
    // Triangles at most; 0 = 64 million.
    uint64_t max_triangles;
    // Triangles of one tile at most; 0 = 8 million.
    uint64_t max_tile_triangles;
    // Memory of mesh and prepared model at most, bytes, estimated; 0 = 16 GiB.
    uint64_t max_memory;
} tt_tolerance;

// How `tt_tessellate` works. Zeros are the defaults.
typedef struct {
    // `sizeof(tt_tessellate_options)`.
    uint32_t size;
    // Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    // file; 1 = the caller's alone.
    uint32_t threads;
    // 1 makes the polylines of edges, too.
    uint32_t edge_lines;
    // 0.
    uint32_t reserved;
} tt_tessellate_options;

// A mesh of a whole model, part by part. It does not change, and any number of threads may use it at the same time.
typedef struct {
    uint64_t id;
} tt_mesh;

// What a mesh has.
typedef struct {
    // `sizeof(tt_mesh_info)`.
    uint32_t size;
    // Number of parts, those of the prepared model.
    uint32_t parts;
    // Number of triangles, each part once.
    uint64_t triangles;
    // Number of vertices, each part once.
    uint64_t vertices;
    // Number of diagnostics of reading, preparing and tessellating.
    uint32_t diagnostics;
    // 1 if limits made the mesh coarser than the tolerance; else 0.
    uint32_t coarsened;
} tt_mesh_info;

// The mesh of a part, in its own coordinates. The arrays are valid until the mesh is freed.
typedef struct {
    // `sizeof(tt_mesh_part)`.
    uint32_t size;
    // Number of vertices. Tiles do not share vertices; equal points have equal bits.
    uint32_t vertices;
    // Number of triangles.
    uint64_t triangles;
    // 3 numbers per vertex, millimetres.
    const double *positions;
    // 3 numbers per vertex: unit normals that point outwards.
    const float *normals;
    // 2 numbers per vertex, in the natural parameters of the face's surface.
    const float *uvs;
    // 3 vertices per triangle, counter-clockwise seen from outside.
    const uint32_t *indices;
    // The face of each triangle, within the part.
    const uint32_t *faces;
    // Number of polylines.
    uint64_t lines;
} tt_mesh_part;

// The polyline of an edge.
typedef struct {
    // `sizeof(tt_line)`.
    uint32_t size;
    // The part.
    uint32_t part;
    // The edge within the part.
    uint32_t edge;
    // Number of points.
    uint32_t count;
    // 3 numbers per point, millimetres, part coordinates, from the edge's start to its end. Valid until the mesh is
    // freed; in a callback, until it returns.
    const double *points;
} tt_line;

// A camera in world coordinates, millimetres, and the error that its picture may have. All views of a call have the
// same value in the field `size`.
typedef struct {
    // `sizeof(tt_view)`.
    uint32_t size;
    // 1 for a parallel projection, 0 for perspective.
    uint32_t orthographic;
    // Where the camera is.
    double eye[3];
    // Where it looks to: a direction of any length above 0.
    double forward[3];
    // What is up in the picture: a direction, not parallel to `forward`.
    double up[3];
    // Perspective: full vertical field of view, radians, above 0 and below pi.
    double fov_y;
    // Perspective: depth of the near plane, 0 or more.
    double near;
    // Parallel: height of the visible part of the world, above 0.
    double height;
    // Size of the picture, pixels, above 0.
    uint32_t width_px;
    uint32_t height_px;
    // Largest distance in the picture between triangles and surface, pixels; 0 = 0.5.
    double deviation_px;
    // Longest diagonal of a cell or segment of an edge in the picture, pixels; 0 = any.
    double size_px;
    // Largest turn of the normal across a cell, radians; 0 = 30 degrees.
    double angle;
} tt_view;

// Attributes of a vertex, in this order, little-endian, without gaps. Zeros are 16 bytes per vertex: f32 positions and
// octahedral normals, with indices of 16 bits where they suffice.
typedef struct {
    // `sizeof(tt_layout)`.
    uint32_t size;
    // A `tt_position`.
    uint32_t position;
    // A `tt_normal`.
    uint32_t normal;
    // 1 adds parameters: 2 floats, in the natural parameters of the face's surface.
    uint32_t uv;
    // 1 adds a tangent: 3 floats, of unit length, in the direction in which u increases; zero where that has none.
    uint32_t tangent;
    // 1 adds where the vertex comes from: 3 unsigned integers of 32 bits. The first is 0 for a lattice point (line of
    // u, line of v), 1 for a point of an edge (edge, index along it), 2 for a crossing of boundaries, 3 for a point
    // within, 4 for a border between tiles (border, index along it).
    uint32_t origin;
    // 1 makes all indices 32 bits wide; 0 only those of tiles with more than 65535 vertices. So no index of 16 bits is
    // 65535, at which WebGL 2 restarts primitives.
    uint32_t wide_indices;
    // 0.
    uint32_t reserved;
} tt_layout;

// Options of a session. Zeros are the defaults.
typedef struct {
    // `sizeof(tt_session_options)`.
    uint32_t size;
    // Number of workers, which own the tiles, at most 4096; 0 = four per thread, or one if there is one thread.
    uint32_t workers;
    // 1 starts no thread: all work is done by the calls of the session.
    uint32_t no_threads;
    // 1 sends the polylines of edges, too.
    uint32_t edge_lines;
    // Levels of detail that a part with several instances may have at most; 0 = 4.
    uint32_t levels;
    // Deals tiles to workers again every so many frames of views, by measured times; 0 = never.
    uint32_t rebalance_every;
    // 1 leaves out tiles of closed parts that face away from all cameras. Right as long as no camera is within a part,
    // and the near plane clips none.
    uint32_t cull_back_faces;
    // Number of threads that make a frame, at most 1024; 0 = one per core, see "Threads" at the head of this file. The
    // caller is one of them while it waits for the frame, so the session starts one less, but at least one. A caller
    // who only polls (`tt_session_finish_within`) does no work, and asks for one more. Must be 0 with jobs, and with
    // `no_threads`.
    uint32_t threads;
    // Time that the tiles of a frame of views may take, seconds of one worker, as predicted. Changes beyond it wait
    // for the next frame. 0 = any.
    double budget;
    // Triangles of a frame at most, as counted before they are made: two per lattice cell and two per point of an
    // edge, each part once; frames have about half as many. 0 = 64 million. Frames of views are coarser beyond this
    // and the next two limits, see `tt_report.coarsened`.
    uint64_t max_triangles;
    // Triangles of one tile at most; 0 = 8 million.
    uint64_t max_tile_triangles;
    // Memory of a frame at most, bytes, estimated; 0 = 16 GiB.
    uint64_t max_memory;
    // Bytes of tiles that the sink may hold; 0 = any. Beyond it, tiles that no view draws are evicted, the oldest
    // first, in steps of 64 frames. Tiles of a frame count from the next one on.
    uint64_t resident_bytes;
} tt_session_options;

// Workers for one prepared model, and one sink that they keep up to date.
//
// One thread at a time uses it, any: a call that comes while another one is in progress, also from a callback of that
// one, returns TT_ERROR_BUSY and does nothing.
typedef struct {
    uint64_t id;
} tt_session;

// A tile, as callbacks get it. Pointers are valid until the callback returns.
typedef struct {
    // `sizeof(tt_tile)` of the library.
    uint32_t size;
    // The part, or the level of detail of one, see `tt_scene`.
    uint32_t part;
    // The face within the part.
    uint32_t face;
    // The tile within the part.
    uint32_t tile;
    // The worker that made it, from 0. This and `place` alone depend on who works.
    uint32_t worker;
    // Number of vertices.
    uint32_t vertices;
    // Number of triangles. 0: the tile is gone, and has no place.
    uint32_t triangles;
    // Bytes of an index: 2 or 4. There are 3 indices per triangle, which count from the tile's first vertex.
    uint32_t index_bytes;
    // Bytes of a vertex; 0 in sessions without a layout.
    uint32_t stride;
    // 1 with TT_POSITION_GRID: the coordinates k mean the position `centre + step * (corner + k)`, where `centre` is
    // the part's.
    uint32_t has_grid;
    int32_t corner[3];
    // 0.
    uint32_t reserved;
    // A power of two, millimetres.
    double step;
    // What `tt_memory.room` gave for it.
    uint64_t place;
    // Sessions without a layout: 3 numbers per vertex, millimetres, part coordinates. Else null, as those below.
    const double *positions;
    // 3 numbers per vertex: unit normals that point outwards.
    const float *normals;
    // 2 numbers per vertex, in the natural parameters of the face's surface.
    const float *uvs;
    // 3 per triangle, counter-clockwise seen from outside.
    const uint32_t *indices;
} tt_tile;

// Room for a tile: what `tt_memory.room` fills in.
typedef struct {
    // `sizeof(tt_room)` of the library.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Room for `vertices * stride` bytes, of any alignment. The library writes each byte once, in order, and reads
    // none.
    void *vertices;
    // Room for `3 * triangles * index_bytes` bytes.
    void *indices;
    // Any number by which the caller finds the room: it becomes the tile's `place`.
    uint64_t place;
} tt_room;

// Where the memory of tiles comes from. Its functions are called by workers, on any thread, several at the same time,
// each for its own tiles. They make no call of the session.
typedef struct {
    // `sizeof(tt_memory)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Passed to the functions. Valid until the session is freed, or writes elsewhere.
    void *user;
    // Fills in the room for a tile, and returns 0. It is written after this returned, until `tt_sink.tile` hears of
    // the tile, or `release` does. Another number refuses: the frame is not committed, its tiles are part of the next
    // one.
    int32_t (*room)(void *user, const tt_tile *tile, tt_room *room);
    // Takes back the room of a tile of which the sink never hears, because its frame was cancelled or refused.
    void (*release)(void *user, const tt_tile *tile);
} tt_memory;

// What a frame shows, as `tt_sink.begin` gets it. Pointers are valid until the callback returns.
typedef struct {
    // `sizeof(tt_scene)` of the library.
    uint32_t size;
    // 1 if the frame replaces everything sent before; 0 if it equals the last frame except for what is sent now.
    uint32_t whole;
    // Number of parts: those of the prepared model, then further levels of detail. They stay, and others may follow,
    // until `tt_session_update`.
    uint32_t parts;
    // Number of instances.
    uint32_t instances;
    // For each part the part of the prepared model of which it is another level of detail; TT_NONE for those
    // themselves. Levels have the tiles, the centre and the faces of their part.
    const uint32_t *mesh_of;
    // The instances. Each names the level of detail that it draws.
    const tt_instance *placed;
    // In the first frame after `tt_session_update`, if it is not a whole one: for each part the part of the last frame
    // whose tiles and lines it starts with, TT_NONE if it starts with none. None is named twice; tiles and lines of
    // parts that are not named go. Null in other frames.
    const uint32_t *from;
    // The keys of the instances, which the session's functions take; 0 in frames by a tolerance.
    const uint64_t *keys;
    // The first part that is new. All later ones are. 0 in a whole frame, and where `from` tells.
    uint32_t first_part;
    // The first instance that is new. All later ones are. Those before it were in the last frame, in the same order.
    uint32_t first_instance;
    // Number of `removed`.
    uint32_t removed_count;
    // Number of `changed`.
    uint32_t changed_count;
    // Keys of instances of the last frame that are gone, each once.
    const uint64_t *removed;
    // Indices of instances of the last frame whose level of detail, transform, colour or `hidden` may differ,
    // ascending. `first_face` differs after removed ones, too; these are not listed.
    const uint32_t *changed;
} tt_scene;

// The tiles that an instance draws in a view.
typedef struct {
    uint32_t view;
    // One of those of `tt_scene`.
    uint32_t instance;
    // Where its words start.
    uint32_t start;
    // Number of its words, at least 1. Tiles beyond them are not drawn.
    uint32_t count;
} tt_drawn_row;

// The tiles to draw, as `tt_sink.drawn` gets them. Pointers are valid until the callback returns.
typedef struct {
    // `sizeof(tt_drawn)` of the library.
    uint32_t size;
    // 1 if every instance draws all of its tiles in every view; there are no rows then.
    uint32_t everything;
    // Number of views.
    uint32_t views;
    // Number of `rows`.
    uint32_t count;
    // What each instance draws that draws anything, by view, then by instance.
    const tt_drawn_row *rows;
    // Bits of tiles: tile t of an instance is bit `t % 64` of word `t / 64` of its row, the lowest bit first.
    const uint64_t *words;
    // Number of `appeared`.
    uint32_t appeared_count;
    // Number of `disappeared`.
    uint32_t disappeared_count;
    // The tiles among these that the last frame did not draw, as `rows`. Their bits are in `words`, too.
    const tt_drawn_row *appeared;
    // The tiles that the last frame drew and this one does not, as `rows`: those of instances that there still are, by
    // their indices now. An instance with another level of detail draws the tiles of that, also those that are in
    // neither list.
    const tt_drawn_row *disappeared;
} tt_drawn;

// Who receives frames. Calls come on the thread that called the session, before that call returns, in this order:
// `begin`, `tile`, `line` by (part, edge), `drawn`, then `end` or `abort`. Tiles come by (part, tile); in sessions
// with a layout first those that are evicted, then those of each worker, of which some may be gone, too. A frame in
// which nothing changes has no calls.
//
// A function that returns another number than 0 refuses the frame: `abort` is called, the session's call returns
// TT_ERROR_CALLBACK, and the next frame is a whole one. All but `tile` may be null.
typedef struct {
    // `sizeof(tt_sink)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Passed to the functions.
    void *user;
    // Starts a frame.
    int32_t (*begin)(void *user, const tt_scene *scene);
    // Receives a tile, which replaces the one of the same part and number. One without triangles is gone. In sessions
    // with a layout its room is the sink's from now on, also if this refuses it.
    int32_t (*tile)(void *user, const tt_tile *tile);
    // Receives the polyline of an edge, which replaces the one of the same part and edge.
    int32_t (*line)(void *user, const tt_line *line);
    // Receives the tiles to draw, once per frame of views. There are no cracks between them; tiles that are not drawn
    // may be several frames old. Frames by a tolerance draw everything and skip this.
    int32_t (*drawn)(void *user, const tt_drawn *drawn);
    // Completes the frame.
    int32_t (*end)(void *user);
    // Discards the frame, and all before it.
    void (*abort)(void *user);
} tt_sink;

// What a frame took.
typedef struct {
    // `sizeof(tt_report)`.
    uint32_t size;
    // 1 if the sink got a whole frame rather than changes.
    uint32_t whole;
    // Number of the frame within its session, from 0. A frame in which nothing changed has the number of the next one
    // in which something does.
    uint64_t frame;
    // Tiles made.
    uint64_t tiles;
    // Tiles with triangles that were sent.
    uint64_t sent;
    // Triangles of these.
    uint64_t triangles;
    // Tiles evicted from the sink that no view draws.
    uint64_t evicted;
    // Tiles whose change waits for the next frame, because the budget was spent.
    uint64_t deferred;
    // Tiles that are not as they should be.
    uint64_t degraded;
    // Seconds to make the plan; 0 for frames by a tolerance.
    double planned_in;
    // Seconds from the order to the last tile.
    double made_in;
    // Seconds from the last tile to the end of the sink's calls.
    double committed_in;
    // 1 if limits made the frame coarser than its views or its tolerance ask, also where nothing changed; else 0.
    uint32_t coarsened;
    // 0.
    uint32_t reserved;
    // Triangles that it needs at most to be as fine, if limits on all of its triangles or on memory made it coarser;
    // else 0.
    uint64_t needed;
} tt_report;

// What a session has.
typedef struct {
    // `sizeof(tt_session_info)`.
    uint32_t size;
    // Number of workers.
    uint32_t workers;
    // Number of parts and further levels of detail.
    uint32_t parts;
    // Number of instances.
    uint32_t instances;
    // 1 if `tt_session_finish` would return without waiting: the frame is made, or none was begun.
    uint32_t is_made;
    // Tiles that are not as they should be, of those that the sink of frames of views has.
    uint32_t degraded;
} tt_session_info;

// How views draw a part, or an instance. Zeros are the defaults. Attributes of an instance and of its part are
// combined.
typedef struct {
    // `sizeof(tt_attributes)`.
    uint32_t size;
    // 1 if no view draws it. An instance is drawn if neither it nor its part is hidden. What is hidden asks for no
    // tiles.
    uint32_t hidden;
    // 1 if `colour` is drawn instead of the colours of the model. An instance's overrides its part's.
    uint32_t has_colour;
    // Red, green, blue (sRGB) and opacity, 0 to 1.
    float colour[4];
    // 0.
    uint32_t reserved;
    // Factor on `deviation_px` and `size_px` of all views, not on `angle`: 0.5 is twice as fine; 0 = 1. Those of an
    // instance and its part are multiplied; products below 1e-6 and above 1e6 count as these. Instances that share a
    // level of detail are as fine as the strictest of them needs.
    double tolerance_scale;
    // Factor on the error by which tiles are ordered while `tt_session_options.budget` defers some; 0 = 1. Those of an
    // instance and its part are multiplied. Instances that share a level of detail share the largest of those in view.
    double priority;
} tt_attributes;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Words of the last failure on this thread, UTF-8; empty if there was none. Never null. Valid until a call on this
// thread fails, or the thread ends.
const char *tt_last_error(void);

// Version of the library, as "0.1.0".
const char *tt_version(void);

// Number of handles that were given and not freed, of all kinds and threads: 0 at the end of a program without leaks.
uint64_t tt_live_handles(void);

// Sets the process's log callback, and the level up to which it is called (`tt_log_level`). Null, or TT_LOG_OFF, ends
// the log; once this returns, the callback before is not called any more.
//
// The callback runs on any thread, on several at the same time. It returns at once and makes no `tt_` call. `text` is
// UTF-8 and valid during the callback.
tt_status tt_set_log(uint32_t level, void (*log)(void *user, uint32_t level, const char *text), void *user);

// Makes a control. `progress` may be null: then it only stops work.
tt_status tt_control_new(const tt_progress *progress, tt_control *control);

// Asks the calls that have this control to stop, those to come too. They end with TT_ERROR_CANCELLED after the part,
// face or tile in hand. May be called from any thread, also from within a callback.
tt_status tt_control_cancel(tt_control control);

// Frees a control. Calls that have it go on.
tt_status tt_control_free(tt_control control);

// Makes a small model by name: "square", "box", "cylinder", "washer", "cone", "sphere", "torus", "wave", "pair" (two
// parts, three instances) or "flower". For tests and examples.
tt_status tt_model_shape(const char *name, tt_model *model);

// Counts what a model has.
tt_status tt_model_get_info(tt_model model, tt_model_info *info);

// Copies the name of a model into `text`, see "Texts" at the head of this file.
tt_status tt_model_get_name(tt_model model, char *text, size_t capacity, size_t *length);

// Copies the name of a part into `text`.
tt_status tt_model_get_part_name(tt_model model, uint32_t part, char *text, size_t capacity, size_t *length);

// Copies the name of an instance into `text`.
tt_status tt_model_get_instance_name(tt_model model, uint32_t instance, char *text, size_t capacity, size_t *length);

// Gives a diagnostic of reading, and copies its message into `text`. `diagnostic` may be null.
tt_status tt_model_get_diagnostic(tt_model model,
                                  uint32_t index,
                                  tt_diagnostic *diagnostic,
                                  char *text,
                                  size_t capacity,
                                  size_t *length);

// Frees a model. Calls that use it, and what was prepared from it, go on.
tt_status tt_model_free(tt_model model);

// Reads a STEP file. What cannot be read is left out and told in diagnostics; the rest is read all the same.
//
// `path` is UTF-8. `options` may be null, `control` a handle of zeros.
tt_status tt_read_file(const char *path, const tt_read_options *options, tt_control control, tt_model *model);

// Reads the content of a STEP file, as `tt_read_file`. `name` becomes the model's; it may be null. The bytes may be
// freed once this returns.
tt_status tt_read_memory(const void *bytes,
                         size_t count,
                         const char *name,
                         const tt_read_options *options,
                         tt_control control,
                         tt_model *model);

// Starts a model. `name` may be null.
tt_status tt_builder_new(const char *name, tt_builder *builder);

// Adds a part. `name` and `part` may be null.
tt_status tt_builder_add_part(tt_builder builder, const char *name, uint32_t *part);

// Adds a vertex, millimetres. `vertex`, as all pointers to an index in these functions, may be null.
tt_status tt_builder_add_vertex(tt_builder builder, uint32_t part, double x, double y, double z, uint32_t *vertex);

// Adds a straight edge between two vertices.
tt_status tt_builder_add_line(tt_builder builder, uint32_t part, uint32_t start, uint32_t end, uint32_t *edge);

// Adds a full circle about `axis` through `origin`, with a new vertex at `radius` in the direction of `reference`. Its
// vertex is the last one then. The three point to 3 numbers each.
tt_status tt_builder_add_circle(tt_builder builder,
                                uint32_t part,
                                const double *origin,
                                const double *axis,
                                const double *reference,
                                double radius,
                                uint32_t *edge);

// Adds an edge along the whole of a curve in space, which starts and ends at these vertices.
tt_status tt_builder_add_edge(tt_builder builder,
                              uint32_t part,
                              const tt_curve *curve,
                              uint32_t start,
                              uint32_t end,
                              uint32_t *edge);

// Adds a shell. `kind` is a `tt_shell_kind`. Faces of one shell are oriented together.
tt_status tt_builder_add_shell(tt_builder builder, uint32_t part, uint32_t kind, uint32_t *shell);

// Adds a face, which is the whole surface until loops or trims are added. `reversed` is 1 if its outward normal is
// opposite to the surface's, else 0.
tt_status tt_builder_add_face(tt_builder builder,
                              uint32_t part,
                              const tt_surface *surface,
                              uint32_t shell,
                              uint32_t reversed,
                              uint32_t *face);

// Sets the colour of a face: red, green, blue (sRGB) and opacity, 0 to 1.
tt_status tt_builder_set_colour(tt_builder builder,
                                uint32_t part,
                                uint32_t face,
                                float red,
                                float green,
                                float blue,
                                float opacity);

// Bounds a face by edges, head to tail and closed; it lies left of them, seen from the tip of the surface's normal.
tt_status tt_builder_add_loop(tt_builder builder, uint32_t part, uint32_t face, const tt_coedge *coedges, size_t count);

// Bounds a face at a single point, as an apex.
tt_status tt_builder_add_vertex_loop(tt_builder builder, uint32_t part, uint32_t face, uint32_t vertex);

// Trims a face by a curve in (u,v), open or closed. `rule` is a `tt_trim_rule`; that of the last trim holds for all
// trims of the face. A face has loops or trims, not both.
tt_status tt_builder_add_trim(tt_builder builder, uint32_t part, uint32_t face, uint32_t rule, const tt_curve *curve);

// Trims a face by straight lines through `count` points in (u,v), 2 numbers each, as `tt_builder_add_trim`. Repeat the
// first point to close them.
tt_status tt_builder_add_polyline_trim(tt_builder builder,
                                       uint32_t part,
                                       uint32_t face,
                                       uint32_t rule,
                                       const double *points,
                                       size_t count);

// Places a part.
tt_status tt_builder_place(tt_builder builder, const tt_placement *placement, uint32_t *instance);

// Makes the model as built so far, if it is a valid one. The builder stays, and may be used on. Costs a copy.
tt_status tt_builder_finish(tt_builder builder, tt_model *model);

// Frees a builder, unless another call uses it. Models that it made stay.
tt_status tt_builder_free(tt_builder builder);

// Prepares a model for tessellation, once for all tolerances. The model stays. About 20 to 200 microseconds per face,
// divided among threads.
tt_status tt_prepare(tt_model model, const tt_prepare_options *options, tt_control control, tt_prepared *prepared);

// Counts and measures a prepared model.
tt_status tt_prepared_get_info(tt_prepared prepared, tt_prepared_info *info);

// Describes a part.
tt_status tt_prepared_get_part(tt_prepared prepared, uint32_t index, tt_part *part);

// Copies the name of a part into `text`.
tt_status tt_prepared_get_part_name(tt_prepared prepared, uint32_t index, char *text, size_t capacity, size_t *length);

// Gives the colour of a face, its own or its part's: red, green, blue (sRGB) and opacity, 0 to 1. `colour` has room
// for 4 numbers. `has_colour` gets 0 where the file states none; `colour` is not written then.
tt_status tt_prepared_get_face_colour(tt_prepared prepared,
                                      uint32_t part,
                                      uint32_t face,
                                      uint32_t *has_colour,
                                      float *colour);

// Describes an instance. `instance` need not be set before.
tt_status tt_prepared_get_instance(tt_prepared prepared, uint32_t index, tt_instance *instance);

// Copies the name of an instance into `text`.
tt_status tt_prepared_get_instance_name(tt_prepared prepared,
                                        uint32_t index,
                                        char *text,
                                        size_t capacity,
                                        size_t *length);

// Gives a diagnostic of reading and preparing, and copies its message into `text`. `diagnostic` may be null.
tt_status tt_prepared_get_diagnostic(tt_prepared prepared,
                                     uint32_t index,
                                     tt_diagnostic *diagnostic,
                                     char *text,
                                     size_t capacity,
                                     size_t *length);

// Frees a prepared model. Calls and sessions that use it go on.
tt_status tt_prepared_free(tt_prepared prepared);

// Tessellates a whole model within a tolerance. The mesh is the same for any number of threads, byte by byte.
//
// The mesh is kept as arrays per part: about 115 bytes per triangle while it is made, and half of that afterwards.
// Tiles may go into the caller's own memory and layout instead, by `tt_session_tessellate`.
tt_status tt_tessellate(tt_prepared prepared,
                        const tt_tolerance *tolerance,
                        const tt_tessellate_options *options,
                        tt_control control,
                        tt_mesh *mesh);

// Counts what a mesh has.
tt_status tt_mesh_get_info(tt_mesh mesh, tt_mesh_info *info);

// Gives the arrays of a part. Copies nothing.
tt_status tt_mesh_get_part(tt_mesh mesh, uint32_t index, tt_mesh_part *part);

// Gives the polyline of an edge of a part, by its index among those of the part. Copies nothing.
tt_status tt_mesh_get_line(tt_mesh mesh, uint32_t part, uint64_t index, tt_line *line);

// Gives a diagnostic of reading, preparing and tessellating, and copies its message into `text`. `diagnostic` may be
// null.
tt_status tt_mesh_get_diagnostic(tt_mesh mesh,
                                 uint32_t index,
                                 tt_diagnostic *diagnostic,
                                 char *text,
                                 size_t capacity,
                                 size_t *length);

// Frees a mesh, and its arrays with it.
tt_status tt_mesh_free(tt_mesh mesh);

// Sets the camera of `view` to place `frame` of `frames` along a closed path around a prepared model: "orbit", "zoom",
// "walk" or "glu", those of the program `trimtess bench`. Its picture stays as it is; only `size` has to be set
// before.
tt_status tt_view_along_path(tt_prepared prepared, const char *path, uint32_t frame, uint32_t frames, tt_view *view);

// Sets the camera and the picture of `view` to those of an engine. Its limits of errors stay; only `size` has to be
// set before.
//
// `matrix` has 16 numbers, column after column: projection times view, from millimetres in the world to clip space,
// where x points right, y up and w forwards. The row of z is not read: depth may have any convention, and `near` is 0.
// For metres, multiply by a scale of 0.001 on the right; for a y that points down, negate the row of y.
//
// The middle of the picture may be off the axis, as for an eye of a headset: `view` has the picture about the axis
// around it, of pixels of the same size. It is larger, by steps of 16 pixels.
tt_status tt_view_from_matrix(const double *matrix, uint32_t width_px, uint32_t height_px, tt_view *view);

// Bytes from one vertex to the next.
tt_status tt_layout_get_stride(const tt_layout *layout, uint32_t *stride);

// Runs a job, on this thread. Its handle ends.
tt_status tt_job_run(tt_job job);

// Drops a job. Its handle ends.
tt_status tt_job_drop(tt_job job);

// Starts a session. It keeps the prepared model alive.
//
// `options` may be null. `jobs` may be null: then the session starts threads of its own, which end when it is freed.
tt_status tt_session_new(tt_prepared prepared,
                         const tt_session_options *options,
                         const tt_jobs *jobs,
                         tt_session *session);

// Goes on with another prepared model: one of a file that has changed, prepared with `tt_prepare_options.like`. The
// next frame of views has the tiles that differ, and `tt_scene.from` tells which parts are which. Its instances
// replace all others; keys from before name none. Cancels a frame that was begun, and waits for its tiles in progress.
tt_status tt_session_update(tt_session session, tt_prepared prepared);

// Has workers write tiles into the caller's memory, in its layout, from the next frame on, which is a whole one. The
// sink then gets tiles with a `place` and without arrays. `layout` may be null. Cancels a frame that was begun, and
// waits for its tiles in progress.
tt_status tt_session_write_into(tt_session session, const tt_layout *layout, const tt_memory *memory);

// Begins a frame for all these views together: one picture, both eyes, shadow maps. A job plans and makes it; this
// returns at once, unless `no_threads` is 1 or `tt_jobs.spawn` runs the job itself: then it makes the frame. Cancels a
// frame that was begun and not finished; its changes become part of this one.
tt_status tt_session_begin(tt_session session, const tt_view *views, size_t count);

// Makes the frame that was begun, or helps those that make it, then brings the sink up to date. Without a frame that
// was begun, does nothing. `report` may be null.
//
// The sink must be that of the frames before; after another one, or an emptied one, call `tt_session_forget`.
tt_status tt_session_finish(tt_session session, const tt_sink *sink, tt_report *report);

// As `tt_session_finish`, but waits no longer than so many seconds: TT_PENDING if the frame is not made by then, and
// the sink keeps the last one. Makes no part of the frame on this thread.
tt_status tt_session_finish_within(tt_session session, double seconds, const tt_sink *sink, tt_report *report);

// `tt_session_begin` and `tt_session_finish`.
tt_status tt_session_view(tt_session session,
                          const tt_view *views,
                          size_t count,
                          const tt_sink *sink,
                          tt_report *report);

// Tessellates the whole model within a tolerance, as `tt_tessellate`, into a sink, and into the caller's memory if the
// session writes there. The next frame of views is a whole one. `report` may be null.
tt_status tt_session_tessellate(tt_session session,
                                const tt_tolerance *tolerance,
                                tt_control control,
                                const tt_sink *sink,
                                tt_report *report);

// Cancels the frame that was begun, if any, after the tile in hand. Does not wait.
tt_status tt_session_cancel(tt_session session);

// Makes the next frame of views a whole one, for a new or emptied sink. Cancels a frame that was begun, and waits for
// its tiles in progress.
tt_status tt_session_forget(tt_session session);

// Counts what a session has.
tt_status tt_session_get_info(tt_session session, tt_session_info *info);

// Describes an instance, with the level of detail, the colour and `hidden` of the last frame that a call has waited
// for, cancelled or not, or of the last call since then that added or removed an instance or updated the model.
// `instance` need not be set before.
tt_status tt_session_get_instance(tt_session session, uint32_t index, tt_instance *instance);

// The key of an instance, which stays the same when other instances come and go. Keys of removed instances are not
// given again.
tt_status tt_session_get_instance_key(tt_session session, uint32_t index, uint64_t *key);

// The index of the instance of a key, from the next frame of views on.
tt_status tt_session_find_instance(tt_session session, uint64_t key, uint32_t *index);

// Adds an instance of a part of the prepared model, from the next frame of views on. Its index is the last. Cancels a
// frame that was begun, and waits for its tiles in progress. `key` may be null.
tt_status tt_session_add_instance(tt_session session, const tt_placement *placement, uint64_t *key);

// Removes an instance from the next frame of views on. Indices of later ones decrease by one. Cancels a frame that was
// begun, and waits for its tiles in progress.
tt_status tt_session_remove_instance(tt_session session, uint64_t key);

// Removes `count` instances in one pass, as tt_session_remove_instance removes one. If one was removed before, or is
// named twice, nothing changes.
tt_status tt_session_remove_instances(tt_session session, const uint64_t *keys, size_t count);

// Moves an instance from the next frame of views on: `transform` has 12 numbers, as in `tt_placement`. A frame that
// was begun goes on.
tt_status tt_session_move_instance(tt_session session, uint64_t key, const double *transform);

// Frees a session, unless another call uses it. Cancels and awaits a frame that was begun. Once this returned TT_OK,
// no callback of the session is called any more. Jobs of it that a pool still has free memory at most, and end their
// handles.
tt_status tt_session_free(tt_session session);

// Sets how views draw a part of the prepared model, from the next frame on: all its instances, together with their own
// attributes. Replaces what was set before. `attributes` may be null for the defaults. A frame that was begun goes on
// without them.
tt_status tt_session_set_part(tt_session session, uint32_t part, const tt_attributes *attributes);

// As `tt_session_set_part`, of one instance.
tt_status tt_session_set_instance(tt_session session, uint64_t key, const tt_attributes *attributes);

// Tells the attributes that a part of the prepared model has.
tt_status tt_session_get_part_attributes(tt_session session, uint32_t part, tt_attributes *attributes);

// Tells the attributes that an instance has, without those of its part.
tt_status tt_session_get_instance_attributes(tt_session session, uint64_t key, tt_attributes *attributes);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRIMTESS_H */
