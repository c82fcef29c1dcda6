// Solves a batch on several threads, part by part.
#include "bindings/sharing.hpp"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace urdf_ik {

namespace {

// Number of poses in a part, which one thread solves at a time. Parts are multiples of every block's lanes, so that the same
// instructions solve a pose in any part. A thread doubles its parts if one takes less than QUICK, and halves them above SLOW.
constexpr long FEWEST = 8, MOST = 1024;
constexpr auto QUICK = std::chrono::milliseconds(1), SLOW = std::chrono::milliseconds(4);
// A thread is started only if this much work remains for it. Starting one takes about 30 microseconds.
constexpr auto WORTH_A_THREAD = std::chrono::microseconds(200);

Batch part_of(const Solver& solver, const Batch& batch, long from, long many) {
    Batch part = batch;
    part.m = many;
    part.T += solver.numbers * from, part.flags += solver.branches * from;
    part.q += long(solver.branches) * solver.joints * from;
    if (part.values) part.values += solver.parameters * from;
    return part;
}

// A batch's poses, divided into one share per thread. A thread takes parts of its own share, then of the others' shares. So a
// thread whose core is busy, or whose poses take longer, does not delay the rest. Two threads seldom write to the same page of
// fresh memory, where they would wait for each other.
class Poses {
public:
    Poses(const Solver& solver, const Batch& batch, int threads) : solver_(solver), batch_(batch), shares_(threads) {
        const long whole = batch.m / FEWEST;
        for (int k = 0; k < threads; ++k) {
            shares_[k].next = FEWEST * (k * whole / threads);
            shares_[k].end = k + 1 == threads ? batch.m : FEWEST * ((k + 1) * whole / threads);
        }
    }
    // Solve parts, beginning with share `own`, until all are taken or `stop` ends the work. After each part, calls
    // then(number of poses, time). Returns the index of an invalid target in these parts, or -1.
    template <class Then> long solve(int own, const Stop& stop, const Then& then) {
        const int threads = int(shares_.size());
        long many = FEWEST;
        for (int k = 0; k < threads; ++k) {
            const int which = (own + k) % threads;
            Share& share = shares_[which];
            for (;;) {
                const long start = share.next.fetch_add(many, std::memory_order_relaxed), left = share.end - start;
                if (left <= 0) break;
                const long now = many < left ? many : left;
                const auto began = Signals::Clock::now();
                const long bad = solver_.solve(part_of(solver_, batch_, start, now));
                if (bad >= 0) {
                    // Parts behind the invalid target are skipped.
                    for (int after = which; after < threads; ++after) shares_[after].next = shares_[after].end;
                    return start + bad;
                }
                if (stop.asked()) return -1;
                const auto took = Signals::Clock::now() - began;
                then(now, took);
                if (took < QUICK && many < MOST) many *= 2;
                if (took > SLOW && many > FEWEST) many /= 2;
                // The last parts are small, so that all threads end at about the same time.
                while (threads > 1 && many > FEWEST && many > left / 2) many /= 2;
            }
        }
        return -1;
    }
    // Number of poses not yet taken.
    long left() const {
        long sum = 0;
        for (const Share& share : shares_) sum += share.next < share.end ? share.end - share.next : 0;
        return sum;
    }

private:
    struct Share {
        std::atomic<long> next = 0;
        long end = 0;
    };
    const Solver& solver_;
    const Batch& batch_;
    std::vector<Share> shares_;
};

// The threads that help the calling one. A thread whose core is busy may begin late. After `close` a late thread does nothing, and
// wait() does not wait for it.
class Helpers {
public:
    // Start one more thread. Returns false if the system refuses it.
    template <class Work> bool begin(const Work& work) {
        try {
            std::thread([gate = gate_, work] {
                {
                    const std::lock_guard<std::mutex> lock(gate->mutex);
                    if (gate->closed) return;
                    ++gate->working;
                }
                work();
                const std::lock_guard<std::mutex> lock(gate->mutex);
                if (!--gate->working) gate->done.notify_all();
            }).detach();
        } catch (const std::system_error&) { return false; }
        return true;
    }
    void close() {
        const std::lock_guard<std::mutex> lock(gate_->mutex);
        gate_->closed = true;
    }
    // Wait until all threads that have begun are done, for at most one PERIOD. Returns whether they are done.
    bool wait() {
        std::unique_lock<std::mutex> lock(gate_->mutex);
        return gate_->done.wait_for(lock, Signals::PERIOD, [this] { return !gate_->working; });
    }
    ~Helpers() {
        close();
        while (!wait()) {}
    }

private:
    struct Gate {
        std::mutex mutex;
        std::condition_variable done;
        int working = 0;
        bool closed = false;
    };
    std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
};

}  // namespace

long solve_shared(const Solver& solver, const Batch& given, int threads, const Stop& stop) {
    Batch batch = given;
    batch.whole = batch.m;
    if (batch.m <= FEWEST) return solver.solve(batch);
    if (threads > batch.m / FEWEST) threads = int(batch.m / FEWEST);
    Poses poses(solver, batch, threads);
    std::vector<long> bad(threads, -1);
    std::atomic<bool> ended = false;
    const Stop when_ended = {[](void* flag) { return static_cast<std::atomic<bool>*>(flag)->load(std::memory_order_relaxed); },
                             &ended};
    {
        Helpers helpers;
        int begun = 1;
        const auto help = [&](long many, Signals::Clock::duration took) {
            if (begun == threads || (many == FEWEST && took < QUICK)) return;  // the first part's time includes waiting for memory
            const auto rest = took * poses.left() / many;
            while (begun < threads && rest > (begun + 1) * WORTH_A_THREAD &&
                   helpers.begin([&, k = begun] { bad[k] = poses.solve(k, when_ended, [](long, auto) {}); })) {
                ++begun;
            }
        };
        bad[0] = poses.solve(0, stop, help);
        helpers.close();
        while (!(ended = stop.asked()) && !helpers.wait()) {}
    }
    long first = -1;
    for (const long each : bad) {
        if (each >= 0 && (first < 0 || each < first)) first = each;
    }
    return first;
}

}  // namespace urdf_ik
