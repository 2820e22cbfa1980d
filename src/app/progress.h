// Progress on stderr: a bar on a terminal, a line now and then in a log.
#pragma once
#include <iosfwd>
#include <string>

#include "irradia/Renderer.h"

namespace irradia::app {

/// "12 345", "1.25 M": counts for people.
std::string count_text(double count);
/// "0.8 s", "41 s", "2:05", "1:02:05".
std::string time_text(double seconds);
/// Stage, records, rays a second and time left, without the bar; what a log gets: "records: 43 %, 5 321 records, ...".
std::string progress_text(const Progress& progress);
/// The same behind a bar, at most `columns` wide.
std::string progress_bar(const Progress& progress, int columns);

/// Prints progress at a bearable rate, by Progress::elapsed: ten times a second on a terminal, every five seconds
/// (later, of 5 % of the time so far) and at the change of a stage in a log.
class ProgressPrinter {
public:
    /// `columns`: width of the terminal, 0 if `out` is none.
    ProgressPrinter(std::ostream& out, int columns) : out_(out), columns_(columns) {}
    void operator()(const Progress& progress);
    /// Clears the bar, so that other lines can follow.
    void clear();

private:
    std::ostream& out_;
    int columns_;
    double last_ = 0;
    bool bar_shown_ = false;
    std::string stage_;
};

/// Width of the terminal on stderr; 0 if stderr is none.
int terminal_columns();

}  // namespace irradia::app
