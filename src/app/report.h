// One page that shows a render: what --report writes. HTML that is well-formed XML too, with all pictures inside.
#pragma once
#include <string>

#include "app/stats.h"
#include "irradia/Image.h"
#include "irradia/RecordFile.h"

namespace irradia::app {

struct ReportInput {
    const Run& run;
    const Image& image;                  ///< the picture and all layers of aov_names()
    const RecordSet* records = nullptr;  ///< all that the caches know; null or empty: there is no such section
    const Image* reference = nullptr;    ///< null: none was given; else one that check_reference() has accepted
};

/// Throws Error if the page cannot be written: as check_writable() does, or what makes its pictures is missing.
void check_report(const std::string& path);

/// Writes the page beside `path` and renames it. Throws Error: unwritable, or values that are not finite (as of a
/// picture).
void write_report(const std::string& path, const ReportInput& input);

/// Throws Error, which names `path`, unless a picture of `width` x `height` pixels can be compared with the reference.
void check_reference(const std::string& path, const Image& reference, int width, int height);

/// The picture with those layers alone that `names` lists.
Image with_layers(const Image& image, const std::vector<std::string>& names);

}  // namespace irradia::app
