// trimtess for C++17: the handles of trimtess.h as objects that free themselves, errors as exceptions, callbacks as
// std::function. docs/c.md has an example, capi/examples/jobs.cpp is one.
//
// Exceptions of callbacks do not cross the library: they refuse the frame (or cancel the call, or are ignored where it
// says so), and the call that they belong to throws them again, once the library has returned.
#ifndef TRIMTESS_HPP
#define TRIMTESS_HPP

#include "trimtess.h"

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace trimtess {

/// A call that failed: its status, and tt_last_error as what().
class Error : public std::runtime_error {
public:
    Error(tt_status status, const std::string &words) : std::runtime_error(words), status_(status) {}
    tt_status status() const noexcept { return status_; }

private:
    tt_status status_;
};

/// Throws unless a call succeeded. Returns its status, which is TT_OK or TT_PENDING.
inline tt_status check(tt_status status) {
    if (status < TT_OK) throw Error(status, tt_last_error());
    return status;
}

/// A struct of the interface with its size set, and zeros.
template <class T> T sized() {
    T value{};
    value.size = sizeof(T);
    return value;
}

/// Owns a handle. Moves, does not copy.
template <class Handle, tt_status (*Free)(Handle)> class Owned {
public:
    Owned() = default;
    explicit Owned(Handle handle) noexcept : handle_(handle) {}
    Owned(Owned &&other) noexcept : handle_(std::exchange(other.handle_, Handle{})) {}
    Owned &operator=(Owned &&other) noexcept {
        if (this != &other) {
            reset();
            handle_ = std::exchange(other.handle_, Handle{});
        }
        return *this;
    }
    ~Owned() { reset(); }

    Handle get() const noexcept { return handle_; }
    explicit operator bool() const noexcept { return handle_.id != 0; }
    /// Frees it. False if a call uses it: then it is not freed, and callbacks may still come.
    bool reset() noexcept {
        const bool freed = Free(handle_) != TT_ERROR_BUSY;
        handle_ = Handle{};
        return freed;
    }
    Handle *fill() noexcept {
        reset();
        return &handle_;
    }

private:
    Handle handle_{};
};

namespace detail {

/// The text that a function copies into a buffer.
template <class Get> std::string text(Get get) {
    std::size_t length = 0;
    check(get(nullptr, std::size_t{0}, &length));
    std::string text(length + 1, '\0');
    check(get(text.data(), text.size(), &length));
    text.resize(length);
    return text;
}

/// The first exception of callbacks, from any thread.
class Caught {
public:
    void keep() noexcept {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (!first_) first_ = std::current_exception();
    }
    void rethrow() {
        std::exception_ptr first;
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            std::swap(first, first_);
        }
        if (first) std::rethrow_exception(first);
    }
    /// Forgets the exception of a call that nobody waits for.
    void forget() noexcept {
        const std::lock_guard<std::mutex> lock(mutex_);
        first_ = nullptr;
    }
    /// As trimtess::check, but throws the exception of a callback instead of the error that it became.
    tt_status check(tt_status status) {
        rethrow();
        return trimtess::check(status);
    }

private:
    std::mutex mutex_;
    std::exception_ptr first_;
};

/// Calls a function of callbacks: 0, or 1 and the exception is kept.
template <class Call> std::int32_t guarded(Caught &caught, Call call) noexcept {
    try {
        call();
        return 0;
    } catch (...) {
        caught.keep();
        return 1;
    }
}

} // namespace detail

/// Hears of progress, and cancels. An exception of `report` cancels the call, which throws it again.
class Control {
public:
    using Report = std::function<void(tt_stage stage, std::uint64_t done, std::uint64_t total)>;

