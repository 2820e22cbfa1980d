// Progress in words, and counts and times for people.
#pragma once
#include <string>

#include "irradia/Renderer.h"

namespace irradia::app {

/// "12 345", "1.25 M": counts for people.
std::string count_text(double count);
/// "0.8 s", "41 s", "2:05", "1:02:05".
std::string time_text(double seconds);
/// Stage, records, rays a second and time left, without the bar; what a log gets: "records: 43 %, 5 321 records, ...".
std::string progress_text(const Progress& progress);
/// Seconds left by what is done so far; negative: too early to tell.
double seconds_left(const Progress& progress);
/// The same as progress_text() behind a bar, at most `columns` wide.
std::string progress_bar(const Progress& progress, int columns);

/// Width of the terminal on stderr; 0 if stderr is none.
int terminal_columns();

}  // namespace irradia::app
