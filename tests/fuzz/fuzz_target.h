// One input of a fuzzer as a file: readers take paths.
#pragma once
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include "irradia/Error.h"

namespace irradia::test {

/// Writes `data` to a file of this process's own and calls read(path). An Error has to be one line; anything else that
/// is thrown ends the process, which the fuzzer reports.
template <class F>
int fuzz_file(const std::uint8_t* data, std::size_t size, const char* extension, F&& read) {
    static const std::string path =
        (std::filesystem::temp_directory_path() / ("irradia-fuzz-" + std::to_string(::getpid()) + extension)).string();
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) std::abort();
    std::fwrite(data, 1, size, file);
    std::fclose(file);
    try {
        read(path);
    } catch (const Error& error) {
        const std::string what = error.what();
        if (what.empty() || what.find('\n') != std::string::npos) std::abort();
    }
    return 0;
}

}  // namespace irradia::test
