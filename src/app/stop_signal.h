// SIGTERM and SIGINT: asked for between launches rather than obeyed in their middle.
#pragma once

namespace irradia::app {

/// What ends a run that was told to stop. Exit status: 128 + signal.
struct Stopped {
    int signal;
};

/// From now on the first SIGTERM or SIGINT is remembered; a second one ends the process at once, as it would have. To
/// be called before there are other threads.
void remember_signals();
/// The signal that has come; 0: none.
int signal_received();
/// Throws Stopped if one has.
void stop_if_told();

/// "SIGTERM", ...
const char* signal_name(int signal);

}  // namespace irradia::app
