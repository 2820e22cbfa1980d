// --memory-limit: refusal before swapping.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>

#include "app/options.h"

namespace irradia::app {

void declare_memory(CLI::App& app, Options& options);

/// About what film, picture and what is kept of each pixel take, bytes of host memory.
std::uint64_t picture_memory(const RenderSettings& settings, std::uint64_t width, std::uint64_t height);

/// Throw Error, one line, if what comes next would pass the limit.
void require_records_memory(const Options& options);  ///< reading --load-records
void require_picture_memory(const Options& options, std::uint64_t width, std::uint64_t height);
/// To be called now and then while `what` goes on: a picture of so many pixels is yet to be made from the film.
void check_memory(const Options& options, std::uint64_t pixels, const std::string& what);

/// What std::bad_alloc means, without a limit or in spite of it.
std::string out_of_memory_text();

}  // namespace irradia::app
