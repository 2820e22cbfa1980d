#include "damaged_files.h"

#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace irradia::test {
namespace {

const float kVertices[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1.5f}};
const std::uint32_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

template <class T>
void put(std::string& out, T value, bool big = false) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big == (std::endian::native == std::endian::little)) std::reverse(bytes, bytes + sizeof(T));
    out.append(bytes, sizeof(T));
}

std::string ply_header(const std::string& format, const std::string& faces) {
    std::string out = "ply\nformat " + format + " 1.0\ncomment a tetrahedron\nelement vertex 4\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "u", "v"})
        out += std::string("property float ") + name + "\n";
    for (const char* name : {"red", "green", "blue"}) out += std::string("property uchar ") + name + "\n";
    return out + "element face 4\n" + faces + "end_header\n";
}

std::string ply_binary(bool big, bool more) {
    std::string out = ply_header(big ? "binary_big_endian" : "binary_little_endian",
                                 std::string("property list uchar int vertex_indices\n") +
                                     (more ? "property list ushort double weights\nproperty short mark\n" : ""));
    for (const auto& v : kVertices) {
        for (const float x : v) put(out, x, big);
        for (const float x : {0.0f, 0.6f, 0.8f, 0.25f, 0.75f}) put(out, x, big);
        out += "\x10\x80\xff";
    }
    for (const auto& f : kFaces) {
        out += '\x03';
        for (const std::uint32_t i : f) put(out, i, big);
        if (!more) continue;
        put(out, std::uint16_t{2}, big);
        put(out, 1.5, big);
        put(out, 2.5, big);
        put(out, std::int16_t{-1}, big);
    }
    return out;
}

std::string ply_ascii() {
    std::string out = ply_header("ascii", "property list uchar int vertex_indices\n");
    for (const auto& v : kVertices) {
        for (const float x : v) out += std::to_string(x) + " ";
        out += "0 0.6 0.8 0.25 0.75 16 128 255\n";
    }
    return out + "3 0 2 1\n3 0 1 3\n4 0 3 2 1\n3 1 2 3\n";
}

const char* const kObj = R"(# a tetrahedron
mtllib none.mtl
o thing
v 0 0 0 0.1 0.2 0.3
v 2.0 0 0 .4 .5 .6
v 0 1e0 0 1 1 1
v 0 0 +1.5 0 0 1
vt 0 0
vt 1 0 0
vt .5 1
vn 0 0 -1
vn 0.57735 0.57735 0.57735
usemtl a
f 1/1/1 3/3/1 2/2/1
f 1/1 2/2 4/3
f 1//1 -1//2 3//2
f 2 3 4 \
 1
)";

/// Of a .serialized file: the uncompressed mesh.
std::string mesh_body(int version, bool doubles) {
    std::string out;
    put(out, std::uint32_t{(doubles ? 0x2000u : 0x1000u) | 0x1u | 0x2u | 0x8u});
    if (version == 4) out += std::string("name\0", 5);
    put(out, std::uint64_t{4});
    put(out, std::uint64_t{4});
    const auto number = [&](float x) { doubles ? put(out, static_cast<double>(x)) : put(out, x); };
    for (const auto& v : kVertices)
        for (const float x : v) number(x);
    for (int i = 0; i < 4; ++i)
        for (const float x : {0.0f, 0.6f, 0.8f}) number(x);
    for (int i = 0; i < 4; ++i)
        for (const float x : {0.25f, 0.75f}) number(x);
    for (int i = 0; i < 4; ++i)
        for (const float x : {0.1f, 0.2f, 0.3f}) number(x);
    for (const auto& f : kFaces)
        for (const std::uint32_t i : f) put(out, i);
    return out;
}

/// A file of two meshes.
std::string serialized(int version, const std::string& first, const std::string& second) {
    std::string out;
    std::vector<std::size_t> begins;
    for (const std::string& body : {first, second}) {
        begins.push_back(out.size());
        put(out, std::uint16_t{0x041c});
        put(out, static_cast<std::uint16_t>(version));
        std::vector<Bytef> packed(compressBound(body.size()));
        uLongf size = packed.size();
        compress(packed.data(), &size, reinterpret_cast<const Bytef*>(body.data()), body.size());
        out.append(reinterpret_cast<const char*>(packed.data()), size);
    }
    for (const std::size_t begin : begins)
        version == 4 ? put(out, std::uint64_t{begin}) : put(out, static_cast<std::uint32_t>(begin));
    put(out, std::uint32_t{2});
    return out;
}

std::string picture(const std::string& path, OIIO::TypeDesc type, int channels, const char* compression, int tile) {
    constexpr int kSize = 20;
    OIIO::ImageSpec spec(kSize, kSize, channels, type);
    if (*compression) spec.attribute("compression", compression);
    spec.tile_width = spec.tile_height = tile;
    std::vector<float> pixels(static_cast<std::size_t>(kSize * kSize * channels));
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i * 7 % 31) / 31;
    auto out = OIIO::ImageOutput::create(path);
    if (!out || !out->open(path, spec) || !out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) || !out->close())
        throw std::runtime_error(path + " cannot be written");
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// A PNG file, one of its chunks changed, with a checksum that says it is right.
std::string png_with(const std::string& file, std::size_t which, const std::function<void(std::string&)>& change) {
    const auto number = [&](std::size_t at) {
        std::uint32_t n = 0;
        for (std::size_t k = 0; k < 4; ++k) n = n << 8 | static_cast<unsigned char>(file.at(at + k));
        return n;
    };
    std::vector<std::string> chunks;  // type and data
    for (std::size_t at = 8; at < file.size(); at += 12 + number(at))
        chunks.push_back(file.substr(at + 4, 4 + number(at)));
    std::string& chosen = chunks[which % chunks.size()];
    std::string data = chosen.substr(4);
    change(data);
    chosen.replace(4, std::string::npos, data);
    std::string out = file.substr(0, 8);
    for (const std::string& chunk : chunks) {
        put(out, static_cast<std::uint32_t>(chunk.size() - 4), true);
        out += chunk;
        put(out,
            static_cast<std::uint32_t>(
                crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(chunk.size()))),
            true);
    }
    return out;
}

}  // namespace