    Control() { check(tt_control_new(nullptr, handle_.fill())); }
    explicit Control(Report report) : state_(std::make_unique<State>()) {
        state_->report = std::move(report);
        auto progress = sized<tt_progress>();
        progress.user = state_.get();
        progress.report = [](void *user, std::uint32_t stage, std::uint64_t done, std::uint64_t total) {
            auto &state = *static_cast<State *>(user);
            const auto report = [&] { state.report(static_cast<tt_stage>(stage), done, total); };
            if (detail::guarded(state.caught, report) != 0) tt_control_cancel(state.handle);
        };
        check(tt_control_new(&progress, handle_.fill()));
        state_->handle = handle_.get();
    }
    void cancel() { check(tt_control_cancel(handle_.get())); }
    tt_control get() const noexcept { return handle_.get(); }
    tt_status check_call(tt_status status) const { return state_ ? state_->caught.check(status) : check(status); }

private:
    struct State {
        Report report;
        tt_control handle{};
        detail::Caught caught;
    };
    std::unique_ptr<State> state_;
    Owned<tt_control, tt_control_free> handle_;
};

/// A diagnostic with its message.
struct Diagnostic {
    tt_diagnostic data = sized<tt_diagnostic>();
    std::string message;
};

namespace detail {

template <class Handle, class Get> std::vector<Diagnostic> diagnostics(Handle handle, std::uint32_t count, Get get) {
    std::vector<Diagnostic> all(count);
    for (std::uint32_t k = 0; k < count; k++) {
        all[k].message = text([&](char *to, std::size_t capacity, std::size_t *length) {
            return get(handle, k, &all[k].data, to, capacity, length);
        });
    }
    return all;
}

/// The control of a call that may have none.
inline tt_control handle_of(const Control *control) { return control ? control->get() : tt_control{}; }
inline void check_with(const Control *control, tt_status status) {
    if (control) control->check_call(status);
    else check(status);
}

} // namespace detail

/// Parts and instances, as read or built.
class Model {
public:
    static Model read_file(const std::string &path, const tt_read_options *options = nullptr,
                           const Control *control = nullptr) {
        Model model;
        const auto handle = detail::handle_of(control);
        detail::check_with(control, tt_read_file(path.c_str(), options, handle, model.handle_.fill()));
        return model;
    }
    static Model read_memory(const void *bytes, std::size_t count, const std::string &name = {},
                             const tt_read_options *options = nullptr, const Control *control = nullptr) {
        Model model;
        const auto handle = detail::handle_of(control);
        const auto status = tt_read_memory(bytes, count, name.c_str(), options, handle, model.handle_.fill());
        detail::check_with(control, status);
        return model;
    }
    /// A small model by name.
    static Model shape(const std::string &name) {
        Model model;
        check(tt_model_shape(name.c_str(), model.handle_.fill()));
        return model;
    }
    static Model take(tt_model handle) noexcept {
        Model model;
        *model.handle_.fill() = handle;
        return model;
    }
    tt_model_info info() const {
        auto info = sized<tt_model_info>();
        check(tt_model_get_info(get(), &info));
        return info;
    }
    std::string name() const {
        return detail::text([&](char *to, std::size_t capacity, std::size_t *length) {
            return tt_model_get_name(get(), to, capacity, length);
        });
    }
    std::vector<Diagnostic> diagnostics() const {
        return detail::diagnostics(get(), info().diagnostics, tt_model_get_diagnostic);
    }
    tt_model get() const noexcept { return handle_.get(); }

private:
    Owned<tt_model, tt_model_free> handle_;
};

/// A model ready for tessellation.
class Prepared {
public:
    explicit Prepared(const Model &model, const tt_prepare_options *options = nullptr,
                      const Control *control = nullptr) {
        const auto handle = detail::handle_of(control);
        detail::check_with(control, tt_prepare(model.get(), options, handle, handle_.fill()));
    }
    tt_prepared_info info() const {
        auto info = sized<tt_prepared_info>();
        check(tt_prepared_get_info(get(), &info));
        return info;
    }
    std::vector<Diagnostic> diagnostics() const {
        return detail::diagnostics(get(), info().diagnostics, tt_prepared_get_diagnostic);
    }
    tt_prepared get() const noexcept { return handle_.get(); }

private:
    Owned<tt_prepared, tt_prepared_free> handle_;
};

