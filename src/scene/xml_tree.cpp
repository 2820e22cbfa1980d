#include "scene/xml_tree.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <pugixml.hpp>
#include <set>
#include <sstream>

namespace fs = std::filesystem;

namespace irradia::loader {

std::string where(const Node& node) {
    return fmt::format("{}:{}", node.file ? *node.file : std::string("?"), node.line);
}

std::string describe(const Node& node) {
    std::string text = "<" + node.tag;
    for (const char* key : {"type", "name", "id"})
        if (const auto* value = node.find(key)) text += fmt::format(" {}=\"{}\"", key, *value);
    return text + ">";
}

void fail(const Node& node, const std::string& message) {
    std::string line = where(node) + ": " + message;
    for (char& c : line)  // what a damaged file holds is quoted, and must not move the cursor
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
    throw Error(line);
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t best_distance = std::max<std::size_t>(1, name.size() / 3) + 1;
    for (const auto& candidate : candidates) {
        // Optimal string alignment: insertions, deletions, substitutions, swaps of neighbours.
        const std::size_t columns = candidate.size() + 1;
        std::vector<std::size_t> d((name.size() + 1) * columns);
        const auto at = [&](std::size_t i, std::size_t j) -> std::size_t& { return d[i * columns + j]; };
        for (std::size_t i = 0; i <= name.size(); ++i) at(i, 0) = i;
        for (std::size_t j = 0; j < columns; ++j) at(0, j) = j;
        for (std::size_t i = 1; i <= name.size(); ++i)
            for (std::size_t j = 1; j < columns; ++j) {
                const bool equal = name[i - 1] == candidate[j - 1];
                at(i, j) = std::min({at(i - 1, j) + 1, at(i, j - 1) + 1, at(i - 1, j - 1) + (equal ? 0 : 1)});
                if (i > 1 && j > 1 && name[i - 1] == candidate[j - 2] && name[i - 2] == candidate[j - 1])
                    at(i, j) = std::min(at(i, j), at(i - 2, j - 2) + 1);
            }
        if (d.back() < best_distance) {
            best_distance = d.back();
            best = candidate;
        }
    }
    return best;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
    const std::string nearest = nearest_name(name, candidates);
    return nearest.empty() ? std::string() : fmt::format("; did you mean '{}'?", nearest);
}

void Context::unsupported(const Node& node, const std::string& supported, const std::string& substitute) const {
    if (!options.lenient)
        fail(node, fmt::format("{} is not supported (supported: {}); --lenient substitutes: {}", describe(node),
                               supported, substitute));
    warn(node, fmt::format("{} is not supported; substituted: {}", describe(node), substitute));
}

void Context::problem(const Node& node, const std::string& message, const std::string& substitute) const {
    if (!options.lenient) fail(node, fmt::format("{}; --lenient: {}", message, substitute));
    warn(node, fmt::format("{}; {}", message, substitute));
}

std::string Document::resolve(const Node& node, const std::string& filename) const {
    if (filename.empty()) fail(node, describe(node) + " has an empty file name");
    const fs::path path(filename);
    std::vector<fs::path> tried;
    if (path.is_absolute()) {
        tried.push_back(path);
    } else {
        tried.push_back(fs::path(*node.file).parent_path() / path);
        for (const auto& folder : search_folders) tried.push_back(fs::path(folder) / path);
    }
    std::error_code ignored;
    for (const auto& candidate : tried)
        if (fs::is_regular_file(candidate, ignored)) return candidate.string();
    if (fs::is_directory(tried.front(), ignored))
        fail(node, fmt::format("'{}' is a folder, a file was expected", tried.front().string()));
    std::string elsewhere;
    for (std::size_t i = 1; i < tried.size(); ++i)
        if (std::find(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(i), tried[i]) ==
            tried.begin() + static_cast<std::ptrdiff_t>(i))
            elsewhere += fmt::format("{} '{}'", elsewhere.empty() ? ", nor" : " or", tried[i].string());
    fail(node, fmt::format("file '{}' does not exist{}", tried.front().string(), elsewhere));
}

const Node& Document::follow(const Node& ref) const {
    const auto* id = ref.find("id");
    if (!id) fail(ref, "<ref> needs an id");
    const auto it = ids.find(*id);
    if (it == ids.end()) {
        std::vector<std::string> known;
        for (const auto& entry : ids) known.push_back(entry.first);
        std::sort(known.begin(), known.end());
        fail(ref, fmt::format("unknown id '{}'{}", *id, did_you_mean(*id, known)));
    }
    return *it->second;
}

namespace {

// What may be written, and with which attributes.
const std::map<std::string, std::set<std::string>>& known_tags() {
    static const auto table = [] {
        std::map<std::string, std::set<std::string>> t;
        for (const char* object : {"sensor", "integrator", "bsdf", "shape", "emitter", "texture", "film", "rfilter",
                                   "sampler", "medium", "volume", "phase"})
            t[object] = {"type", "id", "name"};
        t["scene"] = {"version", "id", "type"};
        t["ref"] = {"id", "name"};
        for (const char* property : {"float", "integer", "boolean", "string", "rgb", "spectrum"})
            t[property] = {"name", "value"};
        t["spectrum"].insert("filename");
        t["vector"] = t["point"] = {"name", "value", "x", "y", "z"};
        t["transform"] = {"name"};
        t["translate"] = t["scale"] = {"value", "x", "y", "z"};
        t["rotate"] = {"value", "x", "y", "z", "angle"};
        t["lookat"] = {"origin", "target", "up"};
        t["matrix"] = {"value"};
        t["default"] = {"name", "value"};
        t["include"] = {"filename"};
        t["path"] = {"value"};
        t["alias"] = {"id", "as"};
        return t;
    }();
    return table;
}

class Reader {
public:
    Reader(const Context& context, Document& document)
        : context_(context), document_(document), values_(context.options.defines) {}

