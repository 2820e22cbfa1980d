#include "small_scene.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <fstream>
#include <iterator>

namespace irradia::test {

namespace fs = std::filesystem;

namespace {

shared::Light light(std::uint32_t kind, float probability, float cdf) {
    shared::Light l{};
    l.texture = IR_NO_TEXTURE;
    l.kind = kind;
    l.e1x = l.e2y = l.nz = 1.0f;
    l.area = l.radius = 1.0f;
    l.r = l.g = l.b = 2.0f;
    l.probability = probability;
    l.cdf = cdf;
    return l;
}

shared::Bvh8Node empty_bvh8_node() {
    shared::Bvh8Node n{};
    std::fill_n(n.child, 8, IR_EMPTY);
    for (int i = 0; i < 8; ++i) {
        n.lo_x[i] = n.lo_y[i] = n.lo_z[i] = 1e30f;
        n.hi_x[i] = n.hi_y[i] = n.hi_z[i] = -1e30f;
    }
    return n;
}

void add_child(shared::Bvh8Node& n, std::uint32_t reference) {
    const std::uint32_t i = n.count++;
    n.child[i] = reference;
    n.lo_x[i] = n.lo_y[i] = n.lo_z[i] = -1.0f;
    n.hi_x[i] = n.hi_y[i] = n.hi_z[i] = 1.0f;
}

void build_accel(Scene& s) {
    shared::TriangleBlock block{};
    std::fill_n(block.primitive, 8, IR_NO_PRIMITIVE);
    for (std::uint32_t i = 0; i < 2; ++i) {
        const shared::Triangle& t = s.triangles[i];
        const shared::Vertex &a = s.vertices[t.v0], &b = s.vertices[t.v1], &c = s.vertices[t.v2];
        block.v0x[i] = a.px, block.v0y[i] = a.py, block.v1x[i] = b.px, block.v1y[i] = b.py;
        block.v2x[i] = c.px, block.v2y[i] = c.py;
        block.primitive[i] = i;
        s.accel.bvh2_triangles.push_back({a.px, a.py, a.pz, i, b.px, b.py, b.pz, 0, c.px, c.py, c.pz, 0});
    }
    s.accel.bvh8_triangles = {block};
    s.accel.bvh8_nodes.assign(2, empty_bvh8_node());
    add_child(s.accel.bvh8_nodes[0], 1);
    add_child(s.accel.bvh8_nodes[0], IR_LEAF | IR_LEAF_ANALYTIC | 1u << 24 | 0u);
    add_child(s.accel.bvh8_nodes[1], IR_LEAF | 2u << 24 | 0u);
    shared::Bvh2Node n{};
    n.lo0x = n.lo0y = n.lo0z = n.lo1x = n.lo1y = n.lo1z = -1.0f;
    n.hi0x = n.hi0y = n.hi0z = n.hi1x = n.hi1y = n.hi1z = 1.0f;
    s.accel.bvh2_nodes.assign(2, n);
    s.accel.bvh2_nodes[0].child0 = 1;
    s.accel.bvh2_nodes[0].child1 = IR_LEAF | IR_LEAF_ANALYTIC | 1u << 24 | 0u;
    s.accel.bvh2_nodes[1].child0 = IR_LEAF | 1u << 24 | 0u;
    s.accel.bvh2_nodes[1].child1 = IR_LEAF | 1u << 24 | 1u;
}

}  // namespace

Scene small_scene() {
    Scene s;
    s.vertices = {
        {-1, -1, 0, 0, 0, 1, 0, 0}, {1, -1, 0, 0, 0, 1, 1, 0}, {1, 1, 0, 0, 0, 1, 1, 1}, {-1, 1, 0, 0, 0, 1, 0, 1}};
    s.triangles = {{0, 0, 1, IR_TRIANGLE_FLAT | IR_TRIANGLE_HAS_UV, 0, 1, 2, 0, 0, 0, 0, 0},
                   {0, 0, 1, IR_TRIANGLE_HAS_UV, 0, 2, 3, 1, IR_NO_LIGHT, 0, 0, 0}};
    shared::Analytic sphere{};
    sphere.radius = 0.5f;
    sphere.kind = IR_ANALYTIC_SPHERE;
    sphere.ux = sphere.vz = sphere.sign = 1.0f;
    sphere.material = 1;
    sphere.light = IR_NO_LIGHT;
    s.analytics = {sphere};
    s.materials = {blank_material(), blank_material()};
    s.materials[0].texture = 2;
    s.materials[0].r = s.materials[0].g = s.materials[0].b = 0.5f;
    s.materials[1].back = 1;
    s.materials[1].r = 1.0f;
    s.materials[1].b = 0.25f;
    const auto texture = [](std::uint32_t offset, std::uint32_t w, std::uint32_t h, std::uint32_t format) {
        shared::Texture t{};
        t.offset = offset, t.width = w, t.height = h, t.format = format;
        t.m00 = t.m11 = 1.0f;
        return t;
    };
    s.textures = {texture(0, 3, 2, IR_TEXTURE_RGBA8_SRGB), texture(6, 2, 2, IR_TEXTURE_RGBA8_LINEAR),
                  texture(10, 2, 1, IR_TEXTURE_RGB32F)};
    for (std::uint32_t i = 0; i < 10; ++i) s.texels.push_back(0x01020304u * i);
    for (std::uint32_t i = 0; i < 6; ++i) s.texels.push_back(std::bit_cast<std::uint32_t>(static_cast<float>(i) / 8));
    s.lights = {light(IR_LIGHT_TRIANGLE, 0.5f, 0.5f), light(IR_LIGHT_POINT, 0.125f, 0.625f),
                light(IR_LIGHT_DIRECTIONAL, 0.125f, 0.75f), light(IR_LIGHT_CONSTANT, 0.25f, 1.0f)};
    s.info.camera = {0, 0, 5, 0.01f, -1, 1, -1, 1000, 2, 0, 0, 0.01f, 0, -2, 0, 0, 0, 0, -1, 0};
    s.info.width = 16;
    s.info.height = 9;
    s.info.rfilter = IR_RFILTER_GAUSSIAN;
    s.info.rfilter_radius = 2.0f;
    s.info.rfilter_stddev = 0.5f;
    s.info.triangle_count = 2;
    s.info.analytic_count = 1;
    s.info.light_count = 4;
    s.info.environment_light = 3;
    s.info.diagonal = 3.0f;
    s.info.min_x = s.info.min_y = s.info.min_z = -1.0f;
    s.info.max_x = s.info.max_y = s.info.max_z = 1.0f;
    s.features = IR_FEATURE_TEXTURES | IR_FEATURE_ANALYTIC | IR_FEATURE_SMOOTH_NORMALS | IR_FEATURE_ENVIRONMENT |
                 IR_FEATURE_DELTA_LIGHTS;
    s.centre = {1e6, -0.1, 1.0 / 3.0};
    s.sample_count = 17;
    s.source = "folder/scene.xml";
    build_accel(s);
    return s;
}

TemporaryFolder::TemporaryFolder() {
    static std::atomic<int> count{0};
    path = fs::temp_directory_path() / ("irradia-core-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    fs::create_directories(path);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
}

std::size_t TemporaryFolder::count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator()));
}

std::string read_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_file(const std::string& path, const std::string& bytes) {
    // A new file: some file systems write a truncated and rewritten one to the disk at once.
    fs::remove(path);
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace irradia::test
