#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <set>

#include "core/input_file.h"
#include "irradia/CameraPath.h"
#include "irradia/Error.h"

namespace irradia {
namespace {

using nlohmann::json;

std::string printable(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
    return text;
}

/// One line of printable characters, cut short if it is long.
std::string shown(std::string text) {
    text = printable(std::move(text));
    if (text.size() > 60) text = text.substr(0, 57) + "...";
    return text;
}
std::string shown(const json& value) { return shown(value.dump(-1, ' ', false, json::error_handler_t::replace)); }

std::string read_text(const std::string& file) {
    InputFile input(file);
    constexpr std::uint64_t kMost = std::uint64_t{64} << 20;
    if (input.size() > kMost)
        throw Error(file + ": found " + std::to_string(input.size()) + " bytes, expected a camera path of at most " +
                    std::to_string(kMost));
    std::string text(input.size(), '\0');
    input.read(text.data(), text.size());
    return text;
}

[[noreturn]] void fail_at(const std::string& file, const std::string& text, std::size_t byte, const std::string& what) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
    throw Error(file + ":" + std::to_string(1 + std::count(text.begin(), end, '\n')) + ": " + what);
}

json parse(const std::string& file, const std::string& text) {
    // Of a name that is given twice the library would take the last, without a word.
    std::vector<std::set<std::string>> names;
    const auto look = [&](int, json::parse_event_t event, json& value) {
        if (event == json::parse_event_t::object_start) names.emplace_back();
        if (event == json::parse_event_t::object_end) names.pop_back();
        if (event == json::parse_event_t::key && !names.back().insert(value.get<std::string>()).second)
            throw Error(file + ": found " + shown(value) + " twice in one object, expected it once");
        return true;
    };
    try {
        return json::parse(text, look);
    } catch (const json::parse_error& error) {
        std::string why = error.what();  // "[json.exception...] parse error at line 1, column 2: syntax error ..."
        if (const auto column = why.find("column "); column != std::string::npos)
            if (const auto colon = why.find(": ", column); colon != std::string::npos) why = why.substr(colon + 2);
        fail_at(file, text, error.byte > 0 ? error.byte - 1 : 0, "found no JSON: " + printable(std::move(why)));
    } catch (const json::out_of_range& error) {  // "... number overflow parsing '1e999'"
        const std::string why = error.what();
        const auto first = why.find('\''), last = why.rfind('\'');
        const std::string number = first < last ? why.substr(first + 1, last - first - 1) : "";
        fail_at(file, text, text.find(number), "found " + shown(number) + ", expected a number of at most 1e18");
    }
}

void check_names(const std::string& where, const json& object, std::initializer_list<const char*> known) {
    for (const auto& item : object.items()) {
        if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
        std::string list;
        for (const char* const* name = known.begin(); name != known.end(); ++name)
            list += (name == known.begin() ? "" : name + 1 == known.end() ? " or " : ", ") + std::string(*name);
        throw Error(where + ": found '" + shown(item.key()) + "', expected " + list);
    }
}

/// The value by that name, or null.
const json* find(const json& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? nullptr : &*found;
}

double number(const std::string& where, const json* value, const char* expected) {
    if (!value || !value->is_number())
        throw Error(where + ": found " + (value ? shown(*value) : "nothing") + ", expected " + expected);
    return value->get<double>();
}

std::array<double, 3> triple(const std::string& where, const json* value) {
    const bool numbers = value && value->is_array() && value->size() == 3 &&
                         std::all_of(value->begin(), value->end(), [](const json& v) { return v.is_number(); });
    if (!numbers) throw Error(where + ": found " + (value ? shown(*value) : "nothing") + ", expected three numbers");
    return {(*value)[0].get<double>(), (*value)[1].get<double>(), (*value)[2].get<double>()};
}

CameraKeyframe read_keyframe(const std::string& where, const json& object) {
    if (!object.is_object()) throw Error(where + ": found " + shown(object) + ", expected an object {\"frame\": ...}");
    check_names(where, object, {"frame", "origin", "target", "up", "fov", "focus_distance"});
    CameraKeyframe key;
    key.frame = number(where + ".frame", find(object, "frame"), "the number of a frame");
    key.origin = triple(where + ".origin", find(object, "origin"));
    key.target = triple(where + ".target", find(object, "target"));
    if (const json* up = find(object, "up")) key.up = triple(where + ".up", up);
    if (const json* fov = find(object, "fov")) key.fov = number(where + ".fov", fov, "degrees");
    if (const json* focus = find(object, "focus_distance"))
        key.focus_distance = number(where + ".focus_distance", focus, "a positive number");
    return key;
}

}  // namespace

CameraPath read_camera_path(const std::string& file) {
    const json root = parse(file, read_text(file));
    if (!root.is_object()) throw Error(file + ": found " + shown(root) + ", expected an object {\"keyframes\": [...]}");
    check_names(file, root, {"interpolation", "fov_axis", "keyframes"});
    CameraPath path;
    path.source = file;
    if (const json* interpolation = find(root, "interpolation")) {
        if (*interpolation != "smooth" && *interpolation != "linear")
            throw Error(file + ": interpolation: found " + shown(*interpolation) +
                        ", expected \"smooth\" or \"linear\"");
        path.smooth = *interpolation == "smooth";
    }
    if (const json* axis = find(root, "fov_axis")) {
        if (!axis->is_string() || axis->get_ref<const std::string&>().empty())
            throw Error(file + ": fov_axis: found " + shown(*axis) + ", expected x, y, diagonal, smaller or larger");
        path.fov_axis = shown(axis->get<std::string>());
    }
    const json* keyframes = find(root, "keyframes");
    if (!keyframes || !keyframes->is_array())
        throw Error(file + ": keyframes: found " + (keyframes ? shown(*keyframes) : "nothing") +
                    ", expected a list of them");
    for (std::size_t i = 0; i < keyframes->size(); ++i)
        path.keyframes.push_back(read_keyframe(file + ": keyframes[" + std::to_string(i) + "]", (*keyframes)[i]));
    check_camera_path(path);
    return path;
}

}  // namespace irradia