    void read(const std::string& path) {
        document_.search_folders.push_back(fs::path(path).parent_path().string());
        document_.root = read_file(path, nullptr);
        if (document_.root.tag != "scene")
            fail(document_.root, fmt::format("the root element is <{}>, <scene> was expected", document_.root.tag));
        check_defines();
        collect_ids(document_.root);
        for (const auto& [alias, as] : aliases_) {
            const Node& target = document_.follow(*alias);
            add_id(as, target, *alias);
        }
    }

private:
    const Context& context_;
    Document& document_;
    std::map<std::string, std::string> values_;  // -D and <default>
    std::set<std::string> used_;
    std::vector<std::string> stack_;  // files being read, for include loops
    std::deque<Node> alias_nodes_;
    std::vector<std::pair<const Node*, std::string>> aliases_;

    Node read_file(const std::string& path, const Node* includer) {
        std::error_code ignored;
        const std::string canonical = fs::weakly_canonical(path, ignored).string();
        if (std::find(stack_.begin(), stack_.end(), canonical) != stack_.end())
            fail(*includer, fmt::format("'{}' includes itself ({})", path, fmt::join(stack_, " -> ")));
        std::ifstream stream(path, std::ios::binary);
        if (!fs::exists(path, ignored)) throw Error(fmt::format("scene file '{}' does not exist", path));
        if (fs::is_directory(path, ignored) || !stream)
            throw Error(fmt::format("scene file '{}' cannot be read", path));
        std::stringstream buffer;
        buffer << stream.rdbuf();
        const std::string text = buffer.str();

        document_.files.push_back(path);
        const std::string* name = &document_.files.back();
        std::vector<std::ptrdiff_t> newlines;
        for (std::size_t i = 0; i < text.size(); ++i)
            if (text[i] == '\n') newlines.push_back(static_cast<std::ptrdiff_t>(i));
        const auto line_of = [&](std::ptrdiff_t offset) {
            return static_cast<int>(std::lower_bound(newlines.begin(), newlines.end(), offset) - newlines.begin()) + 1;
        };

        pugi::xml_document xml;
        const auto result = xml.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
        if (!result) {
            const auto message = result.status == pugi::status_no_document_element
                                     ? "no XML element in it; a scene file or a packed scene was expected"
                                     : result.description();
            throw Error(fmt::format("{}:{}: malformed XML: {}", path, line_of(result.offset), message));
        }
        const pugi::xml_node root = xml.document_element();
        if (root.next_sibling())
            throw Error(fmt::format("{}:{}: malformed XML: a second root element <{}>", path,
                                    line_of(root.next_sibling().offset_debug()), root.next_sibling().name()));
        stack_.push_back(canonical);
        Node node = convert(root, name, line_of, nullptr);
        stack_.pop_back();
        return node;
    }

