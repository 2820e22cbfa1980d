// The page's words and numbers: what was rendered, how, where, how long it took.
#pragma once
#include <string>

#include "app/report.h"

namespace irradia::app {

/// Times of the run by stage, and the device's by kernel.
std::string times_section(const Run& run);
std::string rays_section(const Run& run);
/// Settings (those that are not defaults marked), scene, device.
std::string settings_section(const Run& run);
/// "" unless the error was estimated.
std::string error_section(const Run& run);
/// Large figures for the page's head.
std::string key_figures(const ReportInput& input);

/// A measure of the picture as `compare` prints it: "2.3456 %".
std::string exact_percent(double share);

}  // namespace irradia::app
