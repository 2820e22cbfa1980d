// What SceneParts holds, and how the loader's readers get at it.
#pragma once
#include <compare>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "scene/build.h"

namespace irradia {
namespace loader {

/// A file as it was before it was read; equal ones have the same bytes.
struct FileStamp {
    std::uint64_t device = 0, inode = 0, size = 0;
    std::int64_t modified[2] = {}, changed[2] = {};  // seconds and nanoseconds; changed: the inode
    bool operator==(const FileStamp&) const = default;
};
/// No value: there is no such file, or it has been written so lately that another write may leave the times as they
/// are.
std::optional<FileStamp> stamp_of(const std::string& path);

/// A file by its canonical path, and in which way it is read.
struct PartKey {
    std::string path, how;
    auto operator<=>(const PartKey&) const = default;
};
PartKey part_key(const std::string& path, const std::string& how);

template <class T>
struct Part {
    FileStamp stamp;
    std::shared_ptr<const T> value;
    std::uint64_t used = 0;  // number of the last load that did
};
struct CoatPart {
    RoughCoat coat;
    std::uint64_t used = 0;
};
template <class T>
using Parts = std::map<PartKey, Part<T>>;

}  // namespace loader

struct SceneParts::Impl {
    mutable std::mutex mutex;  // of all below; not held while a file is read
    loader::Parts<loader::Mesh> meshes;
    loader::Parts<loader::Picture> pictures;
    loader::Parts<loader::EnvironmentMap> environments;
    std::map<std::tuple<double, double, bool>, loader::CoatPart> coats;  // of no file, but slow to compute
    std::uint64_t load = 0, last_good = 0;                               // numbers of loads
    std::size_t files_read = 0;

    /// What read() makes of a file, or made of it before. Two threads that ask for the same one may both read it.
    template <class T, class F>
    std::shared_ptr<const T> get(loader::Parts<T>& parts, const loader::PartKey& key, const F& read) {
        const std::optional<loader::FileStamp> stamp = loader::stamp_of(key.path);  // before its bytes are read
        {
            const std::lock_guard lock(mutex);
            if (const auto found = parts.find(key); found != parts.end()) {
                if (stamp && found->second.stamp == *stamp) {
                    found->second.used = load;
                    return found->second.value;
                }
                parts.erase(found);  // now: not two versions in memory
            }
            ++files_read;
        }
        auto value = std::make_shared<const T>(read());
        if (stamp) {
            const std::lock_guard lock(mutex);
            parts[key] = {*stamp, value, load};
        }
        return value;
    }
};

namespace loader {

/// read()'s result, or, if `parts` is given, what that has.
template <class T, class F>
std::shared_ptr<const T> from_parts(SceneParts* parts, Parts<T> SceneParts::Impl::*store, const std::string& path,
                                    const std::string& how, const F& read) {
    if (!parts) return std::make_shared<const T>(read());
    return parts->impl().get(parts->impl().*store, part_key(path, how), read);
}

/// rough_coat(), computed once for all loads.
RoughCoat coat_from_parts(SceneParts* parts, double eta, double alpha, bool beckmann);

/// A load's use of parts (null: none): at its end what nobody will ask for is dropped.
class PartsInUse {
public:
    explicit PartsInUse(SceneParts* parts);
    ~PartsInUse();
    PartsInUse(const PartsInUse&) = delete;
    PartsInUse& operator=(const PartsInUse&) = delete;
    void loaded() { loaded_ = true; }

private:
    SceneParts* parts_;
    bool loaded_ = false;
};

/// The mesh files of a scene. With parts each is read once, whatever the number of shapes that show it; without, each
/// shape reads its own when it is asked for, so that no second copy is in memory.
class MeshFiles {
public:
    explicit MeshFiles(SceneParts* parts) : parts_(parts) {}
    void add(const MeshFile& file, bool colours);
    /// Drops the meshes of other scenes and reads what was added and is missing, in parallel.
    void read();
    /// A copy of a mesh that was added. Throws Error "mesh ...", as reading it does.
    [[nodiscard]] Mesh mesh(const MeshFile& file, bool colours) const;

private:
    struct Wanted {
        MeshFile file;
        bool colours = false;
        std::shared_ptr<const Mesh> mesh;
        std::exception_ptr error;
    };
    using Key = std::tuple<std::string, std::string, long long, bool>;
    static Key key_of(const MeshFile& file, bool colours) { return {file.path, file.type, file.index, colours}; }

    SceneParts* parts_;
    std::map<Key, PartKey> keys_;  // canonical paths, found out once
    std::map<PartKey, Wanted> wanted_;
};

}  // namespace loader
}  // namespace irradia