/// A mesh within a tolerance. Arrays of its parts live as long as it.
class Mesh {
public:
    Mesh(const Prepared &prepared, const tt_tolerance &tolerance, const tt_tessellate_options *options = nullptr,
         const Control *control = nullptr) {
        const auto handle = detail::handle_of(control);
        detail::check_with(control, tt_tessellate(prepared.get(), &tolerance, options, handle, handle_.fill()));
    }
    tt_mesh_info info() const {
        auto info = sized<tt_mesh_info>();
        check(tt_mesh_get_info(get(), &info));
        return info;
    }
    tt_mesh_part part(std::uint32_t index) const {
        auto part = sized<tt_mesh_part>();
        check(tt_mesh_get_part(get(), index, &part));
        return part;
    }
    std::vector<Diagnostic> diagnostics() const {
        return detail::diagnostics(get(), info().diagnostics, tt_mesh_get_diagnostic);
    }
    tt_mesh get() const noexcept { return handle_.get(); }

private:
    Owned<tt_mesh, tt_mesh_free> handle_;
};

/// Who receives frames. Functions that are empty are not called. An exception refuses the frame.
struct Sink {
    std::function<void(const tt_scene &)> begin;
    std::function<void(const tt_tile &)> tile;
    std::function<void(const tt_line &)> line;
    std::function<void(const tt_drawn &)> drawn;
    std::function<void()> end;
    std::function<void()> abort;
};

/// Where tiles are written. Called by workers. An exception of `room` refuses the frame, one of `release` is ignored.
struct Memory {
    std::function<void(const tt_tile &, tt_room &)> room;
    std::function<void(const tt_tile &)> release;
};

/// A pool of threads.
struct Jobs {
    std::uint32_t width = 1;
    /// Takes work, to be called once. Work that is destroyed without a call is dropped.
    std::function<void(std::function<void()>)> spawn;
    /// For reading and preparing: calls the function with each number below the first argument, on any threads, and
    /// returns when all calls have, see tt_jobs. May be empty: then the thread that reads or prepares does all the work.
    std::function<void(std::uint32_t, const std::function<void(std::uint32_t)> &)> each;
};

/// A pool for `tt_read_options.jobs` and `tt_prepare_options.jobs`. Stays where it is until the call returns. What an
/// exception leaves out of a loop is made by the library.
class Loops {
public:
    explicit Loops(Jobs jobs) : jobs_(std::move(jobs)), c_(sized<tt_jobs>()) {
        c_.width = jobs_.width;
        c_.user = this;
        // Reading and preparing have loops only.
        c_.spawn = [](void *, tt_job) -> std::int32_t { return 1; };
        if (!jobs_.each) return;
        c_.each = [](void *user, std::uint32_t count, tt_body body, void *of) -> std::int32_t {
            detail::Caught ignored;
            const auto call = [=](std::uint32_t number) { body(of, number); };
            return detail::guarded(ignored, [&] { static_cast<Loops *>(user)->jobs_.each(count, call); });
        };
    }
    Loops(const Loops &) = delete;
    Loops &operator=(const Loops &) = delete;
    const tt_jobs *get() const noexcept { return &c_; }

private:
    Jobs jobs_;
    tt_jobs c_;
};

/// Frames for moving cameras, or by a tolerance.
class Session {
public:
    explicit Session(const Prepared &prepared, const tt_session_options *options = nullptr,
                     std::optional<Jobs> jobs = std::nullopt)
        : state_(std::make_unique<State>()) {
        if (!jobs) {
            check(tt_session_new(prepared.get(), options, nullptr, handle_.fill()));
            return;
        }
        state_->jobs = std::move(*jobs);
        auto pool = sized<tt_jobs>();
        pool.width = state_->jobs.width;
        pool.user = state_.get();
        pool.spawn = [](void *user, tt_job job) -> std::int32_t { return static_cast<State *>(user)->take(job); };
        check(tt_session_new(prepared.get(), options, &pool, handle_.fill()));
    }
    Session(Session &&) noexcept = default;
    Session &operator=(Session &&other) noexcept {
        if (this != &other) {
            end();
            state_ = std::move(other.state_);
            handle_ = std::move(other.handle_);
        }
        return *this;
    }
    ~Session() { end(); }

