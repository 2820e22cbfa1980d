#include "app/batch_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/input_file.h"
#include "core/one_line.h"
#include "irradia/Error.h"

namespace irradia::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t most_bytes = 64u << 20;

// What a whole run is given, not a job of it.
constexpr std::array run_options = {
    "batch", "help", "version", "list-devices", "quiet", "verbose", "log-json", "progress", "h", "q", "v"};

struct Reader {
    const std::string& path;

    [[noreturn]] void fail(const std::string& field, const std::string& what) const {
        throw Error(path + ": " + one_line((field.empty() ? "" : field + ": ") + what));
    }
    [[nodiscard]] static std::string found(const Json& value) {
        std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
        if (text.size() > 40) text = text.substr(0, 37) + "...";
        return "found " + text;
    }
    void check_keys(const std::string& field, const Json& object, const std::set<std::string>& known) const {
        if (!object.is_object()) fail(field, found(object) + ", expected an object");
        for (const auto& [key, value] : object.items())
            if (known.count(key) == 0) {
                std::string all;
                for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
                fail(field, "unknown key '" + key + "', expected " + all);
            }
    }
    [[nodiscard]] std::string text(const std::string& field, const Json& value) const {
        if (!value.is_string() || value.get<std::string>().empty()) fail(field, found(value) + ", expected a text");
        return value.get<std::string>();
    }
    [[nodiscard]] std::string scalar(const std::string& field, const Json& value) const {
        if (value.is_string()) return value.get<std::string>();
        if (value.is_number()) return value.dump();
        fail(field, found(value) + ", expected a text, a number, true, false or a list of texts and numbers");
    }
    using Values = std::map<std::string, std::vector<std::string>>;
    void add_options(const std::string& field, const Json& object, Values& options) const {
        if (!object.is_object()) fail(field, found(object) + ", expected an object");
        for (const auto& [name, value] : object.items()) {
            const std::string where = field + "." + name;
            if (name.empty() || name.find_first_of("-= ") == 0 || name.find_first_of("= ") != std::string::npos)
                fail(where, "expected an option's long name without dashes, for example \"spp\"");
            if (std::find(run_options.begin(), run_options.end(), name) != run_options.end())
                fail(where, "is no option of a job, but of the command line");
            std::vector<std::string>& values = options[name];
            values.clear();
            if (value.is_boolean() && !value.get<bool>())
                options.erase(name);
            else if (value.is_boolean())
                values = {"true"};
            else if (value.is_array())
                for (const Json& element : value) values.push_back(scalar(where, element));
            else
                values = {scalar(where, value)};
        }
    }
};

Json parse(const std::string& path) {
    InputFile in(path);
    if (in.size() > most_bytes) throw Error(path + ": is too large for a list of jobs");
    std::string text(static_cast<std::size_t>(in.size()), '\0');
    in.read(text.data(), text.size());
    try {
        return Json::parse(text);
    } catch (const nlohmann::json::exception& error) {  // also of numbers out of range
        const std::string what = error.what();          // "[json.exception.parse_error.101] parse error at line 3, ..."
        const std::size_t from = what.find("] ");
        throw Error(path + ": " + one_line(from == std::string::npos ? what : what.substr(from + 2)));
    }
}

}  // namespace

std::vector<BatchJob> read_batch(const std::string& path, const GivenOptions& given) {
    const Reader reader{path};
    const Json file = parse(path);
    reader.check_keys("", file, {"defaults", "jobs"});
    if (!file.contains("jobs") || !file["jobs"].is_array() || file["jobs"].empty())
        reader.fail("jobs", "expected a list of at least one job");
    Reader::Values defaults;
    for (const auto& [name, values] : given)
        if (std::find(run_options.begin(), run_options.end(), name) == run_options.end()) defaults[name] = values;
    if (file.contains("defaults")) reader.add_options("defaults", file["defaults"], defaults);
    std::vector<BatchJob> jobs;
    std::set<std::string> names;
    for (std::size_t i = 0; i < file["jobs"].size(); ++i) {
        const Json& j = file["jobs"][i];
        const std::string field = "jobs[" + std::to_string(i) + "]";
        reader.check_keys(field, j, {"name", "scene", "output", "options"});
        BatchJob job;
        job.name = j.contains("name") ? reader.text(field + ".name", j["name"]) : std::to_string(i + 1);
        if (job.name.find_first_of("/\n") != std::string::npos)
            reader.fail(field + ".name", "'" + job.name + "': expected a name without '/'");
        if (!names.insert(job.name).second) reader.fail(field + ".name", "'" + job.name + "' is another job's, too");
        if (!j.contains("scene")) reader.fail(field, "has no \"scene\"");
        Reader::Values options = defaults;
        if (j.contains("options")) reader.add_options(field + ".options", j["options"], options);
        if (j.contains("output")) {
            options["output"].clear();
            const Json outputs = j["output"].is_array() ? j["output"] : Json::array({j["output"]});
            for (const Json& output : outputs) options["output"].push_back(reader.text(field + ".output", output));
        }
        for (const auto& [name, values] : options)
            for (const std::string& value : values) {
                const std::string option = (name.size() == 1 ? "-" : "--") + name;
                job.arguments.push_back(value == "true" ? option : option + "=" + value);
            }
        job.arguments.emplace_back("--");
        job.arguments.push_back(reader.text(field + ".scene", j["scene"]));
        jobs.push_back(std::move(job));
    }
    return jobs;
}

}  // namespace irradia::app
