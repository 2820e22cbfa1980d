#include "render/point_list.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace irradia {
namespace {
// Entries read together with their number: most lists are short, and a second transfer costs a GPU more than these.
constexpr std::size_t read_at_once = 256;
}  // namespace

PointList::PointList(Device& device, std::size_t capacity)
    : device_(device), capacity_(capacity), points_(device.allocate((capacity + 1) * sizeof(shared::ShadingPoint))) {
    // What is read along with a short list is not left to chance.
    device.fill(points_, 0, (std::min(capacity, read_at_once) + 1) * sizeof(shared::ShadingPoint));
}

const Buffer& PointList::emptied() {
    const shared::ShadingPoint none{};
    device_.write(points_, &none, sizeof none);
    return points_;
}

void PointList::read() {
    const std::size_t first = std::min(capacity_, read_at_once) + 1;
    host_.resize(std::max(host_.size(), first));
    device_.read(points_, host_.data(), first * sizeof host_[0]);
    const std::size_t count = host_[0].state;
    if (count + 1 > first) {
        host_.resize(std::max(host_.size(), count + 1));
        device_.read(points_, host_.data() + first, (count + 1 - first) * sizeof host_[0], first * sizeof host_[0]);
    }
    indices_.resize(count);
    std::iota(indices_.begin(), indices_.end(), 1u);
    // Of one pixel in an order of their own, whichever came first.
    const auto place = [&](std::uint32_t i) {
        const shared::ShadingPoint& q = host_[i];
        return std::tie(q.pixel, q.px, q.py, q.pz);
    };
    std::sort(indices_.begin(), indices_.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    sorted_.resize(count);
    for (std::size_t i = 0; i < count; ++i) sorted_[i] = host_[indices_[i]];
}

}  // namespace irradia
