#include "app/output.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "irradia/Error.h"
#ifdef IRRADIA_MINIMAL
#include "core/pfm.h"
#endif

namespace irradia::app {
namespace fs = std::filesystem;
namespace {

const std::vector<std::string>& kinds() {
#ifdef IRRADIA_MINIMAL
    static const std::vector<std::string> kinds = {".pfm"};
#else
    static const std::vector<std::string> kinds = {".exr", ".png", ".pfm"};
#endif
    return kinds;
}

std::string beside(const std::string& path) {
    const fs::path target(path);
    return (target.parent_path() / ("." + target.filename().string() + "." + std::to_string(::getpid()) + ".part"))
        .string();
}

}  // namespace

std::string output_kinds() {
    std::string out;
    for (const std::string& kind : kinds()) out += (out.empty() ? "" : ", ") + kind;
    return out;
}

void check_picture_path(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (std::find(kinds().begin(), kinds().end(), extension) == kinds().end())
        throw Error(path + ": unknown kind of picture '" + extension + "', expected " + output_kinds());
    check_writable(path);
}

void check_writable(const std::string& path) {
    const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored))
        throw Error(path + ": cannot be written: there is no folder " + folder.string());
    if (fs::is_directory(path, ignored)) throw Error(path + ": cannot be written: it is a folder");
    const std::string trial = beside(path);
    errno = 0;
    const bool made = static_cast<bool>(std::ofstream(trial));
    const std::string why = std::strerror(errno);
    fs::remove(trial, ignored);
    if (!made) throw Error(path + ": cannot be written: " + why);
}

void save_picture(const std::string& path, const Image& image, double exposure) {
#ifdef IRRADIA_MINIMAL
    (void)exposure;
    write_pfm(path, image);
#else
    write_image(path, image, exposure);
#endif
}

void save_text(const std::string& path, const std::string& text) {
    const std::string aside = beside(path);
    std::ofstream out(aside);
    out << text;
    out.close();
    std::error_code failed;
    if (out) fs::rename(aside, path, failed);
    if (!out || failed) {
        const std::string why = failed ? failed.message() : std::strerror(errno);
        std::error_code ignored;
        fs::remove(aside, ignored);
        throw Error(path + ": cannot be written: " + why);
    }
}

}  // namespace irradia::app
