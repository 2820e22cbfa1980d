// The module: the only code that is linked with OpenEXR.
#include "pictures/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>

namespace irradia::exr {
namespace {

constexpr std::size_t values_a_thread = 1u << 15;  // which take 5 ms

/// A file in memory.
class Memory final : public Imf::OStream {
public:
    explicit Memory(const Output& picture, std::vector<unsigned char>& file)
        : OStream(picture.path.c_str()), file_(file) {}
    void write(const char bytes[], int count) override {
        const std::size_t n = static_cast<std::size_t>(count);
        if (at_ + n > file_.size()) file_.resize(at_ + n);
        std::copy_n(bytes, n, file_.begin() + static_cast<std::ptrdiff_t>(at_));
        at_ += n;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t position) override { at_ = position; }

private:
    std::vector<unsigned char>& file_;
    std::size_t at_ = 0;
};

// Noise hardly gets smaller: of the beauty of a rendered picture compression takes some hundredths, in 18 ns a byte.
constexpr std::size_t worth_compressing = std::size_t{1} << 20;  // bytes
// Larger ones row by row, at level 2: 0.6 to 0.75 of the time of ZIP's 16 rows at once at level 4, for files that are 2
// to 4 % larger (cornell-a at 1920x1080, without and with albedo, normals and depth; bathroom).

void write(const Output& picture, std::vector<unsigned char>& file) {
    const std::size_t values =
        static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * picture.channels.size();
    Imf::Header header(picture.width, picture.height);
    header.compression() = values * sizeof(float) < worth_compressing ? Imf::NO_COMPRESSION : Imf::ZIPS_COMPRESSION;
    header.zipCompressionLevel() = 2;
    header.insert("oiio:ColorSpace", Imf::StringAttribute("Linear"));
    header.insert("Software", Imf::StringAttribute("Irradia"));
    for (const auto& [name, value] : picture.attributes) header.insert(name, Imf::StringAttribute(value));
    Imf::FrameBuffer frame;
    for (const Channel& channel : picture.channels) {
        const std::size_t stride = channel.stride * sizeof(float);
        header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
        frame.insert(channel.name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(channel.first)),
                                              stride, stride * static_cast<std::size_t>(picture.width)));
    }
    file.reserve(values * sizeof(float));  // pages that are not needed are not touched
    std::size_t threads = std::min<std::size_t>(values / values_a_thread, std::thread::hardware_concurrency());
    if (picture.threads > 0) threads = std::min(threads, static_cast<std::size_t>(picture.threads));
    if (threads == 1) threads = 0;  // this one
    Imf::setGlobalThreadCount(static_cast<int>(threads));
    Memory memory(picture, file);
    Imf::OutputFile out(memory, header, static_cast<int>(threads));
    out.setFrameBuffer(frame);
    out.writePixels(picture.height);
}

std::string encode(const Output& picture, std::vector<unsigned char>& file) {
    try {
        write(picture, file);  // the file is complete when its destructor has run
        return "";
    } catch (const std::exception& e) {
        return std::string("cannot be written: ") + e.what();
    }
}

}  // namespace
}  // namespace irradia::exr

extern "C" [[gnu::visibility("default")]] const irradia::exr::Library* IRRADIA_EXR_SYMBOL() {
    static const irradia::exr::Library library{irradia::exr::encode};
    return &library;
}
