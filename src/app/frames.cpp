#include "app/frames.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>

namespace irradia::app {
namespace {

constexpr int most_frames = 1'000'000;

bool number(const char*& at, const char* end, int& value) {
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc() || read.ptr == at || value < 0) return false;
    at = read.ptr;
    return true;
}

// The run of '#' in a file's name: first and past the last; both npos if there is none, or more than one.
std::pair<std::size_t, std::size_t> place(const std::string& path) {
    const std::string name = std::filesystem::path(path).filename().string();
    const std::size_t offset = path.size() - name.size(), first = name.find('#');
    if (first == std::string::npos) return {std::string::npos, std::string::npos};
    std::size_t last = name.find_first_not_of('#', first);
    if (last == std::string::npos) last = name.size();
    if (name.find('#', last) != std::string::npos) return {std::string::npos, std::string::npos};
    return {offset + first, offset + last};
}

}  // namespace

std::string read_frames(const std::string& given, std::vector<int>& frames) {
    const std::string wrong = "'" + given + "' is not a list of frames, for example 1-240, 1-240x4 or 1-9,20";
    frames.clear();
    const char *at = given.data(), *const end = at + given.size();
    for (;;) {
        int first = 0, last = 0, step = 1;
        if (!number(at, end, first)) return wrong;
        last = first;
        if (at != end && *at == '-') {
            ++at;
            if (!number(at, end, last) || last < first) return wrong;
            if (at != end && *at == 'x') {
                ++at;
                if (!number(at, end, step) || step < 1) return wrong;
            }
        }
        if (last > most_frames) return "'" + given + "': frames end at " + std::to_string(most_frames);
        for (std::int64_t f = first; f <= last; f += step) frames.push_back(static_cast<int>(f));
        if (at == end) break;
        if (*at++ != ',') return wrong;
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return "";
}

std::string read_shard(const std::string& given, int& shard, int& shards) {
    const char *at = given.data(), *const end = at + given.size();
    const bool good = number(at, end, shard) && at != end && *at++ == '/' && number(at, end, shards) && at == end &&
                      shard >= 1 && shard <= shards;
    return good ? "" : "'" + given + "' is not I/N with I from 1 to N, for example 2/8";
}

std::vector<int> shard_of(const std::vector<int>& frames, int shard, int shards) {
    const auto bound = [&](int i) {
        return static_cast<std::ptrdiff_t>(frames.size() * static_cast<std::size_t>(i) /
                                           static_cast<std::size_t>(shards));
    };
    return {frames.begin() + bound(shard - 1), frames.begin() + bound(shard)};
}

bool has_frame_place(const std::string& path) { return place(path).first != std::string::npos; }

std::string frame_path(const std::string& path, int frame) {
    const auto [first, last] = place(path);
    if (first == std::string::npos) return path;
    std::string digits = std::to_string(frame);
    if (digits.size() < last - first) digits.insert(0, last - first - digits.size(), '0');
    return path.substr(0, first) + digits + path.substr(last);
}

std::string frames_text(const std::vector<int>& frames) {
    std::string out;
    for (std::size_t i = 0; i < frames.size();) {
        std::size_t j = i;
        while (j + 1 < frames.size() && frames[j + 1] == frames[j] + 1) ++j;
        out += (out.empty() ? "" : ", ") + std::to_string(frames[i]);
        if (j > i) out += (j == i + 1 ? ", " : "-") + std::to_string(frames[j]);
        i = j + 1;
    }
    return out;
}

}  // namespace irradia::app
