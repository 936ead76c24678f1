// All work on a pool of the program's own: a file is read and prepared, then two cameras fly at the same time, each with
// a session, on the same threads. Instances move meanwhile. Prints the triangles of each picture's tiles.
//
//     jobs FILE [THREADS]
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <trimtess.hpp>

namespace {

// A pool as engines have one.
class Pool {
public:
    explicit Pool(unsigned width) {
        for (unsigned k = 0; k < width; k++) threads_.emplace_back([this] { work(); });
    }
    ~Pool() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            ended_ = true;
        }
        more_.notify_all();
        for (auto &thread : threads_) thread.join();
    }
    void spawn(std::function<void()> job) {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            jobs_.push_back(std::move(job));
        }
        more_.notify_one();
    }
    // Calls `body` with each number below `count`. The caller makes calls, too, so loops within loops end.
    void each(std::uint32_t count, const std::function<void(std::uint32_t)> &body) {
        struct Loop {
            std::atomic<std::uint32_t> next{0};
            std::mutex mutex;
            std::condition_variable left;
            unsigned inside = 0;
            bool closed = false;
        };
        const auto loop = std::make_shared<Loop>();
        const auto calls = [loop, count, &body] {
            for (std::uint32_t k; (k = loop->next++) < count;) body(k);
        };
        for (std::size_t k = 1; k < threads_.size() && k < count; k++) {
            spawn([loop, calls] {
                {
                    const std::lock_guard<std::mutex> lock(loop->mutex);
                    if (loop->closed) return; // Too late: `body` is gone.
                    loop->inside++;
                }
                calls();
                const std::lock_guard<std::mutex> lock(loop->mutex);
                loop->inside--;
                loop->left.notify_one();
            });
        }
        calls();
        std::unique_lock<std::mutex> lock(loop->mutex);
        loop->closed = true;
        loop->left.wait(lock, [&] { return loop->inside == 0; });
    }
    std::uint64_t done() const { return done_; }

private:
    void work() {
        for (;;) {
            std::function<void()> job;
            {
                std::unique_lock<std::mutex> lock(mutex_);
                more_.wait(lock, [this] { return ended_ || !jobs_.empty(); });
                if (jobs_.empty()) return;
                job = std::move(jobs_.front());
                jobs_.pop_front();
            }
            job();
            done_++;
        }
    }

    std::mutex mutex_;
    std::condition_variable more_;
    std::deque<std::function<void()>> jobs_;
    bool ended_ = false;
    std::atomic<std::uint64_t> done_{0};
    std::vector<std::thread> threads_;
};

// Keeps tiles as vectors of bytes.
struct Tiles {
    struct Block {
        std::vector<unsigned char> vertices, indices;
        std::uint32_t triangles;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::unique_ptr<Block>> kept;

    trimtess::Memory memory() {
        const auto room = [](const tt_tile &tile, tt_room &room) {
            auto block = std::make_unique<Block>();
            block->vertices.resize(std::size_t{tile.vertices} * tile.stride);
            block->indices.resize(std::size_t{3} * tile.triangles * tile.index_bytes);
            block->triangles = tile.triangles;
            room.vertices = block->vertices.data();
            room.indices = block->indices.data();
            room.place = reinterpret_cast<std::uintptr_t>(block.release());
        };
        const auto release = [](const tt_tile &tile) { delete reinterpret_cast<Block *>(tile.place); };
        return {room, release};
    }
    trimtess::Sink sink() {
        trimtess::Sink sink;
        sink.begin = [this](const tt_scene &scene) {
            if (scene.whole) kept.clear();
        };
        sink.tile = [this](const tt_tile &tile) {
            std::unique_ptr<Block> block(tile.triangles ? reinterpret_cast<Block *>(tile.place) : nullptr);
            const auto key = std::make_pair(tile.part, tile.tile);
            if (block) kept[key] = std::move(block);
            else kept.erase(key);
        };
        sink.abort = [this] { kept.clear(); };
        return sink;
    }
    std::uint64_t triangles() const {
        std::uint64_t sum = 0;
        for (const auto &tile : kept) sum += tile.second->triangles;
        return sum;
    }
};

int run(const char *file, unsigned threads) {
    std::atomic<std::uint32_t> parts{0};
    const trimtess::Control control([&](tt_stage stage, std::uint64_t, std::uint64_t total) {
        if (stage == TT_STAGE_READ) parts = static_cast<std::uint32_t>(total);
    });
    Pool pool(threads);
    const trimtess::Jobs jobs{threads, [&](std::function<void()> job) { pool.spawn(std::move(job)); },
                              [&](std::uint32_t count, const auto &body) { pool.each(count, body); }};
    const trimtess::Loops loops(jobs);
    auto reading = trimtess::sized<tt_read_options>();
    reading.jobs = loops.get();
    const auto model = trimtess::Model::read_file(file, &reading, &control);
    for (const auto &told : model.diagnostics()) std::fprintf(stderr, "%s: %s\n", told.data.code, told.message.c_str());
    auto preparing = trimtess::sized<tt_prepare_options>();
    preparing.jobs = loops.get();
    const trimtess::Prepared prepared(model, &preparing);
    std::printf("%s: %u parts, %u instances\n", model.name().c_str(), parts.load(), prepared.info().instances);

    auto options = trimtess::sized<tt_session_options>();
    options.budget = 0.004;
    struct Camera {
        Tiles tiles;
        trimtess::Session session;
    };
    std::vector<std::unique_ptr<Camera>> cameras;
    for (int k = 0; k < 2; k++) {
        cameras.push_back(std::make_unique<Camera>(Camera{{}, trimtess::Session(prepared, &options, jobs)}));
        auto &camera = *cameras.back();
        camera.session.write_into(trimtess::sized<tt_layout>(), camera.tiles.memory());
    }
    auto second = trimtess::sized<tt_placement>();
    const auto added = cameras[1]->session.add_instance(second);

    constexpr std::uint32_t FRAMES = 40;
    for (std::uint32_t frame = 0; frame < FRAMES; frame++) {
        const char *const paths[] = {"orbit", "zoom"};
        double transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 2.0 * frame};
        cameras[1]->session.move_instance(added, transform);
        // Both frames are made at the same time.
        for (int k = 0; k < 2; k++) {
            auto view = trimtess::sized<tt_view>();
            view.width_px = 1280, view.height_px = 720;
            trimtess::check(tt_view_along_path(prepared.get(), paths[k], frame, FRAMES, &view));
            cameras[k]->session.begin({view});
        }
        for (auto &camera : cameras) {
            const auto sink = camera->tiles.sink();
            // A render loop would draw the last frame again meanwhile.
            while (!camera->session.finish_within(0.001, sink)) {}
        }
    }
    for (const auto &camera : cameras) {
        std::printf("%llu triangles\n", static_cast<unsigned long long>(camera->tiles.triangles()));
    }
    return pool.done() > 0 ? 0 : 1;
}

} // namespace

int main(int argc, char **argv) try {
    if (argc < 2) {
        std::fprintf(stderr, "usage: jobs FILE [THREADS]\n");
        return 2;
    }
    const int status = run(argv[1], argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 2);
    std::printf("%llu handles left\n", static_cast<unsigned long long>(tt_live_handles()));
    return status + (tt_live_handles() != 0);
} catch (const trimtess::Error &error) {
    std::fprintf(stderr, "error %d: %s\n", static_cast<int>(error.status()), error.what());
    return 1;
}
