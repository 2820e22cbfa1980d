// What a renderer knows of its picture's error without a reference (theory 8).
#pragma once
#include <cstdint>
#include <string>

namespace irradia {

/// An estimate and its 95 % interval.
struct Interval {
    double value = 0, low = 0, high = 0;
};

/// How far a picture is from what it would be without noise and bias. Means run over the counted pixels, those that
/// show no lamp: how bright lamps are is known, and their brightness would make every other error look small. All
/// figures are relative to the counted pixels' true mean.
struct ErrorReport {
    Interval rel_rmse;   ///< root of the mean over pixels and channels of (picture - truth)²; compare's rel_rmse
    Interval mean_bias;  ///< mean of (picture - truth)
    double direct_rel_rmse = 0, indirect_rel_rmse = 0;  ///< of the picture's two parts, each to the whole mean
    double counted = 1;                                 ///< share of the picture's pixels
    std::uint64_t probes = 0, paths = 0;  ///< places asked, with repetition; unbiased paths traced for them
    double seconds = 0;                   ///< wall time that it took
    double target = 0;        ///< rel_rmse that was asked for; 0: none
    bool reached = false;     ///< the interval of rel_rmse ends below it
    bool time_is_up = false;  ///< the time limit has ended the search for less
    int steps = 0;            ///< pictures made on the way, the last one included
    std::string doubt;                    ///< why the intervals cannot be trusted; "" if they can
};

}  // namespace irradia