    void write_into(const tt_layout &layout, Memory memory) {
        auto next = std::make_unique<Writer>(Writer{std::move(memory), &state_->caught});
        auto c = sized<tt_memory>();
        c.user = next.get();
        c.room = [](void *user, const tt_tile *tile, tt_room *room) -> std::int32_t {
            auto &writer = *static_cast<Writer *>(user);
            return detail::guarded(*writer.caught, [&] { writer.memory.room(*tile, *room); });
        };
        c.release = [](void *user, const tt_tile *tile) {
            auto &writer = *static_cast<Writer *>(user);
            detail::Caught ignored;
            detail::guarded(ignored, [&] { writer.memory.release(*tile); });
        };
        check(tt_session_write_into(get(), &layout, &c));
        state_->writer = std::move(next);
    }
    void update(const Prepared &prepared) { check(tt_session_update(get(), prepared.get())); }
    void begin(const std::vector<tt_view> &views) { check(tt_session_begin(get(), views.data(), views.size())); }
    tt_report finish(const Sink &sink) {
        return *frame(sink, [&](const tt_sink *c, tt_report *report) { return tt_session_finish(get(), c, report); });
    }
    /// Nothing if the frame is not made after so many seconds.
    std::optional<tt_report> finish_within(double seconds, const Sink &sink) {
        return frame(sink, [&](const tt_sink *c, tt_report *report) {
            return tt_session_finish_within(get(), seconds, c, report);
        });
    }
    tt_report view(const std::vector<tt_view> &views, const Sink &sink) {
        begin(views);
        return finish(sink);
    }
    tt_report tessellate(const tt_tolerance &tolerance, const Sink &sink, const Control *control = nullptr) {
        const auto call = [&](const tt_sink *c, tt_report *report) {
            return tt_session_tessellate(get(), &tolerance, detail::handle_of(control), c, report);
        };
        return *frame(sink, call, control);
    }
    void cancel() { check(tt_session_cancel(get())); }
    void forget() { check(tt_session_forget(get())); }
    std::uint64_t add_instance(const tt_placement &placement) {
        std::uint64_t key = 0;
        check(tt_session_add_instance(get(), &placement, &key));
        return key;
    }
    std::uint64_t instance_key(std::uint32_t index) const {
        std::uint64_t key = 0;
        check(tt_session_get_instance_key(get(), index, &key));
        return key;
    }
    std::uint32_t find_instance(std::uint64_t key) const {
        std::uint32_t index = 0;
        check(tt_session_find_instance(get(), key, &index));
        return index;
    }
    void remove_instance(std::uint64_t key) { check(tt_session_remove_instance(get(), key)); }
    void remove_instances(const std::uint64_t *keys, std::size_t count) {
        check(tt_session_remove_instances(get(), keys, count));
    }
    void move_instance(std::uint64_t key, const double (&transform)[12]) {
        check(tt_session_move_instance(get(), key, transform));
    }
    void set_part(std::uint32_t part, const tt_attributes &attributes) {
        check(tt_session_set_part(get(), part, &attributes));
    }
    void set_instance(std::uint64_t key, const tt_attributes &attributes) {
        check(tt_session_set_instance(get(), key, &attributes));
    }
    tt_attributes part_attributes(std::uint32_t part) const {
        auto attributes = sized<tt_attributes>();
        check(tt_session_get_part_attributes(get(), part, &attributes));
        return attributes;
    }
    tt_attributes instance_attributes(std::uint64_t key) const {
        auto attributes = sized<tt_attributes>();
        check(tt_session_get_instance_attributes(get(), key, &attributes));
        return attributes;
    }
    tt_session_info info() const {
        auto info = sized<tt_session_info>();
        check(tt_session_get_info(get(), &info));
        return info;
    }
    tt_session get() const noexcept { return handle_.get(); }

private:
    struct Writer {
        Memory memory;
        detail::Caught *caught;
    };
    struct State {
        Jobs jobs;
        detail::Caught caught;
        std::unique_ptr<Writer> writer;

