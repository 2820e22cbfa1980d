// Rows of the table of hard cases. A test states its case; `tools/hard-cases` runs the tests of tests/hard and writes
// docs/hard-cases.md from what GoogleTest reports of them, so that no row is there that was not run.
#pragma once
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace irradia::test {

inline std::string figure(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", x);
    return text;
}

/// One row of the table, stated once in a test that also asserts `measured <= bound`.
/// what: the case, as a reader would name it ("corner: wall at 1e-5 of the scene").
/// against: what the float32 results are compared with ("double on the host", "closed form: ...", "Embree, robust").
/// error: what is measured and in which unit ("relative error of E").
/// measured, bound: the largest error found and the one that is asserted.
/// naive: what the formula as it stands in the thesis gives there ("0/0 = NaN"), "" where it does the same.
inline void hard_case(const std::string& what, const std::string& against, const std::string& error, double measured,
                      double bound, const std::string& naive = "") {
    ::testing::Test::RecordProperty("case", what);
    ::testing::Test::RecordProperty("against", against);
    ::testing::Test::RecordProperty("error", error);
    ::testing::Test::RecordProperty("measured", figure(measured));
    ::testing::Test::RecordProperty("bound", figure(bound));
    ::testing::Test::RecordProperty("naive", naive);
}

}  // namespace irradia::test
