// Irradiance caching. The image is cut into 16x16 blocks; iteration `it` handles one pixel of every block at once:
//   1. find_misses         a camera ray; at its diffuse hit look into the octree; without enough records the point goes
//                          on the record stack;
//   2. sample_hemispheres  one record for every point on the stack;
//   3. insert_records      neighbour clamp, then into the octree, which the next iteration looks into.
// Before them the irradiance grid is filled, which answers the hemispheres' second bounce. After the 256 iterations
// every pixel is shaded with all its samples. Where a sample finds no record, because clamping un-covered it or because
// samples off the pixel's centre see surfaces of their own, one is made, and the pixel is shaded anew, until none is
// missing. The host owns the stack, the octree's memory and the schedule; everything else happens in kernels.
#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <unordered_set>

#include "cache/RecordCache.h"
#include "irradia/Error.h"
#include "render/hemispheres.h"
#include "render/iteration_order.h"
#include "render/methods.h"

namespace irradia {
namespace {

constexpr std::uint32_t samples_a_launch = 256;  // float32 sums of a pixel; the host adds launches in double
constexpr std::size_t pixels_a_launch_cpu = 1u << 14, pixels_a_launch_gpu = 1u << 20;
constexpr std::uint32_t record_rounds = 24;  // after so many, samples that still find no record are path traced
constexpr double records_share = 0.5;        // of the progress bar

CacheSettings cache_settings(const Run& run) {
    const RenderSettings& s = run.settings;
    const shared::SceneInfo& info = run.scene.info;
    CacheSettings c;
    c.lower = {info.min_x, info.min_y, info.min_z};
    c.upper = {info.max_x, info.max_y, info.max_z};
    // Angles as distances: the picture's weights reach `overlap` times farther than those records are placed by.
    // (1.8): e_n counts in units of a. (1.11): in units of 1/kappa = 2a, times sqrt(1 - cos 10°) = .123257.
    c.inverse_angle =
        (s.weight == WeightRule::tabellion ? 1.0f / (2.0f * s.accuracy * 0.123257f) : 1.0f / s.accuracy) / s.overlap;
    c.in_front_slope = s.in_front ? 0.05f : 0.0f;
    c.weight = static_cast<std::uint32_t>(s.weight);
    c.clamp_slope = neighbour_clamp_slope(s);
    c.min_spacing = s.min_spacing * s.overlap;
    c.placement_stretch = s.overlap;
    return c;
}

class IrradianceCaching {
public:
    IrradianceCaching(Run& run, Film& film)
        : run_(run),
          film_(film),
          cache_(run.device, cache_settings(run)),
          hemispheres_(run, true),
          grid_(run),
          chunk_(std::min(film.pixels(), run.device.cpu_traversal() ? pixels_a_launch_cpu : pixels_a_launch_gpu)) {
        defines_ = cache_.defines();
        defines_["IR_DIRECT_MIS"] = run.direct_mis() ? "1" : "0";
        defines_["IR_SHARE_LOOKUPS"] = run.settings.share_lookups ? "1" : "0";
    }

    std::vector<std::uint32_t> render() {
        if (run_.edges_beyond_camera() >= 2) {
            grid_.fill();
            run_.phase("grid");
            place_records();
            run_.phase("records");
        }
        shade();
        run_.phase("shade");
        RenderStatistics& s = run_.statistics;
        s.records = cache_.size();
        s.octree_nodes = cache_.octree().nodes;
        s.octree_entries = cache_.octree().entries;
        s.octree_depth = cache_.octree().depth;
        s.octree_growths = cache_.octree().growths;
        std::vector<std::uint32_t> pixels;
        for (const shared::RecordValue& v : cache_.download_values()) pixels.push_back(v.pixel);
        return pixels;
    }

private:
    // Stages 2 and 3 for points[indices]. `salt`: see HemisphereSampler.
    void make_records(const Buffer& points, const RecordStack& stack, std::uint32_t salt) {
        if (stack.empty()) return;
        const Buffer indices = run_.device.upload(stack.indices);
        const std::uint32_t first = cache_.reserve(stack.size());
        hemispheres_.sample(points, indices, stack.size(), grid_, cache_.keys(), cache_.values(), first, salt);
        cache_.insert(stack.size(), points, indices);
    }

    void place_records() {
        const std::uint32_t blocks_x = (run_.scene.info.width + block_edge - 1) / block_edge;
        const std::uint32_t blocks_y = (run_.scene.info.height + block_edge - 1) / block_edge;
        const std::size_t blocks = static_cast<std::size_t>(blocks_x) * blocks_y;
        Buffer points = run_.device.allocate(blocks * sizeof(shared::ShadingPoint));
        std::vector<shared::ShadingPoint> host(blocks);
        for (std::uint32_t it = 0; it < iteration_count; ++it) {
            const BlockPixel pixel = block_pixel(it);
            Kernel kernel = run_.scene_kernel("find_misses.cl", "find_misses", cache_.defines());
            cache_.bind(kernel, true)
                .arg(points)
                .arg(pixel.x)
                .arg(pixel.y)
                .arg(blocks_x)
                .arg(static_cast<std::uint32_t>(blocks))
                .run(group_count(blocks, run_.device.pixel_group()), run_.device.pixel_group());
            run_.device.read(points, host.data(), blocks * sizeof host[0]);
            run_.statistics.rays["camera"] += blocks;
            RecordStack stack;
            for (std::uint32_t b = 0; b < blocks; ++b)
                if (host[b].state != IR_POINT_NONE) stack.indices.push_back(b);
            make_records(points, stack, 0);
            ++run_.statistics.iterations;
            run_.report("records", records_share * (it + 1) / iteration_count, cache_.size());
        }
    }

