// What a picture's error is, in words.
#pragma once
#include <string>

#include "irradia/ErrorReport.h"

namespace irradia::app {

/// One line: error and bias with their intervals, the two parts, what it took; and a second one if they are in doubt.
std::string error_text(const ErrorReport& report);

}  // namespace irradia::app
