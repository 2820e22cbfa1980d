// The host's threads for loops over large arrays. They wait for work instead of being made anew for every loop, which
// with sixteen of them took longer than most loops do.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace irradia {

class WorkerPool {
public:
    WorkerPool() = default;
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// The one that all loops of the process share; its threads end with the process.
    static WorkerPool& shared();

    /// Calls `work` here and, at the same time, on up to `helpers` threads of the pool; returns when all calls have.
    /// While another thread is in run(), or from within `work`, it is called here alone. It must not throw.
    void run(std::size_t helpers, const std::function<void()>& work);

private:
    void help();

    std::mutex running_;  // held by run()
    std::mutex state_;    // held to change what follows
    std::condition_variable wake_, done_;
    const std::function<void()>* work_ = nullptr;
    std::atomic<std::size_t> wanted_ = 0, active_ = 0;  // threads that may still begin, and that have not ended
    bool ended_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace irradia
