// A batch's poses, part by part, on as many threads as are asked for.
#include "sharing.hpp"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace urdf_ik {

namespace {

// A batch is shared among threads in whole multiples of this many poses, so that every pose is solved by the same
// instructions however many threads there are.
constexpr long SHARE = 32;
// Poses that are solved between two questions whether to stop: whole multiples of every block's lanes, more while they take
// less than QUICK and fewer when they take more than SLOW.
constexpr long FEWEST = 8, MOST = 1024;
constexpr auto QUICK = std::chrono::milliseconds(1), SLOW = std::chrono::milliseconds(4);

Batch part_of(const Solver& solver, const Batch& batch, long from, long many) {
    Batch part = batch;
    part.m = many;
    part.T += solver.numbers * from, part.flags += solver.branches * from;
    part.q += long(solver.branches) * solver.joints * from;
    if (part.values) part.values += solver.parameters * from;
    return part;
}

// Index of the first bad target of a batch, -1 where there is none or where it was stopped.
long solve_in_parts(const Solver& solver, const Batch& batch, const Stop& stop) {
    if (batch.m <= FEWEST) return solver.solve(batch);
    long many = FEWEST;
    for (long start = 0; start < batch.m;) {
        const auto began = Signals::Clock::now();
        const long now = many < batch.m - start ? many : batch.m - start;
        const long bad = solver.solve(part_of(solver, batch, start, now));
        if (bad >= 0) return start + bad;
        start += now;
        if (stop.asked()) break;
        const auto took = Signals::Clock::now() - began;
        if (took < QUICK && many < MOST) many *= 2;
        if (took > SLOW && many > FEWEST) many /= 2;
    }
    return -1;
}

// The threads that help the one that was called, and how many of them still work.
class Helpers {
public:
    // Whether one more has begun: a system may refuse it.
    template <class Work> bool begin(const Work& work) {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            ++working_;
        }
        try {
            threads_.emplace_back([this, work] {
                work();
                const std::lock_guard<std::mutex> lock(mutex_);
                if (!--working_) done_.notify_all();
            });
        } catch (const std::system_error&) {
            const std::lock_guard<std::mutex> lock(mutex_);
            --working_;
            return false;
        }
        return true;
    }
    // Until all are done, or some time has passed; whether all are.
    bool wait() {
        std::unique_lock<std::mutex> lock(mutex_);
        return done_.wait_for(lock, Signals::PERIOD, [this] { return !working_; });
    }
    ~Helpers() {
        for (std::thread& each : threads_) each.join();
    }

private:
    std::vector<std::thread> threads_;
    std::mutex mutex_;
    std::condition_variable done_;
    int working_ = 0;
};

}  // namespace

long solve_shared(const Solver& solver, const Batch& given, int threads, const Stop& stop) {
    Batch batch = given;
    batch.whole = batch.m;
    if (threads <= 1 || batch.m < 2 * SHARE * threads) return solve_in_parts(solver, batch, stop);
    std::vector<long> bad(threads, -1);
    std::atomic<bool> ended = false;
    const Stop when_ended = {[](void* flag) { return static_cast<std::atomic<bool>*>(flag)->load(std::memory_order_relaxed); },
                             &ended};
    const auto edge = [&](int k) { return k == threads ? batch.m : SHARE * (k * (batch.m / SHARE) / threads); };
    const auto share = [&](int k, const Stop& until) {
        const long from = edge(k), found = solve_in_parts(solver, part_of(solver, batch, from, edge(k + 1) - from), until);
        bad[k] = found < 0 ? -1 : from + found;
    };
    {
        Helpers helpers;
        int begun = 1;
        while (begun < threads && helpers.begin([&share, &when_ended, k = begun] { share(k, when_ended); })) ++begun;
        share(0, stop);
        for (int k = begun; k < threads && !stop.asked(); ++k) share(k, stop);
        while (!(ended = stop.asked()) && !helpers.wait()) {}
    }
    for (const long each : bad) {
        if (each >= 0) return each;
    }
    return -1;
}

}  // namespace urdf_ik
