// Independent jobs on several threads, with the calling thread free to report and to be
// interrupted.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace pinchoff {

/// Starts up to `threads` threads with start(t): fewer where the system allows no more, so that
/// work is slower but done. Rethrows std::system_error where not even one could be.
template <class Start>
int start_threads(int threads, const Start& start) {
    for (int t = 0; t < threads; ++t) {
        try {
            start(t);
        } catch (const std::system_error&) {
            if (t == 0) throw;
            return t;
        }
    }
    return threads;
}

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
    int running = 0;
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
    std::unique_lock lock(mutex);  // nobody ends before all are counted
    running = start_threads(threads, [&](int) { pool.emplace_back(work); });
    while (!idle.wait_for(lock, std::chrono::milliseconds(100), [&] { return running == 0; })) {
        lock.unlock();
        if (!watch(done.load())) stop = true;
        lock.lock();
    }
    lock.unlock();
    pool.clear();
    if (failure) std::rethrow_exception(failure);
}

/// Threads that stay, for many short rounds of jobs.
class Team {
public:
    explicit Team(int threads) {
        const auto start = [this](int t) {
            if (t == 0) return;  // the calling thread
            others_.emplace_back([this, t](const std::stop_token& stop) { serve(stop, t); });
        };
        start_threads(threads, start);
    }
    ~Team() {
        {
            const std::lock_guard lock(mutex_);
            for (std::jthread& t : others_) t.request_stop();
        }
        begin_.notify_all();
    }
    Team(const Team&) = delete;

    int threads() const { return static_cast<int>(others_.size()) + 1; }

    /// Runs job(worker, i) for i in [0, count), a few at a time wherever a thread is free; returns
    /// when all are done. Rethrows the first exception. Which thread runs which never matters.
    template <class Job>
    void for_each(std::size_t count, const Job& job) {
        const std::size_t piece =
            std::max<std::size_t>(1, count / (16 * static_cast<std::size_t>(threads())));
        std::atomic<std::size_t> next{0};
        const std::function<void(int)> work = [&](int worker) {
            for (std::size_t first; (first = next.fetch_add(piece)) < count;)
                for (std::size_t i = first; i < std::min(first + piece, count); ++i) job(worker, i);
        };
        if (others_.empty() || count <= piece) {
            guarded(work, 0);
            return finish();
        }
        {
            const std::lock_guard lock(mutex_);
            work_ = &work;
            busy_ = static_cast<int>(others_.size());
            ++round_;
        }
        begin_.notify_all();
        guarded(work, 0);
        std::unique_lock lock(mutex_);
        end_.wait(lock, [&] { return busy_ == 0; });
        work_ = nullptr;
        lock.unlock();
        finish();
    }

private:
    std::mutex mutex_;
    std::condition_variable begin_, end_;
    const std::function<void(int)>* work_ = nullptr;
    int busy_ = 0;
    std::uint64_t round_ = 0;
    std::exception_ptr failure_;
    std::vector<std::jthread> others_;  // last: they end before the rest does

    void guarded(const std::function<void(int)>& work, int worker) {
        try {
            work(worker);
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!failure_) failure_ = std::current_exception();
        }
    }

    void finish() {
        if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    }

    void serve(const std::stop_token& stop, int worker) {
        std::uint64_t seen = 0;
        while (true) {
            std::unique_lock lock(mutex_);
            begin_.wait(lock, [&] { return stop.stop_requested() || round_ != seen; });
            if (stop.stop_requested()) return;
            seen = round_;
            const std::function<void(int)>* work = work_;
            lock.unlock();
            guarded(*work, worker);
            lock.lock();
            if (--busy_ == 0) end_.notify_one();
        }
    }
};

}  // namespace pinchoff
