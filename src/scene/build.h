// What the parts of the loader hand to each other: world space, double precision; load_scene.cpp rounds at the end.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "camera/lens.h"
#include "irradia/Scene.h"
#include "scene/properties.h"

namespace irradia::loader {

// ---- meshes -----------------------------------------------------------------------------------------------------
struct Mesh {
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;  // as many as positions, or none
    std::vector<glm::dvec2> uvs;      // as many as positions, or none
    std::vector<glm::vec3> colours;   // as many as positions, or none; linear
    std::vector<std::array<std::uint32_t, 3>> triangles;
};
/// A whole file. Throws Error if it cannot be read or is empty.
std::string read_file(const std::string& path);
/// Reads a mesh file as it stands (no transform, v not flipped), its vertex colours if asked for. Throws Error
/// "file: ..." without the scene's line.
Mesh read_ply(const std::string& path, bool colours);
Mesh read_obj(const std::string& path, bool colours);
/// Mesh number `index`, from 0 on, of a file of several.
Mesh read_serialized(const std::string& path, long long index, bool colours);
struct MeshFile {
    std::string type, path;  // type: obj, ply, serialized
    long long index = 0;     // of the mesh within a serialized file
};
/// By the file's type, checked.
Mesh read_mesh(const MeshFile& file, bool colours);
/// Every position, normal and texture coordinate finite, every index in range, at least one triangle. Throws Error.
void check_mesh(const std::string& path, const Mesh& mesh);
/// Angle-weighted vertex normals (Thuermer and Wuethrich), as Mitsuba computes them where a file has none.
/// Only vertices whose normal is zero are filled; `mesh.normals` is sized if it was empty.
void fill_normals(Mesh& mesh);

// ---- materials and textures -------------------------------------------------------------------------------------
struct TextureSpec {
    std::string path;
    bool raw = false;
    bool unbounded = false;       // radiance, heights: values are not held in [0, 1]
    bool vertex_colours = false;  // no file: the meshes' own colours, Texture::format IR_TEXTURE_VERTEX_COLOUR
    bool checkerboard = false;    // no file: colours[0] and colours[1]
    std::array<glm::dvec3, 2> colours{};
    std::uint32_t wrap = IR_WRAP_REPEAT, filter = IR_FILTER_BILINEAR;
    glm::dmat4 to_uv{1.0};
    const Node* node = nullptr;
};
/// Bitmaps of a scene, each file and setting once; read in parallel at the end.
class TextureTable {
public:
    int add(const TextureSpec& spec);
    [[nodiscard]] const TextureSpec& spec(int texture) const { return specs_[static_cast<std::size_t>(texture)]; }
    /// Does any of them read vertex colours?
    [[nodiscard]] bool vertex_colours() const {
        return std::any_of(specs_.begin(), specs_.end(), [](const TextureSpec& s) { return s.vertex_colours; });
    }
    /// Reads all, appends to scene.textures and scene.texels.
    void load(const Context& context, Scene& scene) const;

private:
    std::vector<TextureSpec> specs_;
};
/// A picture file as three channels a texel, rows from the top; either 8 bit or float.
struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> bytes;
    std::vector<float> floats;
};
/// Reads it, unless options.parts has it. Throws Error without the scene's line.
std::shared_ptr<const Picture> picture_of(const Context& context, const std::string& path, bool raw);
/// Mean linear colour of a picture file, each row weighted by `row_weight(y in (0,1))`; for substitutes.
glm::dvec3 mean_colour(const Context& context, const Node& node, const std::string& path, bool raw,
                       double (*row_weight)(double));

/// The mean of a loaded texture as Mitsuba takes it: of a picture's luminance, of all channels of a checkerboard.
double mean_of_texture(const Scene& scene, const shared::Texture& texture);

/// What the elements of a <texture> say. Throws Error on what is not supported.
TextureSpec read_texture(const Context& context, const Document& document, const Node& node);

/// Index of refraction of a named conductor, linear Rec. 709, or of a dielectric; false if there is none of that name.
bool find_conductor(const std::string& name, glm::dvec3& eta, glm::dvec3& k);
bool find_dielectric(const std::string& name, double& ior);
std::vector<std::string> conductor_names();
std::vector<std::string> dielectric_names();

