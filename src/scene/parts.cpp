#include "scene/parts.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <ctime>
#include <filesystem>

namespace irradia {
namespace loader {
namespace {

std::size_t bytes_of(const Mesh& m) {
    return m.positions.capacity() * sizeof m.positions[0] + m.normals.capacity() * sizeof m.normals[0] +
           m.uvs.capacity() * sizeof m.uvs[0] + m.colours.capacity() * sizeof m.colours[0] +
           m.triangles.capacity() * sizeof m.triangles[0];
}
std::size_t bytes_of(const Picture& p) { return p.bytes.capacity() + p.floats.capacity() * sizeof(float); }
std::size_t bytes_of(const EnvironmentMap& m) {
    return m.texels.capacity() * sizeof(float) + m.tables.capacity() * sizeof(std::uint32_t);
}

/// Clocks of file systems tick in steps: a file that was written within the step in which it was read may be written
/// again and bear the same time. Those that count seconds only (no nanoseconds) have steps of up to two.
bool settled(const timespec& time, const timespec& now) {
    const double age =
        static_cast<double>(now.tv_sec - time.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - time.tv_nsec);
    return age > (time.tv_nsec == 0 ? 2.5 : 0.1);
}

}  // namespace

std::optional<FileStamp> stamp_of(const std::string& path) {
    struct stat s {};
    timespec now{};
    if (::clock_gettime(CLOCK_REALTIME, &now) != 0 || ::stat(path.c_str(), &s) != 0 || !S_ISREG(s.st_mode)) return {};
    if (!settled(s.st_mtim, now) || !settled(s.st_ctim, now)) return {};
    return FileStamp{static_cast<std::uint64_t>(s.st_dev),
                     static_cast<std::uint64_t>(s.st_ino),
                     static_cast<std::uint64_t>(s.st_size),
                     {s.st_mtim.tv_sec, s.st_mtim.tv_nsec},
                     {s.st_ctim.tv_sec, s.st_ctim.tv_nsec}};
}

PartKey part_key(const std::string& path, const std::string& how) {
    std::error_code error;
    const std::filesystem::path canonical = std::filesystem::canonical(path, error);
    return {error ? path : canonical.string(), how};  // no such file: its reader says so
}

RoughCoat coat_from_parts(SceneParts* parts, double eta, double alpha, bool beckmann) {
    if (!parts) return rough_coat(eta, alpha, beckmann);
    SceneParts::Impl& impl = parts->impl();
    const std::lock_guard lock(impl.mutex);
    const auto [place, added] = impl.coats.try_emplace({eta, alpha, beckmann});
    if (added) place->second.coat = rough_coat(eta, alpha, beckmann);
    place->second.used = impl.load;
    return place->second.coat;
}

PartsInUse::PartsInUse(SceneParts* parts) : parts_(parts) {
    if (parts_) ++parts_->impl().load;
}

PartsInUse::~PartsInUse() {
    if (!parts_) return;
    SceneParts::Impl& impl = parts_->impl();
    const std::lock_guard lock(impl.mutex);
    const auto drop = [&](auto& parts) {
        std::erase_if(parts, [&](const auto& part) {
            const std::uint64_t used = part.second.used;
            return used != impl.load && (loaded_ || used != impl.last_good);
        });
    };
    drop(impl.meshes);
    drop(impl.pictures);
    drop(impl.environments);
    drop(impl.coats);
    if (loaded_) impl.last_good = impl.load;
}

void MeshFiles::add(const MeshFile& file, bool colours) {
    if (!parts_) return;
    const auto [place, added] = keys_.try_emplace(key_of(file, colours));
    if (!added) return;
    place->second = part_key(file.path, fmt::format("{} {}{}", file.type, file.index, colours ? " colours" : ""));
    wanted_.try_emplace(place->second, Wanted{file, colours, nullptr, nullptr});
}

void MeshFiles::read() {
    if (!parts_) return;
    SceneParts::Impl& impl = parts_->impl();
    {
        const std::lock_guard lock(impl.mutex);
        std::erase_if(impl.meshes, [&](const auto& part) { return !wanted_.contains(part.first); });
    }
    std::vector<std::pair<const PartKey, Wanted>*> list;
    for (auto& wanted : wanted_) list.push_back(&wanted);
    tbb::parallel_for(std::size_t{0}, list.size(), [&](std::size_t i) {
        auto& [key, wanted] = *list[i];
        try {
            wanted.mesh = impl.get(impl.meshes, key, [&file = wanted.file, &colours = wanted.colours] {
                Mesh mesh = read_mesh(file, colours);
                mesh.triangles.shrink_to_fit();  // readers append to it
                return mesh;
            });
        } catch (...) {
            wanted.error = std::current_exception();
        }
    });
}

Mesh MeshFiles::mesh(const MeshFile& file, bool colours) const {
    if (!parts_) return read_mesh(file, colours);
    const Wanted& wanted = wanted_.at(keys_.at(key_of(file, colours)));
    if (wanted.error) std::rethrow_exception(wanted.error);
    return *wanted.mesh;
}

}  // namespace loader

SceneParts::SceneParts() : impl_(std::make_unique<Impl>()) {}
SceneParts::~SceneParts() = default;

std::size_t SceneParts::files_read() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->files_read;
}

std::size_t SceneParts::files_kept() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->meshes.size() + impl_->pictures.size() + impl_->environments.size();
}

std::size_t SceneParts::bytes() const {
    const std::lock_guard lock(impl_->mutex);
    std::size_t sum = 0;
    for (const auto& [key, part] : impl_->meshes) sum += loader::bytes_of(*part.value);
    for (const auto& [key, part] : impl_->pictures) sum += loader::bytes_of(*part.value);
    for (const auto& [key, part] : impl_->environments) sum += loader::bytes_of(*part.value);
    return sum;
}

}  // namespace irradia