std::vector<Sample> samples(const std::string& folder) {
    const auto shape = [](const std::string& type, const std::string& more = "") {
        return "<shape type=\"" + type + "\"><string name=\"filename\" value=\"$FILE\"/>" + more + "</shape>";
    };
    std::vector<Sample> all{{"ascii.ply", shape("ply"), ply_ascii()},
                            {"little.ply", shape("ply"), ply_binary(false, false)},
                            {"big.ply", shape("ply"), ply_binary(true, false)},
                            {"more.ply", shape("ply"), ply_binary(false, true)},
                            {"mesh.obj", shape("obj"), kObj}};
    for (const int version : {3, 4}) {
        const std::string body = mesh_body(version, version == 3), other = mesh_body(version, version == 4);
        all.push_back({"v" + std::to_string(version) + ".serialized",
                       shape("serialized", "<integer name=\"shape_index\" value=\"1\"/>"),
                       serialized(version, body, other), [=](const std::function<void(std::string&)>& change) {
                           std::string second = other;
                           change(second);
                           return serialized(version, body, second);
                       }});
    }
    const std::string texture =
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"bitmap\">"
        "<string name=\"filename\" value=\"$FILE\"/></texture></bsdf></shape>";
    const auto add = [&](const std::string& name, OIIO::TypeDesc type, int channels, const char* compression = "",
                         int tile = 0) {
        all.push_back({name, texture, picture(folder + "/" + name, type, channels, compression, tile)});
        if (!name.ends_with(".png")) return;
        all.back().inside = [file = all.back().bytes](const std::function<void(std::string&)>& change) {
            std::string number(16, 'x');  // damaged too, it chooses the chunk
            change(number);
            return png_with(file, std::hash<std::string>{}(number), change);
        };
    };
    add("grey.png", OIIO::TypeDesc::UINT8, 1);
    add("rgba16.png", OIIO::TypeDesc::UINT16, 4);
    add("rgb.jpg", OIIO::TypeDesc::UINT8, 3);
    add("zip.exr", OIIO::TypeDesc::HALF, 3, "zip");
    add("piz.exr", OIIO::TypeDesc::FLOAT, 3, "piz");
    add("tiled.exr", OIIO::TypeDesc::HALF, 4, "zips", 16);
    add("rgb.hdr", OIIO::TypeDesc::FLOAT, 3);
    return all;
}

void damage(std::string& bytes, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
    const auto flip = [&] {
        if (!bytes.empty()) bytes[below(bytes.size())] ^= static_cast<char>(1 << below(8));
    };
    switch (below(6)) {
        case 0:
            bytes.resize(below(bytes.size()));
            return;
        case 1:
            flip();
            return;
        case 2:
            for (std::size_t i = 0, n = 2 + below(30); i < n; ++i) flip();
            return;
        case 3: {  // a number of 1, 2, 4 or 8 bytes: a size, an offset, an index
            const std::uint64_t values[] = {0,
                                            1,
                                            0x7f,
                                            0x80,
                                            0xff,
                                            0x7fff,
                                            0xffff,
                                            0x7fffffff,
                                            0x80000000,
                                            0xffffffff,
                                            ~std::uint64_t{0} >> 1,
                                            ~std::uint64_t{0},
                                            0x7fc00000,
                                            0x0101010101010101};
            std::string number;
            put(number, values[below(std::size(values))], below(2) == 1);
            const std::size_t at = below(bytes.size());
            bytes.replace(at, std::min(bytes.size() - at, std::size_t{1} << below(4)), number, below(2) ? 0 : 4,
                          std::size_t{1} << below(4));
            return;
        }
        case 4: {  // a word of a text, or whatever stands there
            static const char* const words[] = {"-1",
                                                "0",
                                                "1e999",
                                                "-1e-999",
                                                "nan",
                                                "inf",
                                                "4294967295",
                                                "4294967296",
                                                "99999999999999999999",
                                                "",
                                                "\n",
                                                "/",
                                                "//",
                                                "#",
                                                "\\",
                                                "\\\n",
                                                "f 1 2",
                                                "v",
                                                "3 0 1",
                                                "property list int int x\n",
                                                "element a 9999999999999\n"};
            const std::size_t from = bytes.find_first_not_of(" \n", below(bytes.size()));
            const std::size_t to = std::min(bytes.find_first_of(" \n/", from), bytes.size());
            if (from < to) bytes.replace(from, std::min<std::size_t>(to - from, 12), words[below(std::size(words))]);
            return;
        }
        default: {  // a piece removed, or put in once more
            const std::size_t at = below(bytes.size()), size = 1 + below(40), to = below(bytes.size());
            const std::string piece = bytes.substr(at, size);
            if (below(2))
                bytes.erase(at, size);
            else
                bytes.insert(to, piece);
        }
    }
}

}  // namespace irradia::test