/// A rough plastic's coat: transmittances of IR_COAT_TABLE cosines from 0 (1e-6) to 1, and the share of diffuse light
/// from inside that it reflects. Single scattering by the facets of Mitsuba's model, as its roughplastic has it.
struct RoughCoat {
    std::vector<float> transmittance;
    double internal_reflectance = 0.0;
};
RoughCoat rough_coat(double eta, double alpha, bool beckmann);
/// That share for a smooth coat of relative index `eta` > 1.
double smooth_internal_reflectance(double eta);

class MaterialTable {
public:
    MaterialTable(const Context& context, const Document& document, TextureTable& textures)
        : context_(context), document_(document), textures_(textures) {}
    /// Index of the material of a <bsdf>; the same element always gives the same index. Null: Mitsuba's default,
    /// diffuse .5, or black for the shape of an emitter.
    std::uint32_t material(const Node* bsdf, bool emitter = false);
    /// Appends the coats' tables to scene.texels and tells the materials where they are; sets what depends on the
    /// means of textures.
    void store_coats(Scene& scene);
    std::vector<shared::Material> materials;

private:
    enum class TextureUse { colour, number, map };
    struct Colour {
        glm::dvec3 value;
        int texture;
    };
    struct Coat {
        std::uint32_t kind;
        bool beckmann;
        float eta, alpha;
        RoughCoat table;
    };
    std::uint32_t append(shared::Material m);
    shared::Material read(const Node& bsdf, int depth);
    shared::Material twosided(Properties& p, int depth);
    shared::Material mask(Properties& p, int depth);
    shared::Material perturbed(Properties& p, int depth);
    shared::Material substitute(const Node& bsdf, int depth);
    const Node& only_nested(Properties& p);
    void conductor(Properties& p, shared::Material& m);
    void dielectric(Properties& p, shared::Material& m);
    void plastic(Properties& p, shared::Material& m);
    void set_diffuse(Properties& p, const std::string& name, shared::Material& m);
    void set_specular(Properties& p, shared::Material& m);
    void set_roughness(Properties& p, bool anisotropic, shared::Material& m);
    void set_index(Properties& p, const char* inside, shared::Material& m);
    void set_coat(shared::Material& m);
    double index_of_refraction(Properties& p, const char* name, const char* fallback);
    Colour colour(Properties& p, const std::string& name, const glm::dvec3& fallback,
                  TextureUse use = TextureUse::colour);
    int texture(const Node& node, TextureUse use);

    const Context& context_;
    const Document& document_;
    TextureTable& textures_;
    std::vector<Coat> coats_;
    std::unordered_map<const Node*, std::uint32_t> known_;
    std::optional<std::uint32_t> default_, default_of_emitters_;
};

// ---- shapes -----------------------------------------------------------------------------------------------------
enum class ShapeKind { mesh, rectangle, sphere, disk, cylinder };
/// Spheres, disks and cylinders: traced as they are, without triangles.
inline bool is_analytic(ShapeKind kind) { return kind >= ShapeKind::sphere; }
/// A shape in world space.
struct Shape {
    const Node* node = nullptr;
    ShapeKind kind = ShapeKind::mesh;
    std::uint32_t material = 0;
    std::optional<glm::dvec3> radiance;    // area emitter, W·m⁻²·sr⁻¹; of a texture its mean
    int radiance_texture = IR_NO_TEXTURE;  // replaces it, if there is one

    Mesh mesh;                            // mesh, rectangle (4 corners in order, 2 triangles)
    bool flat = false;                    // mesh.normals are not to be used
    glm::dvec3 centre{0.0};               // sphere, disk; cylinder: of its base
    glm::dvec3 axis_u{0.0}, axis_v{0.0};  // disk: half axes; unit axes of the uv frame: sphere x, z, cylinder x, y
    glm::dvec3 normal{0.0};               // disk; cylinder: unit axis
    double radius = 0.0;                  // sphere, cylinder
    double length = 0.0;                  // cylinder
    double sign = 1.0;                    // -1: all but disks look to the other side; mesh.normals do so already

