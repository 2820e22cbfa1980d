// Radiance records' samples asked on the device, against reproject.h and the BSDFs in double; which records and which
// representation answer; furnaces.
#include "radiance_records.h"

namespace irradia::test {
namespace {
using namespace irradia::host;
using Question = RadianceRecords::Question;

class RadianceRecord : public RadianceTest {};
INSTANTIATE_TEST_SUITE_P(Traversals, RadianceRecord, ::testing::Values("cpu", "gpu"), traversal_name);

std::mt19937 generator(37);

// ---- one record
// ------------------------------------------------------------------------------------------------------

/// The record of one case of reproject.json, grey.
PlacedRecord record_of_case(const json& c) {
    PlacedRecord r{vec3(c["record_p"]), {6, 20, make_frame(vec3(c["record_n"])), {}}};
    for (std::size_t s = 0; s < c["dirs"].size(); ++s) {
        const double L = c["L"][s];
        r.h.samples.push_back({to_local(r.h.frame, vec3(c["dirs"][s])), to_local(r.h.frame, vec3(c["hit_normal"][s])),
                               make_real3(L, L, L), c["r"][s]});
    }
    return r;
}

/// The sums that samples_sum adds up, up to one factor: reproject.h with lobes in double.
RadianceRecords::Sums sums_in_double(const PlacedRecord& r, const shared::Material& m, const Question& q) {
    const Frame frame = make_frame(q.n);
    const real3 wi = to_local(frame, q.view);
    const Microfacets facets = facets_of(m, q.alpha);
    RadianceRecords::Sums sums{};
    for (const HemisphereSample& s : r.h.samples) {
        const ReprojectedSample t = reproject_sample(r.p - q.p, to_world(r.h.frame, s.direction), s.distance,
                                                     to_world(r.h.frame, s.normal), s.direction.z, q.n);
        if (t.cosine == 0) continue;
        double c;
        const double lobe = facet_lobe(facets, wi, to_local(frame, t.direction), &c) / t.cosine;  // without the cosine
        const Vec f = schlick_fresnel(m, c);
        const auto add = [&](double value, double radiance, double& weighted, double& total) {
            const ReprojectedSum one =
                reprojected_add(reprojected_sum_zero(), t, value, make_real3(radiance, radiance, radiance));
            weighted += one.weighted.x;
            total += one.total;
        };
        add(lobe * f[0], s.radiance.x, sums.weighted.x, sums.total.x);
        add(lobe * f[1], s.radiance.y, sums.weighted.y, sums.total.y);
        add(lobe * f[2], s.radiance.z, sums.weighted.z, sums.total.z);
    }
    return sums;
}

/// Materials of the tests: a plastic and metals, of both distributions.
std::vector<shared::Material> some_materials() {
    return {coated(1.5, .3), coated(1.9, .1, true), metal("Cu", .2), metal("Al", .5, true), metal("none", .1)};
}

// Directions and solid angles are good to a few roundings over the vectors' smallest cosines (5e-6 as in
// DeviceReproject), lobes to some more over the roughness.
TEST_P(RadianceRecord, SamplesAnswerAsInDouble) {
    LobeTables tables(device(), some_materials(), 0);
    for (const json& c : load_vectors("reproject", "cases")) {
        const PlacedRecord record = record_of_case(c);
        RadianceRecords records(device(), tables, {record});
        const Frame frame = frame_of(c);
        std::vector<Question> questions;
        for (std::uint32_t i = 0; i < some_materials().size(); ++i)
            for (const auto& view : {vec3(c["wo_local"]), make_real3(0, 0, 1), to_real3(direction_at(.1, 2))})
                questions.push_back(
                    {i, static_cast<double>(tables.material(i).alpha_u), vec3(c["p"]), frame.n, to_world(frame, view)});
        const auto found = records.sums(questions, std::vector<std::uint32_t>(questions.size(), 0));
        for (std::size_t i = 0; i < questions.size(); ++i) {
            const auto wanted = sums_in_double(record, tables.material(questions[i].material), questions[i]);
            expect_relative(found[i].samples.ratio(), wanted.ratio(), 2e-5, "lobe " + std::to_string(i));
            expect_relative(found[i].samples.irradiance.x, c["E"], 5e-6, "irradiance");
            EXPECT_EQ(found[i].harmonics.total.x, 0) << "there are none";
        }
    }
}

// A point that coincides with what a sample saw: that sample is dropped, the others go on.
TEST_P(RadianceRecord, SurvivesContact) {
    LobeTables tables(device(), some_materials(), 0, 2);
    const real3 up{0, 0, 1};
    PlacedRecord record = room_record({.7, .8, 0}, up, 4, 8, generator);
    for (HemisphereSample& s : record.h.samples) s.radiance = {1, 2, 3};
    RadianceRecords records(device(), tables, {record});
    const HemisphereSample& seen = record.h.samples[5];
    std::vector<Question> questions;
    for (std::uint32_t i = 0; i < some_materials().size(); ++i)
        questions.push_back({i, static_cast<double>(tables.material(i).alpha_u),
                             record.p + to_world(record.h.frame, seen.distance * seen.direction), up,
                             to_real3(direction_at(.5, 1))});
    for (const auto& found : records.sums(questions, std::vector<std::uint32_t>(questions.size(), 0)))
        for (const real3& v : {found.samples.weighted, found.samples.total, found.samples.irradiance})
            EXPECT_TRUE(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z));
}

// A record a decimetre from a wall, asked two centimetres from it: solid angles grow by IR_NEAREST2 at most.
TEST_P(RadianceRecord, NearHitsCountUpToALimit) {
    LobeTables tables(device(), some_materials(), 0);
    const real3 up{0, 0, 1};
    const PlacedRecord record = room_record({.1, .8, 0}, up, 8, 24, generator);
    RadianceRecords records(device(), tables, {record});
    std::vector<Question> questions;
    for (std::uint32_t i = 0; i < some_materials().size(); ++i)
        questions.push_back(
            {i, static_cast<double>(tables.material(i).alpha_u), {.02, .8, 0}, up, to_real3(direction_at(.5, 1))});
    const auto found = records.sums(questions, std::vector<std::uint32_t>(questions.size(), 0));
    for (std::size_t i = 0; i < questions.size(); ++i) {
        const auto wanted = sums_in_double(record, tables.material(questions[i].material), questions[i]);
        expect_relative(found[i].samples.ratio(), wanted.ratio(), 2e-5, "lobe " + std::to_string(i));
    }
}

// ---- several records
// -------------------------------------------------------------------------------------------------

/// Weight of a round record at (p, n), as record_weight has it, with the settings of RadianceRecords; 0 beyond.
double weight_of(const PlacedRecord& r, const Question& q, double stretch) {
    const real3 ni = r.h.frame.n;
    if (r.coat != 0 || is_in_front(q.p, q.n, r.p, ni, .05, 5) || is_below(q.p, q.n, r.p, ni)) return 0;
    return ward_weight_normalised(stretch * (length(q.p - r.p) / r.support + 5 * normal_error(q.n, ni)));
}

// The look-up over the octree: the sums of all records, weighted, over one another, times the albedo.
TEST_P(RadianceRecord, LookUpsWeighRecords) {
    LobeTables tables(device(), some_materials(), 0);
    const real3 up{0, 0, 1};
    std::vector<PlacedRecord> placed{room_record({.7, .8, 0}, up, 8, 24, generator, .5),
                                     room_record({1, .9, 0}, up, 8, 24, generator, .8),
                                     room_record({.8, 1.2, 0}, normalize(make_real3(.1, 0, 1)), 8, 24, generator, .6),
                                     room_record({.8, .9, 0}, up, 8, 24, generator, .8)};
    placed[3].coat = 2;  // an irradiance record's
    RadianceRecords records(device(), tables, placed);
    records.parameters.full_reach = .25f;  // for harmonics: samples are used to their full support by all lobes
    std::vector<Question> questions;
    for (std::uint32_t i = 0; i < some_materials().size(); ++i)
        for (const auto& p : {make_real3(.8, .9, 0), make_real3(.75, 1, 0), make_real3(1.2, 1, 0), make_real3(3, 2, 0)})
            questions.push_back({i, static_cast<double>(tables.material(i).alpha_u), p,
                                 normalize(make_real3(.02, -.01, 1)), to_real3(direction_at(.6, 2))});
    const auto found = records.look_up(questions);
    std::size_t answers = 0;
    for (std::size_t i = 0; i < questions.size(); ++i) {
        const Question& q = questions[i];
        RadianceRecords::Sums sum{};
        double least = kMiss, weights = 0;
        for (const PlacedRecord& r : placed) {
            const double w = weight_of(r, q, 1);
            if (w == 0) continue;
            const auto one = sums_in_double(r, tables.material(q.material), q);
            sum.weighted += one.weighted * w;
            sum.total += one.total * w;
            weights += w;
            least = std::min(least, r.support);
        }
        ASSERT_TRUE(found[i].cached);
        EXPECT_EQ(found[i].found, weights > 0) << i;
        EXPECT_EQ(found[i].covered, weights > 0) << i;
        if (weights == 0) continue;
        ++answers;
        const auto albedo = tables.values(q.material, {{false, q.alpha, dot(q.n, q.view)}});
        const real3 ratio = sum.ratio();
        // Weights 1/x - 1 magnify the rounding of positions (6e-8 of .8, over supports of .5) by 1/x.
        expect_relative(found[i].radiance, {albedo[0] * ratio.x, albedo[1] * ratio.y, albedo[2] * ratio.z}, 3e-5,
                        "question " + std::to_string(i));
        expect_relative(found[i].least, least, 1e-6, "least support");
    }
    EXPECT_GT(answers, questions.size() / 2);
    EXPECT_LT(answers, questions.size());
}

/// A record that sees the same radiance everywhere, from the room's walls and from nowhere in turns.
PlacedRecord furnace_record(real3 p, real3 n, real3 radiance, double support = 1) {
    PlacedRecord r = room_record(p, n, 16, 32, generator, support);
    for (std::size_t i = 0; i < r.h.samples.size(); ++i) {
        r.h.samples[i].radiance = radiance;
        if (i % 5 == 0) r.h.samples[i].distance = kMiss;
    }
    return r;
}

// Constant radiance is reflected as albedo times itself, by both representations, wherever the records are asked.
TEST_P(RadianceRecord, IsExactInAFurnace) {
    LobeTables tables(device(), some_materials(), 5);
    const real3 radiance{.7, 1.4, 2.1}, up{0, 0, 1};
    RadianceRecords records(device(), tables,
                            {furnace_record({.7, .8, 0}, up, radiance), furnace_record({1, 1, 0}, up, radiance, .7),
                             furnace_record({.8, 1.2, .01}, normalize(make_real3(.1, .05, 1)), radiance)});
    for (const float from : {1e30f, 0.0f}) {  // samples, harmonics
        records.parameters.harmonics_from = from;
        std::vector<Question> questions;
        for (std::uint32_t i = 0; i < some_materials().size(); ++i)
            for (const auto& p : {make_real3(.7, .8, 0), make_real3(1.1, .9, 0), make_real3(.4, .8, 0)})
                for (const auto& n : {up, normalize(make_real3(.1, -.05, 1))})
                    for (const double c : {.99, .5, .15})
                        questions.push_back({i, static_cast<double>(tables.material(i).alpha_u), p, n,
                                             to_world(make_frame(n), to_real3(direction_at(c, 2)))});
        const auto found = records.look_up(questions);
        for (std::size_t i = 0; i < questions.size(); ++i) {
            const Question& q = questions[i];
            ASSERT_TRUE(found[i].found) << i;
            const auto albedo = tables.values(q.material, {{false, q.alpha, dot(q.n, q.view)}});
            expect_relative(found[i].radiance, {albedo[0] * radiance.x, albedo[1] * radiance.y, albedo[2] * radiance.z},
                            1e-5, (from == 0 ? "harmonics " : "samples ") + std::to_string(i));
            EXPECT_LE(found[i].spread, 1e-5) << "records of a furnace agree";
        }
    }
}

// ---- which records answer, and by what
// -------------------------------------------------------------------------------

// Harmonics that say twice of what the samples say tell which of them was asked: never both.
TEST_P(RadianceRecord, OneRepresentationAnswers) {
    const std::vector<shared::Material> materials{metal("none", .1), metal("none", .4), metal("none", .8)};
    const real3 up{0, 0, 1}, view = to_real3(direction_at(.7, 1));
    for (const std::uint32_t order : {0u, 3u}) {
        LobeTables tables(device(), materials, order);
        RadianceRecords records(device(), tables, {furnace_record({.7, .8, 0}, up, {1, 1, 1})});
        if (order > 0) records.brighten_harmonics(2);
        for (const float from : {0.0f, .3f, .4f, .5f, 1e30f}) {
            records.parameters.harmonics_from = from;
            std::vector<Question> questions;
            for (std::uint32_t i = 0; i < 3; ++i)
                questions.push_back({i, static_cast<double>(materials[i].alpha_u), {.7, .8, 0}, up, view});
            const auto found = records.look_up(questions);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const double albedo = tables.values(i, {{false, questions[i].alpha, view.z}})[0];
                const double wanted = order > 0 && materials[i].alpha_u >= from ? 2 : 1;
                expect_relative(found[i].radiance.x, wanted * albedo, 1e-5, "order " + std::to_string(order));
            }
        }
    }
}

