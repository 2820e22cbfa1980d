// What `render` says: lines for people or JSON for collectors on stderr, and a stream for programs on stdout.
#pragma once
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace irradia::app {

using Fields = nlohmann::ordered_json;

enum class Level { detail, info, warning, error };

struct LogSettings {
    bool quiet = false;     ///< errors only
    bool verbose = false;   ///< details too
    bool json = false;      ///< one JSON object a line instead of plain lines
    bool progress = false;  ///< the stream on stdout
};

/// Every line goes out by one write(2), so that several processes may append to one file. From any thread.
class Log {
public:
    /// `columns`: width of the terminal that `err` is, 0 if it is none: then no bar is shown.
    explicit Log(const LogSettings& settings, int columns, int err = 2, int out = 1);

    void detail(const std::string& text, const Fields& fields = {}) { say(Level::detail, text, fields); }
    void info(const std::string& text, const Fields& fields = {}) { say(Level::info, text, fields); }
    void warn(const std::string& text, const Fields& fields = {}) { say(Level::warning, text, fields); }
    void error(const std::string& text, const Fields& fields = {}) { say(Level::error, text, fields); }
    /// A message; with JSON an object with `fields` besides.
    void say(Level level, const std::string& text, const Fields& fields = {});
    /// A detail of several lines that stand as they are; with JSON one object: `name` as message, and `fields`.
    void table(const std::string& name, const std::string& text, const Fields& fields);

    /// Of what all that follows is about, for example {{"job", "kitchen"}, {"frame", 12}}: fields of every object,
    /// "[job kitchen, frame 12]" in front of plain lines. Replaces the one before; {}: none.
    void context(const Fields& fields);

    /// An object of the stream: {"event": kind} and `fields`.
    void event(const std::string& kind, const Fields& fields);
    void done(const std::vector<std::string>& outputs, double seconds);
    void failed(const std::string& message, int exit_status);

    /// Shows a bar on the terminal, in place of the last one. The next line takes its place.
    void bar(const std::string& text);
    void clear_bar();

    [[nodiscard]] bool shows(Level level) const noexcept;
    /// Columns of the bar; 0: none is shown.
    [[nodiscard]] int columns() const noexcept { return settings_.quiet || settings_.json ? 0 : columns_; }
    [[nodiscard]] bool streams() const noexcept { return settings_.progress; }

private:
    void put_error(std::string text);
    void put_object(Level level, const std::string& text, const Fields& fields);

    LogSettings settings_;
    int columns_, err_, out_;
    std::mutex mutex_;
    bool bar_shown_ = false, broken_ = false;
    Fields context_ = Fields::object();
    std::string prefix_;
};

/// A reader that goes away costs its lines, not the render.
void ignore_closed_pipes();

}  // namespace irradia::app
