// render: a scene file in, pictures out.
#include <exception>
#include <iostream>
#include <new>
#include <string_view>

#include "app/batch.h"
#include "app/help.h"
#include "app/log.h"
#include "app/log_options.h"
#include "app/memory_option.h"
#include "app/options.h"
#include "app/progress.h"
#include "app/render_job.h"
#include "app/session.h"
#include "app/stop_signal.h"
#include "irradia/Device.h"
#include "irradia/Error.h"

namespace irradia::app {
namespace {

void print_devices() {
    const std::vector<DeviceDescription> devices = list_devices();
    if (devices.empty())
        throw Error("no OpenCL device: install a driver, for example Debian's pocl-opencl-icd for the CPU");
    for (const DeviceDescription& d : devices)
        std::cout << d.index << ": " << d.name << " (" << d.platform << ", " << d.driver << "), "
                  << (d.is_cpu ? "CPU, " : "") << d.compute_units << " compute units, " << (d.global_memory >> 20)
                  << " MiB, " << (d.local_memory >> 10) << " KiB local\n";
}

int run(const Options& o, Log& log) {
    if (o.list_devices) {
        print_devices();
        return 0;
    }
    Session session(log);
    return o.batch.empty() ? RenderJob(o, session).run() : run_batch(o, session);
}

}  // namespace
}  // namespace irradia::app

int main(int argc, char** argv) {
    namespace app = irradia::app;
    if (argc == 2 && std::string_view(argv[1]) == irradia::kCompileForParent) {
        const int status = irradia::compile_for_parent();
        std::cerr << "render: " << argv[1] << ": expected to be started by render itself\n";
        return status;
    }
    app::Options options;
    if (const int status = app::parse_options(argc, argv, options, std::cerr); status >= 0) return status;
    app::ignore_closed_pipes();
    app::remember_signals();
    app::Log log(app::log_settings(options), app::terminal_columns());
    const auto failed = [&](const std::string& what, int status) {
        log.failed(what, status);
        if (status == app::kBadCommandLine)  // those of parse_options() are plain text, and so are these
            std::cerr << "render: " << what << '\n';
        else
            log.error(what);
        return status;
    };
    try {
        return app::run(options, log);
    } catch (const app::Stopped& stopped) {
        return failed(std::string("stopped by ") + app::signal_name(stopped.signal), 128 + stopped.signal);
    } catch (const irradia::Error& error) {
        return failed(error.what(), error.exit_status());
    } catch (const std::bad_alloc&) {
        return failed(app::out_of_memory_text(), app::kBadInput);
    } catch (const std::exception& error) {
        return failed(error.what(), app::kBadInput);
    }
}
