// A scene made by hand that uses every array, and a folder to write it to.
#pragma once
#include <filesystem>
#include <string>

#include "irradia/Error.h"
#include "irradia/Scene.h"

namespace irradia::test {

/// Two triangles and a sphere, three textures, five kinds of light, trees of two levels.
Scene small_scene();

/// A new folder under the system's temporary one, removed with its files at the end.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    [[nodiscard]] std::string file(const std::string& name) const { return (path / name).string(); }
    [[nodiscard]] std::size_t count() const;
    std::filesystem::path path;
};

std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& bytes);

/// The message of the Error that `f` throws; "" if it throws none.
template <class F>
std::string error_of(F&& f) {
    try {
        f();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

inline bool one_line(const std::string& s) { return !s.empty() && s.find('\n') == std::string::npos; }
inline bool has(const std::string& s, const std::string& part) { return s.find(part) != std::string::npos; }

}  // namespace irradia::test
