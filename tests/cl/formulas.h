// The formulas of cl/, compiled as host C++ in double precision, and what their tests share.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "cl/portable.h"
namespace irradia::host {
#include "cl/filter.h"
#include "cl/ggx.h"
#include "cl/harmonics.h"
#include "cl/hemisphere_reduce.h"
#include "cl/probe.h"
#include "cl/radius.h"
#include "cl/reproject.h"
#include "cl/solid_angle.h"
#include "cl/weight.h"
}  // namespace irradia::host
#undef R  // a name of template parameters elsewhere

namespace irradia::test {

using nlohmann::json;
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kMiss = 1e30;

/// tests/data/vectors/<name>.json: numbers made by scripts independent of this project (theory 9).
inline json load_vectors(const std::string& name) {
    const std::string path = std::string(IRRADIA_TEST_DATA) + "/vectors/" + name + ".json";
    std::ifstream file(path);
    if (!file) throw std::runtime_error(path + ": cannot be opened");
    return json::parse(file);
}

inline host::real3 vec3(const json& j) { return host::make_real3(j.at(0), j.at(1), j.at(2)); }

/// One member of it, by value (a range-based for keeps only a whole temporary alive), which must not be empty.
inline json load_vectors(const std::string& name, const std::string& member) {
    json value = load_vectors(name).at(member);
    if (value.empty()) throw std::runtime_error(name + ".json: '" + member + "' is empty");
    return value;
}

/// |a - b|, for tolerances that are relative to something.
inline double distance(host::real3 a, host::real3 b) { return host::length(a - b); }

/// A frame as a test vector gives it: members T, B, n.
inline host::Frame frame_of(const json& j) { return {vec3(j.at("T")), vec3(j.at("B")), vec3(j.at("n"))}; }

/// |found - wanted| <= relative * |wanted|, and <= relative where wanted is 0.
inline void expect_relative(double found, double wanted, double relative, const std::string& what) {
    EXPECT_LE(std::abs(found - wanted), relative * (wanted == 0 ? 1.0 : std::abs(wanted)))
        << what << ": found " << found << ", wanted " << wanted;
}

inline void expect_relative(host::real3 found, host::real3 wanted, double relative, const std::string& what) {
    const double size = host::length(wanted);
    EXPECT_LE(distance(found, wanted), relative * (size == 0 ? 1.0 : size))
        << what << ": found (" << found.x << ", " << found.y << ", " << found.z << "), wanted (" << wanted.x << ", "
        << wanted.y << ", " << wanted.z << ")";
}

}  // namespace irradia::test