    template <class LineOf>
    Node convert(const pugi::xml_node& xml, const std::string* file, const LineOf& line_of, const Node* parent) {
        Node node;
        node.tag = xml.name();
        node.file = file;
        node.line = line_of(xml.offset_debug());
        const auto known = known_tags().find(node.tag);
        if (known == known_tags().end()) {
            if (!parent) fail(node, fmt::format("the root element is <{}>, <scene> was expected", node.tag));
            std::vector<std::string> names;
            for (const auto& entry : known_tags()) names.push_back(entry.first);
            context_.problem(node, fmt::format("unknown element <{}>{}", node.tag, did_you_mean(node.tag, names)),
                             "left out");
            node.tag.clear();
            return node;
        }
        for (const auto& attribute : xml.attributes()) {
            const std::string key = attribute.name();
            if (node.attributes.count(key))
                fail(node, fmt::format("{}: attribute '{}' is given twice", describe(node), key));
            if (!known->second.count(key)) {
                const std::vector<std::string> names(known->second.begin(), known->second.end());
                context_.problem(node,
                                 fmt::format("<{}>: unknown attribute '{}'{}", node.tag, key, did_you_mean(key, names)),
                                 "ignored");
                continue;
            }
            node.attributes[key] = substitute(node, attribute.value());
        }
        for (const auto& child : xml.children()) {
            if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
                node.line = line_of(child.offset_debug());
                std::string text = child.value();
                text.erase(0, text.find_first_not_of(" \t\r\n"));
                text = text.substr(0, std::min<std::size_t>(text.find_first_of("\r\n"), 30));
                fail(node, fmt::format("stray text '{}' inside <{}>", text, node.tag));
            }
            if (child.type() != pugi::node_element) continue;
            Node converted = convert(child, file, line_of, &node);
            if (!converted.tag.empty()) place(std::move(converted), node);
        }
        return node;
    }

    /// Carries out <default>, <include>, <path> and <alias>; everything else becomes a child.
    void place(Node&& child, Node& parent) {
        const auto need = [&](const char* attribute) -> const std::string& {
            const auto* value = child.find(attribute);
            if (!value) fail(child, fmt::format("<{}> needs the attribute '{}'", child.tag, attribute));
            return *value;
        };
        if (child.tag == "default") {
            used_.insert(need("name"));
            values_.emplace(need("name"), need("value"));  // -D and an earlier <default> win
        } else if (child.tag == "include") {
            Node included = read_file(document_.resolve(child, need("filename")), &child);
            if (included.tag == "scene")
                for (auto& grandchild : included.children) parent.children.push_back(std::move(grandchild));
            else
                parent.children.push_back(std::move(included));
        } else if (child.tag == "path") {
            const fs::path folder = fs::path(*child.file).parent_path() / need("value");
            std::error_code ignored;
            if (!fs::is_directory(folder, ignored))
                fail(child, fmt::format("<path>: '{}' is not a folder", folder.string()));
            document_.search_folders.push_back(folder.string());
        } else if (child.tag == "alias") {
            need("id");
            const std::string as = need("as");
            alias_nodes_.push_back(std::move(child));
            aliases_.emplace_back(&alias_nodes_.back(), as);
        } else {
            parent.children.push_back(std::move(child));
        }
    }

    /// Replaces every $name by its value: the longest known name that fits, as Mitsuba does.
    std::string substitute(const Node& node, const std::string& value) {
        std::string result;
        for (std::size_t i = 0; i < value.size();) {
            if (value[i] != '$') {
                result += value[i++];
                continue;
            }
            std::size_t end = i + 1;
            while (end < value.size() && (std::isalnum(static_cast<unsigned char>(value[end])) || value[end] == '_'))
                ++end;
            const std::string word = value.substr(i + 1, end - i - 1);
            std::size_t length = word.size();
            while (length > 0 && !values_.count(word.substr(0, length))) --length;
            if (length == 0) {
                std::vector<std::string> names;
                for (const auto& entry : values_) names.push_back(entry.first);
                fail(node, fmt::format("<{}> uses ${}, which has no value: give -D {}=... or a <default> before it{}",
                                       node.tag, word, word, did_you_mean(word, names)));
            }
            used_.insert(word.substr(0, length));
            result += values_.at(word.substr(0, length));
            i += 1 + length;
        }
        return result;
    }

    void check_defines() const {
        for (const auto& entry : context_.options.defines) {
            if (used_.count(entry.first)) continue;
            const std::vector<std::string> names(used_.begin(), used_.end());
            const std::string message = fmt::format("-D {}: {} has no ${}{}", entry.first, document_.files.front(),
                                                    entry.first, did_you_mean(entry.first, names));
            if (!context_.options.lenient) throw Error(message);
            context_.warn(message + "; ignored");
        }
    }

    void add_id(const std::string& id, const Node& target, const Node& at) {
        const auto [it, inserted] = document_.ids.emplace(id, &target);
        if (!inserted) fail(at, fmt::format("id '{}' is already used at {}", id, where(*it->second)));
    }

    void collect_ids(const Node& node) {
        if (node.tag != "ref")
            if (const auto* id = node.find("id")) add_id(*id, node, node);
        for (const auto& child : node.children) collect_ids(child);
    }
};

}  // namespace

void read_document(const std::string& path, const Context& context, Document& document) {
    Reader(context, document).read(path);
}

}  // namespace irradia::loader