    // Pixels with a sample that no record reaches, and the first such place of each.
    struct Missed {
        std::vector<std::uint32_t> pixels;
        std::vector<shared::ShadingPoint> points;
    };

    // Adds all samples of `pixels` to the film.
    Missed shade_pixels(const std::vector<std::uint32_t>& pixels, bool requests) {
        Missed missed;
        Buffer film = run_.device.allocate(chunk_ * film_.channels() * sizeof(float));
        Buffer points = run_.device.allocate(chunk_ * sizeof(shared::ShadingPoint));
        std::vector<float> sums(chunk_ * film_.channels());
        std::vector<shared::ShadingPoint> host(chunk_);
        for (std::size_t first = 0; first < pixels.size(); first += chunk_) {
            const std::vector<std::uint32_t> part(
                pixels.begin() + static_cast<std::ptrdiff_t>(first),
                pixels.begin() + static_cast<std::ptrdiff_t>(std::min(pixels.size(), first + chunk_)));
            const Buffer list = run_.device.upload(part);
            std::vector<bool> seen(part.size(), false);
            for (std::uint32_t sample = 0; sample < run_.spp(); sample += samples_a_launch) {
                const std::uint32_t samples = std::min(samples_a_launch, run_.spp() - sample);
                std::map<std::string, std::string> defines = grid_.defines();
                defines.insert(defines_.begin(), defines_.end());
                Kernel kernel = run_.scene_kernel("shade_pixels.cl", "shade_pixels", defines);
                cache_.bind(kernel, false);
                grid_.bind(kernel)
                    .arg(list)
                    .arg(film)
                    .arg(points)
                    .arg(run_.ray_counters())
                    .arg(static_cast<std::uint32_t>(part.size()))
                    .arg(sample)
                    .arg(samples)
                    .arg(run_.edges_beyond_camera())
                    .arg(requests ? 1u : 0u)
                    .arg(run_.seed())
                    .run(group_count(part.size(), run_.device.pixel_group()), run_.device.pixel_group());
                run_.device.read(film, sums.data(), part.size() * film_.channels() * sizeof(float));
                film_.add(sums, part, samples);
                run_.device.read(points, host.data(), part.size() * sizeof host[0]);
                for (std::size_t i = 0; i < part.size(); ++i)
                    if (host[i].state != IR_POINT_NONE && !seen[i]) {
                        seen[i] = true;
                        missed.pixels.push_back(part[i]);
                        missed.points.push_back(host[i]);
                    }
                run_.collect_rays();
                const double done =
                    static_cast<double>(first) + static_cast<double>(part.size()) * (sample + samples) / run_.spp();
                run_.report("shade", records_share + (1 - records_share) * done / static_cast<double>(film_.pixels()),
                            cache_.size());
            }
        }
        return missed;
    }

    // Of the pixels of a 4x4 tile that miss a record one gets it a round, since that often covers the others; every
    // round makes progress, so it ends.
    void shade() {
        std::vector<std::uint32_t> pixels(film_.pixels());
        std::iota(pixels.begin(), pixels.end(), 0u);
        std::set<std::tuple<std::uint32_t, float, float, float>> made;
        for (std::uint32_t round = 1; !pixels.empty(); ++round) {
            const Missed missed = shade_pixels(pixels, round < record_rounds);
            RecordStack stack;
            std::unordered_set<std::uint64_t> tiles;
            for (std::uint32_t i = 0; i < missed.pixels.size(); ++i) {
                film_.clear(missed.pixels[i]);
                const shared::ShadingPoint& q = missed.points[i];
                const std::uint32_t x = missed.pixels[i] % run_.scene.info.width,
                                    y = missed.pixels[i] / run_.scene.info.width;
                if (!tiles.insert((static_cast<std::uint64_t>(y / 4) << 32) | (x / 4)).second) continue;
                stack.indices.push_back(i);
                if (!made.insert({q.pixel, q.px, q.py, q.pz}).second)
                    throw Error(
                        "pixel " + std::to_string(x) + ", " + std::to_string(y) +
                        ": the record made there does not cover it (an error in the program: please report it)");
            }
            if (!missed.points.empty()) {
                make_records(run_.device.upload(missed.points), stack, round);
                ++run_.statistics.iterations;
            }
            pixels = missed.pixels;
        }
    }

    Run& run_;
    Film& film_;
    RecordCache cache_;
    HemisphereSampler hemispheres_;
    IrradianceGrid grid_;
    std::size_t chunk_;
    std::map<std::string, std::string> defines_;
};

}  // namespace

std::vector<std::uint32_t> render_irradiance(Run& run, Film& film) { return IrradianceCaching(run, film).render(); }

}  // namespace irradia