    /// Unit normal of a triangle, on the side the surface faces: where the vertex normals point, as in Mitsuba, whose
    /// frames and emitters follow the shading normal; without them where the corners run counter-clockwise.
    [[nodiscard]] glm::dvec3 face_normal(std::size_t triangle) const;
};
/// Every shape of the scene in file order, meshes read in parallel.
std::vector<Shape> read_shapes(const Context& context, const Document& document, MaterialTable& materials,
                               const TextureTable& textures);
/// Puts the vertex colours into scene.texels, three floats a vertex in the order of `shapes`, and says to the textures
/// of format IR_TEXTURE_VERTEX_COLOUR where they begin. Shapes without colours whose material asks for them: Error.
void add_vertex_colours(const std::vector<Shape>& shapes, const std::vector<shared::Material>& materials,
                        const TextureTable& textures, Scene& scene);

// ---- lights and camera ------------------------------------------------------------------------------------------
/// An environment picture: linear radiance times scale, three floats a texel; cl/environment.h says which direction
/// lies where.
struct EnvironmentMap {
    std::uint32_t width = 0, height = 0;  // at least 1 x 2
    std::vector<float> texels;
    std::vector<std::uint32_t> tables;  // that kernels sample it by
    glm::dvec3 mean{0.0};               // radiance over the sphere
    std::size_t negative = 0;           // how many values of the file were and are 0 now
};
/// Reads it, unless options.parts has it.
std::shared_ptr<const EnvironmentMap> read_environment(const Context& context, const Node& node,
                                                       const std::string& path, double scale);
/// Adds picture and sampling tables to the scene and points `light` to them. They take so many words of texels:
std::size_t environment_words(const EnvironmentMap& map);
void append_environment(const EnvironmentMap& map, Scene& scene, shared::Light& light);

/// A light that belongs to no shape, in world space.
struct FreeLight {
    std::uint32_t kind = IR_LIGHT_POINT;
    const Node* node = nullptr;
    glm::dvec3 position{0.0}, direction{0.0}, colour{0.0};  // colour: of a picture its mean
    double cutoff = 0.0, beam = 0.0;                        // spot: half angles of its cones, radians
    std::shared_ptr<const EnvironmentMap> map;
    glm::dmat3 axes{1.0};  // the map's unit x, y and z axis in the scene
};
/// The radiance of a shape's <emitter>, 1 if that is a bitmap; no value if it is to be ignored (lenient).
std::optional<glm::dvec3> read_area_emitter(const Context& context, const Document& document, const Node& emitter);
inline bool is_bitmap(const Node& node) { return node.tag == "texture" && node.get("type") == "bitmap"; }
/// Sets `radiance_texture` of shapes whose emitter's radiance is a bitmap.
void read_radiance_textures(const Context& context, const Document& document, TextureTable& textures,
                            std::vector<Shape>& shapes);
/// When textures are loaded: sets `radiance` of these shapes to the mean of the texels.
void set_mean_of_textures(const Scene& scene, std::vector<Shape>& shapes);
/// Sets r, g, b of textured area lights, which hold the texture's mean, to the mean over the light.
void set_mean_of_textured_lights(Scene& scene);
/// The top-level emitters.
std::vector<FreeLight> read_free_lights(const Context& context, const Document& document);
/// Sets probability and cdf by power; `radius` = the scene's bounding sphere, for lights from outside.
void set_selection_probabilities(std::vector<shared::Light>& lights, double radius);

struct Sensor : CameraFrame {
    const Node* node = nullptr;
};
/// Reads the sensor; sets film size, reconstruction filter and sample_count of `scene`.
Sensor read_sensor(const Context& context, const Document& document, Scene& scene);
/// Throws Error if the camera is inside a solid object, so that all it sees are back sides that reflect nothing, or so
/// near to a surface that near_clip cuts it away and nothing else is seen. A room, seen from its front sides, is fine.
void check_camera(const Sensor& camera, const std::vector<Shape>& shapes,
                  const std::vector<shared::Material>& materials, bool environment);

}  // namespace irradia::loader
