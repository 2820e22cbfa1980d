#include "app/output.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <vector>

#include "core/aside_file.h"
#include "irradia/Error.h"
#ifdef IRRADIA_MINIMAL
#include "core/pfm.h"
#else
#include "pictures/exr.h"
#include "pictures/oiio.h"
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
#ifndef IRRADIA_MINIMAL
    // Loaded now rather than later: it may be missing.
    if (extension == ".exr") exr::library();
    if (extension == ".png") oiio::library();
#endif
    check_writable(path);
}

void check_writable(const std::string& path) {
    const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : fs::path(".");
    std::error_code ignored;
    if (!fs::is_directory(folder, ignored))
        throw Error(path + ": cannot be written: there is no folder " + folder.string());
    AsideFile trial(path);  // never committed: it vanishes
}

void save_picture(const std::string& path, const Image& image, double exposure, int threads) {
#ifdef IRRADIA_MINIMAL
    (void)exposure, (void)threads;
    write_pfm(path, image);
#else
    write_image(path, image, exposure, threads);
#endif
}

void save_text(const std::string& path, const std::string& text) {
    AsideFile out(path);
    out.write(text.data(), text.size());
    out.commit();
}

}  // namespace irradia::app
