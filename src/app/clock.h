// Wall time.
#pragma once
#include <chrono>

namespace irradia::app {

/// Seconds of the steady clock.
inline double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace irradia::app
