// Light must not leak into narrow places: cornell-a's lamp hangs .01 under the ceiling, 1.3 pixels of its picture, and
// what is seen of the ceiling over its edge is all but dark. The reference is tests/data/etalon.
#include <cmath>
#include <vector>

#include "irradia/Image.h"
#include "render_fixture.h"

namespace irradia::test {
namespace {

constexpr int width = 256, row = 31, first = 106, last = 149;  // where the gap shows, in pixels

// Mean radiance there, red.
double in_gap(const std::vector<float>& x) {
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
TEST(Narrow, GapSpacingTradesRecordsForLight) {
    const double dark = in_gap(read_image(test_data("etalon/cornell-a.a.exr")).layers[0].data);
    const Scene scene = load(test_data("peers/cornell-a.xml"));
    Device device({});
    RenderSettings s;
    apply_quality(s, Quality::medium);
    s.spp = 16;
    std::vector<double> leak;
    std::vector<std::uint64_t> records;
    for (const float spacing : {0.3f, 2.0f, 50.0f}) {  // the last: that of records elsewhere, 2 in medium
        s.gap_spacing = spacing;
        const RenderResult r = render(scene, device, s);
        leak.push_back(in_gap(r.image.layers[0].data) - dark);
        records.push_back(r.statistics.records);
        std::printf("spacing %.1f: %.4f too bright, %d records\n", static_cast<double>(spacing), leak.back(),
                    static_cast<int>(records.back()));
    }
    EXPECT_LT(std::abs(leak[0]), .75 * leak[1]);
    EXPECT_GT(records[0], records[1]);
    EXPECT_EQ(leak[1], leak[2]);  // never farther apart than elsewhere
    EXPECT_EQ(records[1], records[2]);
}

}  // namespace
}  // namespace irradia::test
