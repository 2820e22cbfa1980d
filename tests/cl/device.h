// Runs the kernels of cl/formulas_test.cl in float32 on the default device.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "formulas.h"
#include "irradia/Device.h"

namespace irradia::test {

/// Holds the default device for all tests of an executable, and lets go of it before main() ends: drivers clean up
/// after themselves at exit, in an order of their own.
class DeviceEnvironment : public ::testing::Environment {
public:
    void TearDown() override { devices_.clear(); }
    Device& get(const std::string& traversal) {
        std::unique_ptr<Device>& device = devices_[traversal];
        if (!device) device = std::make_unique<Device>(DeviceOptions{"", 0, traversal});
        return *device;
    }

private:
    std::map<std::string, std::unique_ptr<Device>> devices_;
};
inline DeviceEnvironment* const device_environment = [] {
    auto* e = new DeviceEnvironment;
    ::testing::AddGlobalTestEnvironment(e);  // which owns it from now on
    return e;
}();
/// traversal: see DeviceOptions.
inline Device& device(const std::string& traversal = "") { return device_environment->get(traversal); }

/// Inputs rounded to float32 once, so that device (float32) and host (double) compute from the same numbers.
class Inputs {
public:
    Inputs& add(double x) {
        values_.push_back(static_cast<float>(x));
        return *this;
    }
    Inputs& add(host::real3 v) { return add(v.x).add(v.y).add(v.z); }
    [[nodiscard]] const std::vector<float>& values() const { return values_; }
    /// Item i of `stride` inputs each, number `offset`, as the host formulas take it.
    [[nodiscard]] double scalar(std::size_t i, std::size_t stride, std::size_t offset) const {
        return static_cast<double>(values_.at(i * stride + offset));
    }
    [[nodiscard]] host::real3 vector(std::size_t i, std::size_t stride, std::size_t offset) const {
        return {scalar(i, stride, offset), scalar(i, stride, offset + 1), scalar(i, stride, offset + 2)};
    }

private:
    std::vector<float> values_;
};

/// Results of kernel `name`, `outputs` an item; items = inputs / stride.
inline std::vector<double> run_formula(const std::string& name, const Inputs& in, std::size_t stride,
                                       std::size_t outputs) {
    const std::size_t count = in.values().size() / stride;
    std::vector<float> out(count * outputs);
    Device& d = device();
    const Buffer from = d.upload(in.values());
    Buffer to = d.upload(out);
    Kernel kernel = d.kernel("formulas_test.cl", name, {});
    kernel.arg(from).arg(to).arg(static_cast<std::uint32_t>(count)).run((count + 63) / 64, 64);
    d.read(to, out.data(), out.size() * sizeof(float));
    return {out.begin(), out.end()};
}

inline host::real3 vector_at(const std::vector<double>& v, std::size_t at) {
    return {v.at(at), v.at(at + 1), v.at(at + 2)};
}

constexpr double kEps = 5.9604644775390625e-8;  ///< 2^-24: the relative rounding of one float32 operation

}  // namespace irradia::test
