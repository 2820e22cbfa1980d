// Records that outlive a run: the caches' records as plain arrays, and the file that --save-records writes and
// --load-records reads. The bytes are described in docs/record-format.md. Needs nothing but the standard library and
// irradia_records (Irradia::irradia_records of the installed package).
//
//     irradia::RecordSet set = irradia::read_records("scene.records");
//     for (std::size_t i = 0; i < set.irradiance.size(); ++i) use(set.irradiance.keys[i], set.irradiance.values[i]);
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "irradia/Scene.h"
#include "irradia/shared/radiance_types.h"
#include "irradia/shared/record_types.h"

namespace irradia {

/// What records were made for. Two files with equal origins hold records of one cache.
struct RecordOrigin {
    std::uint64_t geometry = 0;   ///< hash of vertices, triangles, spheres, disks and cylinders, and of `centre`
    std::uint64_t materials = 0;  ///< hash of materials, textures and texels
    std::uint64_t emitters = 0;   ///< hash of the lights
    /// Add this to a record's position for its position in the scene file's world, world units.
    std::array<double, 3> centre{};
    /// Bounds of all surfaces, less `centre`, world units. Positions of records lie within them, but for rounding.
    std::array<float, 3> lower{}, upper{};
    /// Settings that change what a record means, by the names of their options: {"accuracy", "0.2"}, ...
    std::vector<std::pair<std::string, std::string>> settings;

    bool operator==(const RecordOrigin&) const = default;
};

/// Keys and values of records, one of each a record, in the order in which they were made.
struct Records {
    std::vector<shared::RecordKey> keys;      ///< where, and how far it is used: position, normal, support (world units)
    std::vector<shared::RecordValue> values;  ///< irradiance E (W·m⁻²) and its gradients: by angle, by world unit
    [[nodiscard]] std::size_t size() const noexcept { return keys.size(); }
};

/// Radiance records: their keys and values (E of all that arrives), and what they hold besides: see radiance_types.h.
struct RadianceRecords : Records {
    std::uint32_t stride = 0;  ///< directions of a record, rounded up to a multiple of 8; 0: records hold no samples
    std::uint32_t order = 0;   ///< bands of the hemispherical harmonics, at most 12; 0: records hold none
    std::vector<float> samples;    ///< IR_SAMPLE_FLOATS * stride floats a record
    std::vector<float> harmonics;  ///< IR_HARMONIC_SETS * order² floats a record
    [[nodiscard]] std::size_t sample_floats() const noexcept { return std::size_t{IR_SAMPLE_FLOATS} * stride; }
    [[nodiscard]] std::size_t harmonic_floats() const noexcept { return std::size_t{IR_HARMONIC_SETS} * order * order; }
};

/// A picture whose records are all there: rendered again, it gets none but where a sample finds none.
struct RecordView {
    static constexpr std::uint32_t irradiance = 1, radiance = 2;
    shared::Camera camera{};              ///< after centring, as SceneInfo has it
    std::uint32_t width = 0, height = 0;  ///< pixels
    std::uint32_t kinds = 0;              ///< of records: irradiance, or irradiance | radiance
    std::uint32_t pad = 0;
};

/// All that a record file holds.
struct RecordSet {
    RecordOrigin origin;
    Records irradiance;        ///< of diffuse surfaces: indirect light alone, what passes a coat (RecordKey::coat)
    RadianceRecords radiance;  ///< of rough glossy surfaces
    std::vector<RecordView> views;
};

/// Reads a record file of this machine's byte order. What a file holds up to the end of any block is a state of the
/// cache: where a block is cut off or damaged, those before it are returned, and `*warning` (one line; "" if nothing is
/// wrong) says what was lost; without `warning`, that is an Error. Throws Error, one line that names the file:
/// unreadable, no record file, of another version or byte order, a damaged header, or records that check_records()
/// refuses. Never allocates out of proportion to the file's size.
RecordSet read_records(const std::string& path, std::string* warning = nullptr);

/// Writes a record file beside `path`, synchronises it, renames it: a failed write leaves nothing behind. Throws Error:
/// unwritable, or records that check_records() refuses.
void write_records(const std::string& path, const RecordSet& set);

/// Adds to a file what `now` holds beyond `written`, which is what the file holds: records and views at the end of its
/// arrays, and supports that are smaller now (samples and harmonics of `written` are not read). What the file has is not
/// touched: an append that is cut off costs itself alone. Throws Error as write_records() does, and if the file does not
/// hold as much as `written`, or is damaged.
void append_records(const std::string& path, const RecordSet& written, const RecordSet& now);

/// Throws Error "<where>: ..." unless every number of every record is finite and within its bounds: positions within the
/// scene's, unit normals, positive supports (the second not the smaller one), E and radiance not negative. Look-ups rely
/// on it.
void check_records(const std::string& where, const RecordSet& set);

struct RenderSettings;

/// The origin of records that a render of `scene` with `settings` makes. Camera, film, samples a pixel, seed and device
/// are no part of it.
RecordOrigin record_origin(const Scene& scene, const RenderSettings& settings);

/// What differs between the origin of a file's records and that of a render: "" if nothing that matters, otherwise a
/// list like "other geometry; --accuracy is 0.4 there, 0.2 here". `radiance`: are radiance records to be used?
std::string record_mismatch(const RecordOrigin& file, const RecordOrigin& render, bool radiance);

/// Makes the settings of radiance records in `to` those of `from`: of a file whose radiance records a render left alone.
void keep_radiance_settings(const RecordOrigin& from, RecordOrigin& to);

}  // namespace irradia