TEST_P(RadianceRecord, ASpecimenOfEachKindIsTracedOrCached) {
    shared::Material brushed = metal("Cu", .3);
    brushed.alpha_v = .2f;
    const std::vector<shared::Material> materials{metal("Cu", .3),
                                                  coated(1.5, .3),
                                                  metal("Cu", .05),
                                                  brushed,
                                                  metal("Cu", .3),
                                                  of_kind(IR_MATERIAL_DIFFUSE),
                                                  dielectric(IR_MATERIAL_ROUGH_DIELECTRIC, 1.5, .3)};
    const std::vector<bool> wanted{true, true, false, false, false, false, false};
    LobeTables tables(device(), materials, 0);
    const real3 up{0, 0, 1};
    RadianceRecords records(device(), tables, {furnace_record({.7, .8, 0}, up, {1, 1, 1})});
    records.parameters.trace_below = .1f;
    records.forbid(4);
    std::vector<Question> questions;
    for (std::uint32_t i = 0; i < materials.size(); ++i)
        questions.push_back(
            {i, static_cast<double>(materials[i].alpha_u), {.7, .8, 0}, up, to_real3(direction_at(.7, 1))});
    const auto found = records.look_up(questions);
    for (std::size_t i = 0; i < materials.size(); ++i) EXPECT_EQ(found[i].cached, wanted[i]) << i;
}

