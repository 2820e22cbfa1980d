// The vocabulary of check_scene(): conditions on elements of arrays, told in one line.
#pragma once
#include <cmath>
#include <cstddef>
#include <string>

#include "irradia/Error.h"
#include "irradia/Scene.h"

namespace irradia::check {

/// Names what is being checked: "<where>: <array> <index>: <what>".
struct Place {
    const std::string& where;
    const char* array;
    std::size_t index = 0;

    [[noreturn]] void fail(const std::string& what) const {
        throw Error(where + ": " + array + " " + std::to_string(index) + ": " + what);
    }
    void require(bool condition, const char* what) const {
        if (!condition) fail(what);
    }
    void below(std::uint64_t value, std::uint64_t count, const char* what) const {
        if (value >= count)
            fail(std::string(what) + " " + std::to_string(value) + " is not below " + std::to_string(count));
    }
    /// -1 (none) or an index below `count`.
    void optional_below(std::int64_t value, std::size_t count, const char* what) const {
        if (value < -1 || value >= static_cast<std::int64_t>(count))
            fail(std::string(what) + " " + std::to_string(value) + " is neither -1 nor below " + std::to_string(count));
    }
    template <class... T>
    void finite(T... values) const {
        if (!(std::isfinite(values) && ...)) fail("a number is not finite");
    }
};

/// Both trees, their leaves and what these refer to.
void check_accel(const std::string& where, const Scene& scene, AccelLayouts layouts);

}  // namespace irradia::check
