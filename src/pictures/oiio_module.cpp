// The module: the only code that is linked with OpenImageIO.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "pictures/oiio.h"

namespace irradia::oiio {
namespace {

/// OpenImageIO's messages can have several lines.
std::string one_line(std::string text) {
    for (char& c : text)
        if (c == '\n') c = ' ';
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

class OpenFile final : public Input {
public:
    explicit OpenFile(std::unique_ptr<OIIO::ImageInput> file) : file_(std::move(file)) {
        const OIIO::ImageSpec& spec = file_->spec();
        width = spec.width;
        height = spec.height;
        depth = spec.depth;
        for (int c = 0; c < spec.nchannels; ++c) channels.push_back(spec.channel_name(c));
        values = spec.format == OIIO::TypeDesc::UINT8 ? Values::bytes
                 : spec.format.is_floating_point()    ? Values::floats
                                                      : Values::integers;
        srgb = spec.get_string_attribute("oiio:ColorSpace") == "sRGB";
        for (const OIIO::ParamValue& attribute : spec.extra_attribs)
            metadata[attribute.name().string()] = attribute.get_string();
    }
    std::string read(float* data) override { return read(OIIO::TypeDesc::FLOAT, data); }
    std::string read(std::uint8_t* data) override { return read(OIIO::TypeDesc::UINT8, data); }

private:
    std::unique_ptr<OIIO::ImageInput> file_;
    std::string read(OIIO::TypeDesc type, void* data) {
        if (file_->read_image(0, 0, 0, static_cast<int>(channels.size()), type, data)) return "";
        const std::string why = one_line(file_->geterror());
        return why.empty() ? "OpenImageIO does not say why" : why;
    }
};

std::unique_ptr<Input> open(const std::string& path, bool unassociated, std::string& why) {
    OIIO::ImageSpec config;
    if (unassociated) config["oiio:UnassociatedAlpha"] = 1;
    std::unique_ptr<OIIO::ImageInput> file = OIIO::ImageInput::open(path, unassociated ? &config : nullptr);
    if (file) return std::make_unique<OpenFile>(std::move(file));
    why = one_line(OIIO::geterror());
    return nullptr;
}

std::string encode(const Png& picture, std::vector<unsigned char>& file) {
    const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create("png");
    if (!out) return fmt::format("OpenImageIO cannot write png: {}", one_line(OIIO::geterror()));
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("Software", "Irradia");
    spec.attribute("DateTime", "");  // else OpenImageIO puts the clock's
    for (const auto& [key, value] : picture.attributes) spec.attribute(key, value);
    OIIO::Filesystem::IOVecOutput memory(file);
    out->set_ioproxy(&memory);
    const bool written = out->open(picture.path, spec) && out->write_image(OIIO::TypeDesc::UINT8, picture.rgb);
    const bool closed = out->close();
    return written && closed ? "" : fmt::format("cannot be written: {}", one_line(out->geterror()));
}

std::string colour_map(const char* name, int width, int height, const float* values, float* rgb) {
    const OIIO::ImageBuf source(OIIO::ImageSpec(width, height, 1, OIIO::TypeDesc::FLOAT), const_cast<float*>(values));
    OIIO::ImageBuf colours = OIIO::ImageBufAlgo::color_map(source, 0, name);
    if (!colours.has_error() && colours.get_pixels(OIIO::ROI::All(), OIIO::TypeDesc::FLOAT, rgb)) return "";
    return one_line(colours.geterror());
}

}  // namespace
}  // namespace irradia::oiio

extern "C" [[gnu::visibility("default")]] const irradia::oiio::Library* IRRADIA_OIIO_SYMBOL() {
    static const irradia::oiio::Library library{irradia::oiio::open, irradia::oiio::encode, irradia::oiio::colour_map};
    return &library;
}