// Records of a coat's irradiance, of another side, of steps above and below, and narrow lobes' far ones say nothing.
TEST_P(RadianceRecord, OthersDoNotApply) {
    const std::vector<shared::Material> materials{metal("none", .4), metal("none", .1)};
    LobeTables tables(device(), materials, 3);
    const real3 up{0, 0, 1}, view = to_real3(direction_at(.7, 1)), one{1, 1, 1};
    const auto answer = [&](PlacedRecord r, std::uint32_t material = 0, float harmonics_from = 1e30f) {
        RadianceRecords records(device(), tables, {std::move(r)});
        records.parameters.full_reach = .4f;
        records.parameters.harmonics_from = harmonics_from;
        const auto alpha = static_cast<double>(materials[material].alpha_u);
        return records.look_up({{material, alpha, {.7, .8, 0}, up, view}}).at(0);
    };
    EXPECT_TRUE(answer(furnace_record({.8, .8, 0}, up, one)).found);
    PlacedRecord coat = furnace_record({.8, .8, 0}, up, one);
    coat.coat = 1;
    EXPECT_FALSE(answer(coat).found);
    EXPECT_FALSE(answer(coat).covered);
    EXPECT_FALSE(answer(furnace_record({.8, .8, 0}, -up, one)).found) << "the other side";
    EXPECT_FALSE(answer(furnace_record({.8, .8, .3}, up, one)).found) << "a step above";
    EXPECT_FALSE(answer(furnace_record({.8, .8, -.3}, up, one)).found) << "a step below";
    EXPECT_TRUE(answer(furnace_record({1.3, .8, 0}, up, one)).found) << "wide lobes reach .6";
    EXPECT_TRUE(answer(furnace_record({1.3, .8, 0}, up, one), 1).found) << "and so do narrow ones, of samples";
    EXPECT_TRUE(answer(furnace_record({1.3, .8, 0}, up, one), 0, 0).found) << "of harmonics, wide ones";
    EXPECT_FALSE(answer(furnace_record({1.3, .8, 0}, up, one), 1, 0).found) << "roughness .4 / 4: half as far";
    EXPECT_TRUE(answer(furnace_record({1.1, .8, 0}, up, one), 1, 0).found);
}

// Two records at equal distance that say 1 and 3: their mean is 2, they differ from it by half of it.
TEST_P(RadianceRecord, SpreadIsTheMeanDeviation) {
    LobeTables tables(device(), {metal("none", .4), coated(1.5, .4)}, 3, 2);
    const real3 up{0, 0, 1}, view = to_real3(direction_at(.7, 1));
    RadianceRecords records(
        device(), tables,
        {furnace_record({.5, .8, 0}, up, {1, 1, 1}, .8), furnace_record({.9, .8, 0}, up, {3, 3, 3}, .8)});
    for (const float from : {1e30f, 0.0f}) {
        records.parameters.harmonics_from = from;
        for (const auto& found : records.look_up({{0, .4, {.7, .8, 0}, up, view}, {1, .4, {.7, .8, 0}, up, view}})) {
            expect_relative(found.spread, .5, 1e-5, "spread");
            expect_relative(found.least, .8, 1e-6, "least support");
        }
    }
}

}  // namespace
}  // namespace irradia::test
