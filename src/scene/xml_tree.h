// The scene file as a tree: includes spliced in, $names substituted, ids collected, every node knowing its file and
// line.
#pragma once
#include <deque>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "irradia/Error.h"
#include "irradia/SceneLoader.h"

namespace irradia::loader {

struct Node {
    std::string tag;
    std::map<std::string, std::string> attributes;
    std::deque<Node> children;          // deque: addresses stay valid while it grows
    const std::string* file = nullptr;  // as named by the user or by <include>
    int line = 0;

    [[nodiscard]] const std::string* find(const std::string& attribute) const {
        const auto it = attributes.find(attribute);
        return it == attributes.end() ? nullptr : &it->second;
    }
    [[nodiscard]] std::string get(const std::string& attribute) const {
        const auto* value = find(attribute);
        return value ? *value : std::string();
    }
};

/// "file:line"
std::string where(const Node& node);
/// `<bsdf type="diffuse" id="wall">` as messages show an element
std::string describe(const Node& node);
/// Throws Error "file:line: message".
[[noreturn]] void fail(const Node& node, const std::string& message);
/// The candidate nearest to `name` (edit distance up to a third of its length), or "".
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);
/// ", did you mean 'x'?" or ""
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

struct Document {
    std::deque<std::string> files;            // owns the names Node::file points to
    std::vector<std::string> search_folders;  // the scene's own folder first, then <path>s
    Node root;
    std::unordered_map<std::string, const Node*> ids;  // id or alias -> element

    /// The file an element's `filename` names: absolute, beside the element's file, or in a search folder. Throws
    /// Error.
    [[nodiscard]] std::string resolve(const Node& node, const std::string& filename) const;
    /// Follows <ref id="..."/>. Throws Error naming the nearest id.
    [[nodiscard]] const Node& follow(const Node& ref) const;
};

/// Warnings and what to do about the unsupported.
struct Context {
    const LoadOptions& options;
    void warn(const std::string& line) const {
        if (options.warn) options.warn(line);
    }
    void warn(const Node& node, const std::string& message) const { warn(where(node) + ": " + message); }
    void progress(const char* stage, double fraction) const {
        if (options.progress) options.progress(stage, fraction);
    }
    void need(std::uint64_t bytes, const char* what) const {
        if (options.need) options.need(bytes, what);
    }
    /// Strict: throws "file:line: <element> is not supported; supported: ...". Lenient: warns, naming the substitute.
    void unsupported(const Node& node, const std::string& supported, const std::string& substitute) const;
    /// The same with free wording: strict throws `message`, lenient warns "message; substitute".
    void problem(const Node& node, const std::string& message, const std::string& substitute) const;
};

void read_document(const std::string& path, const Context& context, Document& document);

}  // namespace irradia::loader
