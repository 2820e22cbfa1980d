#include "app/log_options.h"

namespace irradia::app {

void declare_messages(CLI::App& app, Options& o) {
    const auto flag = [&](const char* names, bool& target, const char* help) {
        return app.add_flag(names, target, help)->group("Messages");
    };
    CLI::Option* quiet = flag("-q,--quiet", o.quiet, "Print errors only");
    flag("-v,--verbose", o.verbose, "Print what was loaded, the device, and the time of every stage")->excludes(quiet);
    flag("--log-json", o.log_json,
         "Messages for collectors: on stderr one JSON object a line, with time, level, message and what belongs to it "
         "(stage, seconds, records, ...)");
    flag("--progress", o.progress,
         "Progress for programs: on stdout one JSON object a line, at most five a second and one at each change of "
         "stage; its key \"event\" is progress, stage, done or error");
}

LogSettings log_settings(const Options& o) { return {o.quiet, o.verbose, o.log_json, o.progress}; }

}  // namespace irradia::app
