// Light must not leak into narrow places: cornell-a's lamp hangs .01 under the ceiling, 1.3 pixels of its picture, and
// what is seen of the ceiling over its edge is all but dark. The reference is tests/data/etalon. Nor beside ledges:
// behind one half a pixel high, light that comes at 40 degrees leaves a strip dark that no hemisphere outside of it
// knows.
#include <cmath>
#include <vector>

#include "irradia/Image.h"
#include "render_fixture.h"

namespace irradia::test {
namespace {

constexpr int seeds = 8;
constexpr int width = 256, row = 31, first = 106, last = 149;  // where the gap shows, in pixels

// Mean radiance there, red.
double in_gap(const UntouchedVector<float>& x) {
    double sum = 0;
    for (int i = first; i <= last; ++i) sum += static_cast<double>(x[3 * static_cast<std::size_t>(row * width + i)]);
    return sum / (last - first + 1);
}

TEST(Narrow, RecordsOutsideDoNotShineIntoAGap) {
    const Image reference = read_image(test_data("etalon/cornell-a.a.exr"));
    ASSERT_EQ(reference.width, width);
    const double dark = in_gap(reference.layers[0].data);
    EXPECT_LT(dark, .03);  // the ceiling beside it: .2
    const Scene scene = load(test_data("peers/cornell-a.xml"));
    Device device({});
    RenderSettings s;
    apply_quality(s, Quality::medium);
    const RenderResult with = render(scene, device, s);
    s.reach_limit = false;  // neither near surfaces nor narrow places limit records
    const RenderResult without = render(scene, device, s);
    const double light = in_gap(with.image.layers[0].data), leak = in_gap(without.image.layers[0].data);
    std::printf("in the gap: %.4f, with narrow places %.4f, without %.4f; records %d, %d\n", dark, light, leak,
                static_cast<int>(with.statistics.records), static_cast<int>(without.statistics.records));
    EXPECT_GT(leak, 5 * dark);
    // What is left: pixels half of which show the ceiling outside, nearer to the gap than --min-spacing.
    EXPECT_LT(std::abs(light - dark), .5 * (leak - dark));
}

// How close records in a narrow place may lie is a setting of its own: closer ones keep light out, at more records.
// Where records come to lie changes what gets in by a third from seed to seed: means of eight. Rays enough that nothing
// else does.
TEST(Narrow, GapSpacingTradesRecordsForLight) {
    const double dark = in_gap(read_image(test_data("etalon/cornell-a.a.exr")).layers[0].data);
    const Scene scene = load(test_data("peers/cornell-a.xml"));
    Device device({});
    RenderSettings s;
    apply_quality(s, Quality::medium);
    s.spp = 4;
    s.hemisphere_m = 32;
    s.hemisphere_n = 64;
    const auto with_spacing = [&](float spacing) {
        s.gap_spacing = spacing;
        return render(scene, device, s);
    };
    double leak[2] = {}, records[2] = {};
    for (s.seed = 0; s.seed < seeds; ++s.seed)
        for (std::size_t i = 0; i < 2; ++i) {
            const RenderResult r = with_spacing(i == 0 ? 0.3f : 2);
            leak[i] += (in_gap(r.image.layers[0].data) - dark) / seeds;
            records[i] += static_cast<double>(r.statistics.records) / seeds;
        }
    std::printf("spacing .3: %.4f too bright, %.0f records; 2: %.4f, %.0f\n", leak[0], records[0], leak[1], records[1]);
    EXPECT_LT(std::abs(leak[0]), .75 * leak[1]);
    EXPECT_GT(records[0], records[1]);
    // Never farther apart than elsewhere, in medium 2 pixels.
    const RenderResult near = with_spacing(2), far = with_spacing(50);
    EXPECT_EQ(near.image.layers[0].data, far.image.layers[0].data);
    EXPECT_EQ(near.statistics.records, far.statistics.records);
}

// A ledge .016 high along x = 0 of a floor; pixels are .024 wide. A spot lights a tilted patch to the right, and only
// that: what arrives on the floor is indirect, and leaves .019 to the left of the ledge dark.
constexpr const char* ledge = R"(<scene version="3.0.0"><integrator type="path"/>
  <sensor type="perspective"><float name="fov" value="16"/>
    <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="16"/><rfilter type="box"/></film>
  </sensor>
  <bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf></bsdf>
  <shape type="rectangle"><transform name="to_world"><scale x="3" y="3"/></transform><ref id="white"/></shape>
  <shape type="cube"><transform name="to_world"><scale x="0.05" y="3" z="0.008"/>
    <translate x="0.05" z="0.008"/></transform><ref id="white"/></shape>
  <shape type="rectangle"><transform name="to_world"><scale x="0.15" y="1.5"/>
    <lookat origin="1.5,0,1.3" target="0,0,0" up="0,1,0"/></transform><ref id="white"/></shape>
  <emitter type="spot"><transform name="to_world"><lookat origin="-1,0,0.6" target="1.5,0,1.3" up="0,1,0"/></transform>
    <float name="cutoff_angle" value="10"/><float name="beam_width" value="8"/><rgb name="intensity" value="40"/></emitter>
</scene>)";

/// Mean radiance of the column left of the ledge, red.
double beside_ledge(const RenderResult& r) {
    double sum = 0;
    for (std::size_t y = 0; y < 16; ++y) sum += static_cast<double>(r.image.layers[0].data[3 * (48 * y + 23)]);
    return sum / 16;
}

// Against paths, whose 262 144 samples of the column know that light to 4 %. Means of sixteen seeds, and rays enough:
// see above.
TEST(Narrow, RecordsOutsideDoNotShineBehindALedge) {
    const Scene scene = load_text(ledge);
    Device device({});
    RenderSettings s;
    s.method = Method::path;
    s.spp = 16384;
    const double dark = beside_ledge(render(scene, device, s));
    for (const auto& [quality, part] : {std::pair{Quality::medium, .55}, {Quality::fine, .3}}) {
        s = {};
        apply_quality(s, quality);
        s.hemisphere_m = 32;
        s.hemisphere_n = 64;
        s.grid_paths = 1 << 19;
        double light = 0, leak = 0;
        for (s.seed = 0; s.seed < 2 * seeds; ++s.seed) {
            s.reach_limit = true;
            light += beside_ledge(render(scene, device, s)) / (2 * seeds);
            s.reach_limit = false;
            leak += beside_ledge(render(scene, device, s)) / (2 * seeds);
        }
        std::printf("beside the ledge: %.4f, with narrow places %.4f, without %.4f\n", dark, light, leak);
        EXPECT_GT(leak, 2 * dark);
        EXPECT_LT(std::abs(light - dark), part * (leak - dark));
    }
}

}  // namespace
}  // namespace irradia::test
