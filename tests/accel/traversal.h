// Runs the kernels of cl/trace_test.cl over a scene on the first CPU OpenCL device, with either traversal header.
// OpenCL is used directly: what is tested here are the headers, not src/device, of which only the resolved source is
// taken (compilers split their options at blanks, so an -I of a path is none to rely on).
#pragma once
#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS
#include <CL/opencl.hpp>

#include <algorithm>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/kernel_source.h"
#include "irradia/Scene.h"

namespace irradia::testing {

struct Ray {
    float ox, oy, oz, t_min, dx, dy, dz, t_max;
};

struct DeviceHit {
    float t, u, v;
    std::uint32_t primitive;
};

inline cl::Device first_device(cl_device_type type) {
    std::vector<cl::Platform> platforms;
    cl::Platform::get(&platforms);
    for (const cl::Platform& p : platforms) {
        std::vector<cl::Device> devices;
        try {
            p.getDevices(type, &devices);
        } catch (const cl::Error&) {
            continue;  // CL_DEVICE_NOT_FOUND
        }
        if (!devices.empty()) return devices[0];
    }
    throw std::runtime_error("no OpenCL device of the type asked for");
}

class Traversal {
public:
    /// `cpu_traversal`: cl/trace_cpu.h, else cl/trace_gpu.h. Both run on any device.
    Traversal(const Scene& scene, bool cpu_traversal, const cl::Device& device = first_device(CL_DEVICE_TYPE_CPU))
        : context_(device), queue_(context_, device) {
        const bool analytic = !scene.analytics.empty();
        program_ = cl::Program(context_, device::expand_source("trace_test.cl"));
        const std::string options = std::string("-cl-std=CL1.2 ") + (cpu_traversal ? "-D IR_CPU " : "") +
                                    "-D IR_FEATURES=" + (analytic ? "IR_FEATURE_ANALYTIC" : "0u");
        try {
            program_.build(options.c_str());
        } catch (const cl::Error&) {
            throw std::runtime_error(program_.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device));
        }
        if (cpu_traversal) {
            nodes_ = upload(scene.accel.bvh8_nodes);
            leaves_ = upload(scene.accel.bvh8_triangles);
        } else {
            nodes_ = upload(scene.accel.bvh2_nodes);
            leaves_ = upload(scene.accel.bvh2_triangles);
        }
        analytics_ = upload(scene.analytics);
        triangles_ = upload(scene.triangles);
        vertices_ = upload(scene.vertices);
        info_ = upload(std::vector<shared::SceneInfo>{scene.info});
        unused_ = upload(std::vector<std::uint32_t>{0});
    }

    std::vector<DeviceHit> closest(const std::vector<Ray>& rays) {
        return run<DeviceHit>("test_closest", rays, rays.size(), {});
    }
    std::vector<std::uint32_t> occluded(const std::vector<Ray>& rays) {
        return run<std::uint32_t>("test_occluded", rays, rays.size(), {});
    }
    /// Tiles of `tile` <= 16 consecutive rays, which must share origin and t_min.
    std::vector<DeviceHit> tiles(const std::vector<Ray>& rays, std::uint32_t tile) {
        const RaySet set = prepare_tiles(rays, tile);
        launch("test_tile", set, (rays.size() + tile - 1) / tile, {tile});
        return results<DeviceHit>(set);
    }

    /// Tiles of `tile` <= 16 consecutive rays, which must share t_min.
    std::vector<std::uint32_t> occluded_tiles(const std::vector<Ray>& rays, std::uint32_t tile) {
        const RaySet set = prepare_own_origins(rays, tile);
        launch("test_tile_occluded", set, (rays.size() + tile - 1) / tile, {tile});
        return results<std::uint32_t>(set);
    }

    /// Rays on the device, and room for 16 bytes of result each.
    struct RaySet {
        cl::Buffer rays, results;
        std::size_t count;
    };
    RaySet prepare(const std::vector<Ray>& rays) {
        return {upload(rays), cl::Buffer(context_, CL_MEM_READ_WRITE, std::max<std::size_t>(rays.size(), 1) * 16),
                rays.size()};
    }

    /// The layout of kernel test_tile.
    RaySet prepare_tiles(const std::vector<Ray>& rays, std::uint32_t tile) {
        std::vector<float> in((rays.size() + tile - 1) / tile * 64);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            float* t = in.data() + i / tile * 64;
            const Ray& r = rays[i];
            t[i % tile] = r.dx, t[16 + i % tile] = r.dy, t[32 + i % tile] = r.dz;
            t[48] = r.ox, t[49] = r.oy, t[50] = r.oz, t[51] = r.t_min;
        }
        return {upload(in), prepare(rays).results, rays.size()};
    }

    /// The layout of kernel test_tile_occluded.
    RaySet prepare_own_origins(const std::vector<Ray>& rays, std::uint32_t tile) {
        std::vector<float> in((rays.size() + tile - 1) / tile * 128);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            float* t = in.data() + i / tile * 128 + i % tile;
            const Ray& r = rays[i];
            t[0] = r.ox, t[16] = r.oy, t[32] = r.oz, t[48] = r.dx, t[64] = r.dy, t[80] = r.dz, t[96] = r.t_max;
            in[i / tile * 128 + 112] = r.t_min;
        }
        return {upload(in), prepare(rays).results, rays.size()};
    }

    /// Runs kernel `name` over `items` work-items to its end; `extra` arguments lie between count and results.
    void launch(const std::string& name, const RaySet& set, std::size_t items,
                const std::vector<std::uint32_t>& extra) {
        cl::Kernel& kernel = kernels_.try_emplace(name, program_, name.c_str()).first->second;
        cl_uint i = 0;
        for (const cl::Buffer* b : {&nodes_, &leaves_, &analytics_, &triangles_, &vertices_}) kernel.setArg(i++, *b);
        for (int k = 0; k < 4; ++k) kernel.setArg(i++, unused_);
        kernel.setArg(i++, info_);
        kernel.setArg(i++, set.rays);
        kernel.setArg(i++, static_cast<cl_uint>(set.count));
        for (const std::uint32_t e : extra) kernel.setArg(i++, e);
        kernel.setArg(i++, set.results);
        constexpr std::size_t kGroup = 64;
        queue_.enqueueNDRangeKernel(kernel, 0, (items + kGroup - 1) / kGroup * kGroup, kGroup);
        queue_.finish();
    }

    template <class Result>
    std::vector<Result> run(const std::string& name, const std::vector<Ray>& rays, std::size_t items,
                            const std::vector<std::uint32_t>& extra) {
        const RaySet set = prepare(rays);
        launch(name, set, items, extra);
        return results<Result>(set);
    }

    template <class Result>
    std::vector<Result> results(const RaySet& set) {
        std::vector<Result> out(set.count);
        queue_.enqueueReadBuffer(set.results, true, 0, out.size() * sizeof(Result), out.data());
        return out;
    }

private:
    template <class T>
    cl::Buffer upload(const std::vector<T>& v) {
        if (v.empty()) return cl::Buffer(context_, CL_MEM_READ_ONLY, 512);
        cl::Buffer b(context_, CL_MEM_READ_ONLY, v.size() * sizeof(T));
        queue_.enqueueWriteBuffer(b, true, 0, v.size() * sizeof(T), v.data());
        return b;
    }

    cl::Context context_;
    cl::CommandQueue queue_;
    cl::Program program_;
    cl::Buffer nodes_, leaves_, analytics_, triangles_, vertices_, info_, unused_;
    std::map<std::string, cl::Kernel> kernels_;
};

}  // namespace irradia::testing
