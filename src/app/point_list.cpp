#include "app/point_list.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "app/output.h"
#include "irradia/Error.h"

namespace irradia::app {
namespace {

constexpr const char* kSeparators = ", \t\r;";

/// The words of a line.
std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> words;
    for (std::size_t at = line.find_first_not_of(kSeparators); at != std::string::npos;) {
        const std::size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
        words.push_back(line.substr(at, end - at));
        at = line.find_first_not_of(kSeparators, end);
    }
    return words;
}

bool read_number(const std::string& word, double& value) {
    const char* const begin = word.data() + (word[0] == '+' ? 1 : 0);
    const auto read = std::from_chars(begin, word.data() + word.size(), value);
    return read.ec == std::errc() && read.ptr == word.data() + word.size() && std::isfinite(value);
}

bool is_header(const std::vector<std::string>& words) {
    double unused = 0;
    return std::none_of(words.begin(), words.end(),
                        [&](const std::string& word) { return read_number(word, unused); }) &&
           std::all_of(words.begin(), words.end(),
                       [](const std::string& word) { return std::isalpha(static_cast<unsigned char>(word[0])); });
}

template <class T>
std::string text(T value) {
    char out[64];
    const auto end = std::to_chars(out, out + sizeof out, value);  // the shortest that reads back as the same
    return {out, end.ptr};
}

}  // namespace

std::vector<IrradiancePoint> read_points(const std::string& path) {
    std::ifstream in(path);
    if (!in) throw Error(path + ": cannot be read");
    std::vector<IrradiancePoint> points;
    std::string line;
    bool first = true;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        const std::string where = path + ":" + std::to_string(number) + ": ";
        const std::vector<std::string> words = split(line);
        if (words.empty() || words[0][0] == '#') continue;
        const bool header = first && is_header(words);
        first = false;
        if (header) continue;
        if (words.size() != 6)
            throw Error(where + std::to_string(words.size()) + " values, expected 6: x,y,z,nx,ny,nz");
        double v[6] = {};
        for (std::size_t k = 0; k < 6; ++k)
            if (!read_number(words[k], v[k]))
                throw Error(where + "'" + words[k].substr(0, 40) + "', expected a finite number");
        const double length = std::hypot(v[3], v[4], v[5]);
        if (!(length > 1e-30) || !std::isfinite(length))
            throw Error(where + "a normal of length zero, expected a direction");
        if (std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}) > 1e15)
            throw Error(where + "a position out of reach, expected coordinates below 1e15");
        points.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
    }
    if (in.bad()) throw Error(path + ": cannot be read to its end");
    if (points.empty()) throw Error(path + ": no points, expected lines x,y,z,nx,ny,nz");
    return points;
}

void write_points(const std::string& path, const std::vector<IrradiancePoint>& points,
                  const std::vector<PointIrradiance>& answers) {
    std::string out = "x,y,z,nx,ny,nz,E_r,E_g,E_b,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (const double x : points[i].position) out += text(x) + ",";
        for (const double x : points[i].normal) out += text(x) + ",";
        const PointIrradiance& e = answers[i];
        for (std::size_t k = 0; k < 3; ++k) out += text(e.direct[k] + e.indirect[k]) + ",";
        for (const float x : e.direct) out += text(x) + ",";
        for (std::size_t k = 0; k < 3; ++k) out += text(e.indirect[k]) + (k < 2 ? "," : "\n");
    }
    save_text(path, out);
}

}  // namespace irradia::app
