// Device code as one text a compiler takes: embedded files, their #include lines resolved.
#pragma once
#include <cstddef>
#include <string>

#include "core/checksum.h"

namespace irradia::device {

/// One file of device code carried by the executable. The table ends with name == nullptr.
struct EmbeddedFile {
    const char* name;  ///< as #include lines spell it: "trace.h", "irradia/shared/scene_types.h"
    const unsigned char* text;
    std::size_t bytes;
    Checksums sums;  ///< of it and all files that it includes, directly or not
};

/// The table that cmake/EmbedKernels.cmake generates.
const EmbeddedFile* embedded_files();

/// The text of `name`. Looked for in the folder IRRADIA_CL_DIR first, if that variable is set (a header of
/// irradia/shared also in ../include beside that folder), then among the embedded files. An absolute path is read as
/// it is. Returns false if there is no such file.
bool find_source(const std::string& name, std::string& text);

/// The text of `file` with every `#include "..."` replaced by what it names, #line directives keeping the compiler's
/// messages at the right file and line. A header that is certain to have been seen is left out; one that was seen only
/// under a condition (#if, #ifdef) comes again, so headers need include guards. A header that does not exist becomes
/// an #error, which counts only where the preprocessor gets to it. `memory`: a string whose memory it may take, since
/// pages of new memory cost more than the text. Throws Error if `file` does not exist.
std::string expand_source(const std::string& file, std::string memory = {});

/// Sums of `file` and all that it includes, which the build has taken: where nothing but embedded files can be part of
/// what expand_source makes of it, that text is known by them before it is made. Null for any other file.
const Checksums* embedded_sums(const std::string& file);

}  // namespace irradia::device
