#include "app/log.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>

namespace irradia::app {
namespace {

constexpr const char* kEraseLine = "\r\033[K";

/// errno of the write that failed, 0 if none did.
int write_all(int file, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {  // once, unless a signal or a full pipe cuts it
        const ssize_t written = ::write(file, text.data() + done, text.size() - done);
        if (written > 0) {
            done += static_cast<std::size_t>(written);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {  // somebody has made it non-blocking
            pollfd wait{file, POLLOUT, 0};
            ::poll(&wait, 1, 1000);
        } else if (errno != EINTR) {
            return errno;
        }
    }
    return 0;
}

std::string utc_now() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
    const std::time_t seconds = static_cast<std::time_t>(milliseconds / 1000);
    std::tm parts{};
    ::gmtime_r(&seconds, &parts);
    char date[32], text[48];
    std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &parts);
    std::snprintf(text, sizeof text, "%s.%03dZ", date, static_cast<int>(milliseconds % 1000));
    return text;
}

const char* name_of(Level level) {
    switch (level) {
        case Level::detail:
            return "detail";
        case Level::info:
            return "info";
        case Level::warning:
            return "warning";
        case Level::error:
            return "error";
    }
    return "";
}

/// File names need not be UTF-8, JSON does.
std::string line_of(const Fields& object) {
    return object.dump(-1, ' ', false, Fields::error_handler_t::replace) + "\n";
}

std::string plain(const Fields& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

}  // namespace

Log::Log(const LogSettings& settings, int columns, int err, int out)
    : settings_(settings), columns_(columns), err_(err), out_(out) {}

bool Log::shows(Level level) const noexcept {
    if (level == Level::error) return true;
    return !settings_.quiet && (level != Level::detail || settings_.verbose);
}

void Log::put_error(std::string text) {
    if (bar_shown_) text.insert(0, kEraseLine);
    bar_shown_ = false;
    write_all(err_, text);  // if nobody listens, there is nobody to tell
}

void Log::put_object(Level level, const std::string& text, const Fields& fields) {
    Fields object{{"time", utc_now()}, {"level", name_of(level)}, {"message", text}};
    object.update(context_);
    if (fields.is_object()) object.update(fields);
    put_error(line_of(object));
}

void Log::say(Level level, const std::string& text, const Fields& fields) {
    if (!shows(level)) return;
    const std::lock_guard lock(mutex_);
    if (settings_.json) return put_object(level, text, fields);
    std::string lines;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        lines += "render: " + prefix_ + (level == Level::warning && at == 0 ? "warning: " : "") +
                 text.substr(at, end - at) + "\n";
        at = end + 1;
    }
    put_error(std::move(lines));
}

void Log::table(const std::string& name, const std::string& text, const Fields& fields) {
    if (!shows(Level::detail)) return;
    const std::lock_guard lock(mutex_);
    if (settings_.json) return put_object(Level::detail, name, fields);
    put_error(text);
}

void Log::context(const Fields& fields) {
    const std::lock_guard lock(mutex_);
    context_ = fields.is_object() ? fields : Fields::object();
    prefix_.clear();
    for (const auto& [key, value] : context_.items())
        prefix_ += (prefix_.empty() ? "[" : ", ") + key + " " + plain(value);
    if (!prefix_.empty()) prefix_ += "] ";
}

void Log::event(const std::string& kind, const Fields& fields) {
    std::string why;
    {
        const std::lock_guard lock(mutex_);
        if (!settings_.progress || broken_) return;
        Fields object = Fields::object();
        object["event"] = kind;
        object.update(context_);
        if (fields.is_object()) object.update(fields);
        const int error = write_all(out_, line_of(object));
        broken_ = error != 0;
        if (broken_) why = std::strerror(error);
    }
    if (!why.empty()) warn("--progress: stdout cannot be written (" + why + "): nothing more is sent");
}

void Log::done(const std::vector<std::string>& outputs, double seconds) {
    event("done", {{"outputs", outputs}, {"seconds", seconds}});
}

void Log::failed(const std::string& message, int exit_status) {
    event("error", {{"message", message}, {"status", exit_status}});
}

void Log::bar(const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (columns() <= 0) return;
    write_all(err_, kEraseLine + text);
    bar_shown_ = true;
}

void Log::clear_bar() {
    const std::lock_guard lock(mutex_);
    if (bar_shown_) put_error("");
}

void ignore_closed_pipes() { std::signal(SIGPIPE, SIG_IGN); }

}  // namespace irradia::app
