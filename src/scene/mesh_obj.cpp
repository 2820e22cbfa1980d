// Wavefront OBJ: v (with colours, v x y z r g b), vt, vn, f; all groups of a file as one mesh, materials ignored (the
// scene file says what they are), everything else skipped.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>

#include "scene/build.h"

namespace irradia::loader {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

class ObjReader {
public:
    explicit ObjReader(const std::string& path)
        : path_(path), text_(read_file(path)), at_(text_.data()), end_(text_.data() + text_.size()) {}

    Mesh read(bool colours) {
        for (; at_ != end_; next_line()) {
            line_begin_ = at_;
            blanks();
            const char* word = at_;
            while (at_ != end_ && !is_blank(*at_) && *at_ != '\n') ++at_;
            const std::string_view keyword(word, static_cast<std::size_t>(at_ - word));
            if (keyword == "v")
                read_position(colours);
            else if (keyword == "vt")
                read_uv();
            else if (keyword == "vn")
                read_normal();
            else if (keyword == "f")
                read_face();
        }
        if (mesh_.triangles.empty() && !positions_.empty()) throw Error(fmt::format("mesh '{}' has no faces", path_));
        fill_vertices();
        return std::move(mesh_);
    }

private:
    struct Corner {  // a vertex of the mesh: indices from 0 on, kNone where there is none
        std::uint32_t v, t, n;
        std::uint32_t next;  // another one with the same v
    };

    std::string path_, text_;
    const char *at_, *end_, *line_begin_ = nullptr;
    std::size_t line_ = 1;
    std::vector<glm::dvec3> positions_, normals_;
    std::vector<glm::dvec2> uvs_;
    std::vector<glm::vec3> colours_;  // none, or as many as positions
    std::vector<Corner> corners_;
    std::vector<std::uint32_t> first_;  // of each v, into corners_
    Mesh mesh_;