        // The job's handle ends when it ran, or with the last copy of the work that was not called.
        std::int32_t take(tt_job job) noexcept {
            try {
                const auto held = std::make_shared<Owned<tt_job, tt_job_drop>>(job);
                jobs.spawn([held] { tt_job_run(held->get()); });
                return 0;
            } catch (...) {
                return 1; // Whoever waits for the work does it.
            }
        }
    };
    struct Frame {
        const Sink &sink;
        detail::Caught &caught;

        template <class To, class... Arguments>
        static std::int32_t call(void *user, To Sink::*which, const Arguments *...arguments) noexcept {
            const auto &frame = *static_cast<const Frame *>(user);
            const auto &to = frame.sink.*which;
            return to ? detail::guarded(frame.caught, [&] { to(*arguments...); }) : 0;
        }
    };

    template <class Call>
    std::optional<tt_report> frame(const Sink &sink, Call call, const Control *control = nullptr) {
        Frame frame{sink, state_->caught};
        auto c = sized<tt_sink>();
        c.user = &frame;
        c.begin = [](void *user, const tt_scene *scene) { return Frame::call(user, &Sink::begin, scene); };
        c.tile = [](void *user, const tt_tile *tile) { return Frame::call(user, &Sink::tile, tile); };
        c.line = [](void *user, const tt_line *line) { return Frame::call(user, &Sink::line, line); };
        c.drawn = [](void *user, const tt_drawn *drawn) { return Frame::call(user, &Sink::drawn, drawn); };
        c.end = [](void *user) { return Frame::call(user, &Sink::end); };
        c.abort = [](void *user) { Frame::call(user, &Sink::abort); };
        auto report = sized<tt_report>();
        const auto status = call(&c, &report);
        // Workers ask for rooms before anyone waits for the frame. An exception of one that was replaced is of no call.
        if (status == TT_OK)
            state_->caught.forget();
        else if (status != TT_PENDING)
            state_->caught.rethrow();
        if (control) control->check_call(status);
        if (check(status) == TT_PENDING) return std::nullopt;
        return report;
    }
    // Callbacks stay where they are if a call on another thread still uses them, which is a fault of the program.
    void end() noexcept {
        if (!handle_.reset()) static_cast<void>(state_.release());
    }

    std::unique_ptr<State> state_;
    Owned<tt_session, tt_session_free> handle_;
};

/// Sets the log of the process; an empty function ends it. Exceptions of it are ignored.
inline void set_log(tt_log_level level, std::function<void(tt_log_level, const char *)> log) {
    // One for the process, replaced by one thread at a time while no call of it is in progress. Never destroyed: a thread
    // may still log while the process ends.
    static auto &replacing = *new std::mutex;
    const std::lock_guard<std::mutex> alone(replacing);
    static auto &kept = *new std::unique_ptr<std::function<void(tt_log_level, const char *)>>;
    auto next = log ? std::make_unique<std::function<void(tt_log_level, const char *)>>(std::move(log)) : nullptr;
    const auto call = [](void *user, std::uint32_t at, const char *text) {
        const auto &to = *static_cast<const std::function<void(tt_log_level, const char *)> *>(user);
        detail::Caught ignored;
        detail::guarded(ignored, [&] { to(static_cast<tt_log_level>(at), text); });
    };
    check(next ? tt_set_log(level, call, next.get()) : tt_set_log(TT_LOG_OFF, nullptr, nullptr));
    kept = std::move(next);
}

} // namespace trimtess

#endif
