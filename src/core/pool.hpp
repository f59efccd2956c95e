// Independent jobs on several threads, with the calling thread free to report and to be
// interrupted.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace pinchoff {

/// Runs job(i, stop) for i in [0, count) on `threads` threads; a long job looks at `stop` now and
/// then. The calling thread runs `watch(done)` ten times a second; when that returns false, `stop`
/// is set and no further job starts. Rethrows the first exception of a job. Which thread runs which
/// job never matters: a job sees its own index only.
template <class Job, class Watch>
void run_jobs(std::size_t count, int threads, const Job& job, const Watch& watch) {
    std::atomic<std::size_t> next{0}, done{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::condition_variable idle;
    int running = threads;
    std::exception_ptr failure;
    const auto work = [&] {
        for (std::size_t i; !stop && (i = next++) < count; ++done) {
            try {
                job(i, stop);
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (!failure) failure = std::current_exception();
                stop = true;
            }
        }
        const std::lock_guard lock(mutex);
        --running;
        idle.notify_one();
    };
    std::vector<std::jthread> pool;
    for (int t = 0; t < threads; ++t) pool.emplace_back(work);
    std::unique_lock lock(mutex);
    while (!idle.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; })) {
        lock.unlock();
        if (!watch(done.load())) stop = true;
        lock.lock();
    }
    lock.unlock();
    pool.clear();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace pinchoff
