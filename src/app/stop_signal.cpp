#include "app/stop_signal.h"

#include <pthread.h>

#include <atomic>
#include <csignal>
#include <system_error>
#include <thread>

namespace irradia::app {
namespace {

std::atomic<int> received{0};

void wait_for(sigset_t signals) {
    int signal = 0;
    if (sigwait(&signals, &signal) != 0) return;
    received = signal;
    if (sigwait(&signals, &signal) != 0) return;
    std::signal(signal, SIG_DFL);  // the second one is obeyed
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    std::raise(signal);
}

}  // namespace

void remember_signals() {
    // Blocked, so that they interrupt no call of any thread, and waited for. The programs that a driver starts to
    // compile kernels inherit that: who signals a whole group of processes, as terminals and schedulers do, would end
    // them, and drivers abort the process over that.
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT}) {
        struct sigaction now {};
        if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaddset(&signals, signal);
    }
    if (pthread_sigmask(SIG_BLOCK, &signals, nullptr) != 0) return;
    try {
        std::thread(wait_for, signals).detach();
    } catch (const std::system_error&) {  // no more threads: they end the process, as they would have
        pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    }
}

int signal_received() { return received; }

void stop_if_told() {
    if (const int signal = received; signal != 0) throw Stopped{signal};
}

const char* signal_name(int signal) { return signal == SIGINT ? "SIGINT" : signal == SIGTERM ? "SIGTERM" : "a signal"; }

}  // namespace irradia::app