    [[noreturn]] void bad_line(const char* what) const {
        const char* stop = std::find_if(line_begin_, end_, [](char c) { return c == '\n' || c == '\r'; });
        const auto shown = std::min<std::size_t>(static_cast<std::size_t>(stop - line_begin_), 60);
        throw Error(fmt::format("mesh '{}' line {}: '{}' {}", path_, line_, std::string(line_begin_, shown), what));
    }

    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
    /// Goes to the next word of the line; a backslash continues it on the next one.
    void blanks() {
        for (; at_ != end_; ++at_) {
            if (is_blank(*at_)) continue;
            if (*at_ != '\\') return;
            const char* after = at_ + 1;
            if (after != end_ && *after == '\r') ++after;
            if (after == end_ || *after != '\n') return;
            at_ = after;
            ++line_;
        }
    }
    /// Nothing but a comment follows.
    bool line_ends() {
        blanks();
        return at_ == end_ || *at_ == '\n' || *at_ == '#';
    }
    void next_line() {
        const void* newline = std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_));
        at_ = newline ? static_cast<const char*>(newline) + 1 : end_;
        ++line_;
    }

    double number() {
        if (line_ends()) bad_line("ends too early, more numbers were expected");
        if (*at_ == '+') ++at_;
        double value = 0.0;
        const auto [stop, error] = std::from_chars(at_, end_, value);
        if (error == std::errc::result_out_of_range) value = std::strtod(std::string(at_, stop).c_str(), nullptr);
        if (error == std::errc::invalid_argument || !std::isfinite(value) ||
            (stop != end_ && !is_blank(*stop) && *stop != '\n' && *stop != '#' && *stop != '\\'))
            bad_line("has something that is not a finite number");
        at_ = stop;
        return value;
    }

    void read_position(bool colours) {
        double x[7] = {};
        std::size_t count = 0;
        while (count < 7 && (count < 3 || !line_ends())) x[count++] = number();
        if (positions_.size() == kNone) bad_line("is a vertex more than 32-bit indices can count");
        positions_.emplace_back(x[0], x[1], x[2]);
        if (!colours) return;
        if (count == 6 && colours_.empty()) colours_.resize(positions_.size() - 1, glm::vec3(1.0f));
        if (count == 6)
            colours_.emplace_back(x[3], x[4], x[5]);
        else if (!colours_.empty())
            colours_.emplace_back(1.0f);
    }
    void read_uv() {
        const double u = number();
        uvs_.emplace_back(u, line_ends() ? 0.0 : number());
    }
    void read_normal() {
        const double x = number(), y = number();
        normals_.emplace_back(x, y, number());
    }

    /// "7" or "-1", counted from the first or back from the last of `count`; from 0 on. At most as many as the file has
    /// room for are believed: indices size a table.
    std::uint32_t index(std::size_t count) {
        long long i = 0;
        const auto [stop, error] = std::from_chars(at_, end_, i);
        if (error != std::errc() || i == 0) bad_line("has something that is not an index");
        at_ = stop;
        if (i < 0) i += static_cast<long long>(count) + 1;
        if (i < 1) bad_line("counts back beyond the first one");
        if (static_cast<unsigned long long>(i) > text_.size())
            throw Error(fmt::format("mesh '{}': a face refers to vertex {}, there are {} v, {} vt, {} vn", path_, i,
                                    positions_.size(), uvs_.size(), normals_.size()));
        return static_cast<std::uint32_t>(i - 1);
    }

    /// The mesh's vertex for a corner "v", "v/t", "v//n" or "v/t/n".
    std::uint32_t corner() {
        Corner c{index(positions_.size()), kNone, kNone, kNone};
        const auto number_follows = [&] { return at_ != end_ && (*at_ == '-' || (*at_ >= '0' && *at_ <= '9')); };
        if (at_ != end_ && *at_ == '/') {
            ++at_;
            if (number_follows()) c.t = index(uvs_.size());
            if (at_ != end_ && *at_ == '/') {
                ++at_;
                if (number_follows()) c.n = index(normals_.size());
            }
        }
        if (at_ != end_ && !is_blank(*at_) && *at_ != '\n' && *at_ != '#' && *at_ != '\\')
            bad_line("has something that is not a corner v, v/t, v//n or v/t/n");
        if (c.v >= first_.size()) first_.resize(std::max<std::size_t>(std::size_t{c.v} + 1, positions_.size()), kNone);
        std::uint32_t* link = &first_[c.v];
        while (*link != kNone) {
            Corner& known = corners_[*link];
            if (known.t == c.t && known.n == c.n) return *link;
            link = &known.next;
        }
        const auto vertex = static_cast<std::uint32_t>(corners_.size());
        *link = vertex;
        corners_.push_back(c);
        return vertex;
    }

    void read_face() {  // polygons are cut into fans, as Mitsuba does
        std::uint32_t a = kNone, b = kNone;
        for (std::size_t k = 0; !line_ends(); ++k) {
            const std::uint32_t c = corner();
            if (k == 0) a = c;
            if (k >= 2) mesh_.triangles.push_back({a, b, c});
            b = c;
        }
    }

    void fill_vertices() {
        bool any_normal = false, any_uv = false;
        for (const Corner& c : corners_) {
            if (c.v >= positions_.size() || (c.t != kNone && c.t >= uvs_.size()) ||
                (c.n != kNone && c.n >= normals_.size()))
                throw Error(fmt::format("mesh '{}': a face refers to {} {}, there are {} v, {} vt, {} vn", path_,
                                        c.v >= positions_.size()             ? "vertex"
                                        : c.t != kNone && c.t >= uvs_.size() ? "texture coordinate"
                                                                             : "normal",
                                        (c.v >= positions_.size()             ? c.v
                                         : c.t != kNone && c.t >= uvs_.size() ? c.t
                                                                              : c.n) +
                                            1ull,
                                        positions_.size(), uvs_.size(), normals_.size()));
            any_normal = any_normal || c.n != kNone;
            any_uv = any_uv || c.t != kNone;
        }
        const std::size_t count = corners_.size();
        mesh_.positions.resize(count);
        if (any_normal) mesh_.normals.resize(count, glm::dvec3(0.0));
        if (any_uv) mesh_.uvs.resize(count, glm::dvec2(0.0));
        if (!colours_.empty()) mesh_.colours.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const Corner& c = corners_[i];
            mesh_.positions[i] = positions_[c.v];
            if (c.n != kNone) mesh_.normals[i] = normals_[c.n];
            if (c.t != kNone) mesh_.uvs[i] = uvs_[c.t];
            if (!colours_.empty()) mesh_.colours[i] = colours_[c.v];
        }
    }
};

}  // namespace

Mesh read_obj(const std::string& path, bool colours) { return ObjReader(path).read(colours); }

}  // namespace irradia::loader
