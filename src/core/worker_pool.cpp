#include "core/worker_pool.h"

#include <chrono>

namespace irradia {
namespace {
thread_local bool inside = false;  // this thread is in a pool's work already

// Work mostly comes in quick succession, and waking a thread takes as long as much of it: so threads look out for a
// while before they sleep.
constexpr std::chrono::microseconds patience{100};

void pause() {
#if defined(__x86_64__)
    for (int i = 0; i < 8; ++i) __builtin_ia32_pause();
#endif
}

template <class F>
void look_out(const F& seen) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!seen() && std::chrono::steady_clock::now() < end) pause();
}
}  // namespace

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard lock(state_);
        ended_ = true;
    }
    wake_.notify_all();
    for (std::thread& t : threads_) t.join();
}

WorkerPool& WorkerPool::shared() {
    static WorkerPool pool;
    return pool;
}

void WorkerPool::run(std::size_t helpers, const std::function<void()>& work) {
    std::unique_lock alone(running_, std::defer_lock);
    if (helpers == 0 || inside || !alone.try_lock()) {
        work();
        return;
    }
    {
        const std::lock_guard lock(state_);
        while (threads_.size() < helpers) threads_.emplace_back([this] { help(); });
        work_ = &work;
        wanted_ = helpers;
    }
    if (helpers < threads_.size())
        for (std::size_t i = 0; i < helpers; ++i) wake_.notify_one();
    else
        wake_.notify_all();
    inside = true;
    work();
    inside = false;
    {
        const std::lock_guard lock(state_);
        wanted_ = 0;  // whoever wakes only now has nothing to do
    }
    look_out([this] { return active_ == 0; });
    std::unique_lock lock(state_);
    done_.wait(lock, [this] { return active_ == 0; });
}

void WorkerPool::help() {
    inside = true;
    for (;;) {
        look_out([this] { return wanted_ > 0; });
        std::unique_lock lock(state_);
        wake_.wait(lock, [this] { return ended_ || wanted_ > 0; });
        if (ended_) return;
        --wanted_;
        ++active_;
        const std::function<void()>& work = *work_;
        lock.unlock();
        work();
        lock.lock();
        if (--active_ == 0) done_.notify_one();
    }
}

}  // namespace irradia
