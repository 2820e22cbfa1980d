#include "app/stop_signal.h"

#include <csignal>

namespace irradia::app {
namespace {

volatile std::sig_atomic_t received = 0;

void set_handlers(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    sigemptyset(&action.sa_mask);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGINT, &action, nullptr);
}

extern "C" void remember(int signal) {
    received = signal;
    set_handlers(SIG_DFL);  // the second one is obeyed
}

}  // namespace

void remember_signals() { set_handlers(remember); }

int signal_received() { return received; }

void stop_if_told() {
    if (received != 0) throw Stopped{received};
}

const char* signal_name(int signal) { return signal == SIGINT ? "SIGINT" : signal == SIGTERM ? "SIGTERM" : "a signal"; }

}  // namespace irradia::app
