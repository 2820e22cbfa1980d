#include "app/batch.h"

#include <filesystem>
#include <map>
#include <new>
#include <sstream>

#include "app/batch_file.h"
#include "app/frames.h"
#include "app/help.h"
#include "app/memory_option.h"
#include "app/picture_output.h"
#include "app/progress.h"
#include "app/render_job.h"
#include "irradia/Error.h"

namespace irradia::app {
namespace {

/// Options of a job; `what`: what is wrong with them, "" if nothing.
Options parse_job(const BatchJob& job, std::string& what) {
    std::vector<const char*> arguments = {"render"};
    for (const std::string& argument : job.arguments) arguments.push_back(argument.c_str());
    std::ostringstream complaint;
    Options o;
    if (parse_options(static_cast<int>(arguments.size()), arguments.data(), o, complaint) >= 0) {
        what = complaint.str();
        const std::string program = "render: ";
        if (what.starts_with(program)) what.erase(0, program.size());
        while (!what.empty() && what.back() == '\n') what.pop_back();
    }
    return o;
}

using Jobs = std::vector<std::pair<std::string, Options>>;

/// A checkpoint of the whole run, or of several jobs, is one a job.
void tell_checkpoints_apart(Jobs& jobs, const Options& run) {
    std::map<std::string, int> users;
    for (const auto& [name, o] : jobs) ++users[o.checkpoint];
    for (auto& [name, o] : jobs)
        if (!o.checkpoint.empty() && (o.checkpoint == run.checkpoint || users[o.checkpoint] > 1))
            o.checkpoint += "." + name;
}

/// What a job writes that one before it writes too; "" if nothing. Frames may be of one series.
std::string written_before(const Options& o, const std::string& name, std::map<std::string, std::string>& writers) {
    std::vector<std::string> files = {o.stats, o.report, o.pack, o.save_records};
    files.insert(files.end(), o.outputs.begin(), o.outputs.end());
    for (const std::string& file : files) {
        if (file.empty() || (!o.frames.empty() && has_frame_place(file))) continue;
        const auto [writer, first] = writers.emplace(file, name);
        if (!first) return file + " is written by job " + writer->second + ", too";
    }
    return "";
}

bool finished(const Options& o) {
    std::error_code ignored;
    if (o.overwrite || !o.frames.empty() || o.outputs.empty()) return false;  // frames are looked at one by one
    const auto there = [&](const std::string& path) { return std::filesystem::exists(path, ignored); };
    if (!o.checkpoint.empty() && there(o.checkpoint)) return false;
    return results_there(o) && (o.save_records.empty() || there(o.save_records)) && (o.pack.empty() || there(o.pack));
}

}  // namespace

int run_batch(const Options& run, Session& session) {
    Log& log = session.log;
    const double began = now();
    std::vector<std::string> failed, skipped;
    Jobs jobs;
    std::map<std::string, std::string> writers;
    for (const BatchJob& job :
         read_batch(run.batch, run.given)) {  // what is wrong is said before the first is rendered
        std::string what;
        Options o = parse_job(job, what);
        if (what.empty()) what = written_before(o, job.name, writers);
        if (what.empty()) {
            jobs.emplace_back(job.name, std::move(o));
            continue;
        }
        log.error(run.batch + ": job " + job.name + ": " + what, {{"job", job.name}});
        log.event("error", {{"job", job.name}, {"message", what}, {"status", kBadCommandLine}});
        failed.push_back(job.name);
    }
    tell_checkpoints_apart(jobs, run);
    std::size_t done = 0;
    for (auto& [name, o] : jobs) {
        if (finished(o)) {
            skipped.push_back(name);
            continue;
        }
        const Fields context = {{"job", name}};
        std::string what;
        bool good = false;
        try {
            good = RenderJob(std::move(o), session, context).run() == 0;
        } catch (const std::bad_alloc&) {
            what = out_of_memory_text();
        } catch (const std::exception& error) {
            what = error.what();
        }
        if (!what.empty()) {
            log.error(what);
            log.event("error", {{"message", what}, {"status", kBadInput}});
        }
        log.context({});
        if (good)
            ++done;
        else
            failed.push_back(name);
    }
    const auto names = [](const std::vector<std::string>& list) {
        std::string out;
        for (const std::string& name : list) out += (out.empty() ? "" : ", ") + name;
        return out;
    };
    std::string text = "jobs: " + std::to_string(done) + " done in " + time_text(now() - began);
    if (!skipped.empty()) text += ", there already (--overwrite): " + names(skipped);
    if (!failed.empty()) text += ", failed: " + names(failed);
    log.say(failed.empty() ? Level::info : Level::error, text,
            {{"done", done}, {"skipped", skipped}, {"failed", failed}});
    return failed.empty() ? 0 : kSomeFailed;
}

}  // namespace irradia::app
