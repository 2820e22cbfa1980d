#include "device/kernel_source.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

#include "irradia/Error.h"

namespace irradia::device {
namespace {

bool read_text(const std::string& path, std::string& text) {
    std::ifstream in(path, std::ios::binary);
    if (!in) return false;
    std::ostringstream all;
    all << in.rdbuf();
    if (!in) return false;
    text = all.str();
    return true;
}

/// The word and the rest of a preprocessor line: "  # include  "x.h"" -> ("include", ""x.h""). Not one: ("", "").
std::pair<std::string_view, std::string_view> directive(std::string_view line) {
    const auto skip_blanks = [&] {
        while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    };
    skip_blanks();
    if (line.empty() || line.front() != '#') return {};
    line.remove_prefix(1);
    skip_blanks();
    std::size_t end = 0;
    while (end < line.size() && line[end] >= 'a' && line[end] <= 'z') ++end;
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    skip_blanks();
    return {word, line};
}

std::string_view first_word(std::string_view rest) { return rest.substr(0, rest.find_first_of(" \t\r")); }

class Expander {
public:
    explicit Expander(std::string memory) : out_(std::move(memory)) { out_.clear(); }
    std::string run(const std::string& file, const std::string& text) {
        expand(file, text);
        return std::move(out_);
    }

private:
    std::string out_;
    std::vector<std::string> seen_;   // headers certain to have been compiled when the current line is
    std::vector<std::string> stack_;  // files being expanded, outermost first

    void line_marker(std::size_t line, const std::string& file) {
        out_ += "#line " + std::to_string(line) + " \"" + file + "\"\n";
    }

    void expand(const std::string& file, const std::string& text) {
        stack_.push_back(file);
        line_marker(1, file);
        struct Condition {
            bool guard;          // the file's include guard: all of the file is inside, so it is no condition
            std::size_t before;  // of seen_
        };
        std::vector<Condition> conditions;
        std::size_t line_number = 0, copied = 0;
        bool first_directive = true;
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t begin = at;
            std::size_t end = text.find('\n', at);
            if (end == text.npos) end = text.size();
            const std::string_view line(text.data() + at, end - at);
            ++line_number;
            at = end + 1;
            const auto [word, rest] = directive(line);
            if (word.empty()) continue;
            if (word == "if" || word == "ifdef" || word == "ifndef") {
                const bool guard = word == "ifndef" && first_directive && conditions.empty() &&
                                   defines_next(text, at, first_word(rest));
                conditions.push_back({guard, seen_.size()});
            } else if (word == "else" || word == "elif") {
                if (!conditions.empty() && !conditions.back().guard) seen_.resize(conditions.back().before);
            } else if (word == "endif") {
                if (!conditions.empty()) {
                    if (!conditions.back().guard) seen_.resize(conditions.back().before);
                    conditions.pop_back();
                }
            }
            first_directive = false;
            const std::size_t close = rest.find('"', 1);
            if (word == "include" && rest.starts_with('"') && close != rest.npos) {
                out_.append(text, copied, begin - copied);
                include(std::string(rest.substr(1, close - 1)));
                line_marker(line_number + 1, file);
                copied = std::min(at, text.size());
            }
        }
        out_.append(text, copied);
        if (!text.empty() && text.back() != '\n') out_ += '\n';
        stack_.pop_back();
    }

    void include(const std::string& name) {
        for (const std::string& open : stack_)
            if (open == name) return;  // a ring; the guard would make it empty
        if (std::find(seen_.begin(), seen_.end(), name) != seen_.end()) return;
        seen_.push_back(name);
        std::string text;
        if (find_source(name, text))
            expand(name, text);
        else
            out_ += "#error \"" + name + "\" is no file of the device code\n";
    }

    /// Whether the next directive after `at` is `#define symbol`.
    static bool defines_next(const std::string& text, std::size_t at, std::string_view symbol) {
        while (at < text.size()) {
            std::size_t end = text.find('\n', at);
            if (end == text.npos) end = text.size();
            const auto [word, rest] = directive(std::string_view(text.data() + at, end - at));
            if (!word.empty()) return word == "define" && first_word(rest) == symbol;
            at = end + 1;
        }
        return false;
    }
};

}  // namespace

namespace {

/// Of files that come before the embedded ones; empty: there are none.
std::string source_folder() {
    const char* folder = std::getenv("IRRADIA_CL_DIR");
    return folder != nullptr ? folder : "";
}

const EmbeddedFile* find_embedded(const std::string& name) {
    for (const EmbeddedFile* f = embedded_files(); f->name != nullptr; ++f)
        if (name == f->name) return f;
    return nullptr;
}

}  // namespace

bool find_source(const std::string& name, std::string& text) {
    if (name.starts_with('/')) return read_text(name, text);
    if (const std::string folder = source_folder(); !folder.empty())
        if (read_text(folder + "/" + name, text) || read_text(folder + "/../include/" + name, text)) return true;
    const EmbeddedFile* const f = find_embedded(name);
    if (f == nullptr) return false;
    text.assign(reinterpret_cast<const char*>(f->text), f->bytes);
    return true;
}

std::string expand_source(const std::string& file, std::string memory) {
    std::string text;
    if (!find_source(file, text)) {
        std::string known;
        for (const EmbeddedFile* f = embedded_files(); f->name != nullptr; ++f)
            if (std::string_view(f->name).ends_with(".cl")) known += (known.empty() ? "" : ", ") + std::string(f->name);
        throw Error("no device code '" + file + "' (there are: " + known + ")");
    }
    return Expander(std::move(memory)).run(file, text);
}

const Checksums* embedded_sums(const std::string& file) {
    const EmbeddedFile* const f = source_folder().empty() ? find_embedded(file) : nullptr;
    return f != nullptr ? &f->sums : nullptr;
}

}  // namespace irradia::device
