// Structs of the scene as it lies in device memory. Included by host C++ (namespace irradia::shared) and by the
// kernels, so: plain scalars only, explicit padding, no float3. tests/device echoes every sizeof from a kernel.
#ifndef IRRADIA_SHARED_SCENE_TYPES_H
#define IRRADIA_SHARED_SCENE_TYPES_H
#include "irradia/shared/align.h"

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
#include <cstdint>
namespace irradia::shared {
using uint = std::uint32_t;
#endif

// A primitive index: [0, triangle count) are triangles, then come the analytic primitives.
#define IR_NO_PRIMITIVE 0xffffffffu
#define IR_NO_LIGHT (-1)
#define IR_NO_TEXTURE (-1)

// ---- geometry ---------------------------------------------------------------------------------------------------
// Positions are world positions minus SceneInfo.centre (subtracted in double on the host), in world units.
typedef struct IR_ALIGNED_16 Vertex {
    float px, py, pz;  // position
    float nx, ny, nz;  // unit shading normal (unused if the triangle is flat)
    float u, v;        // texture coordinates
} Vertex;              // 32 bytes

#define IR_TRIANGLE_FLAT 0x1u    // shade with the geometric normal; vertex normals are not read
#define IR_TRIANGLE_HAS_UV 0x2u  // vertices carry texture coordinates (otherwise u, v are the barycentrics)
typedef struct IR_ALIGNED_16 Triangle {
    float nx, ny, nz;  // unit geometric normal; (v1-v0) x (v2-v0), turned by flip_normals
    uint flags;        // IR_TRIANGLE_*
    uint v0, v1, v2;   // vertex indices
    uint material;     // material index
    int light;         // index of the area light this triangle belongs to, or IR_NO_LIGHT
    float reach;        // largest |coordinate| of its vertices: the rounding of hits grows with it
    uint pad0, pad1;
} Triangle;  // 48 bytes

#define IR_ANALYTIC_SPHERE 0u
#define IR_ANALYTIC_DISK 1u
#define IR_ANALYTIC_CYLINDER 2u  // open at both ends
typedef struct IR_ALIGNED_16 Analytic {
    float px, py, pz;  // centre; cylinder: centre of the base
    float radius;      // sphere, cylinder; disk: unused
    float nx, ny, nz;  // disk: unit normal; cylinder: unit axis
    uint kind;         // IR_ANALYTIC_*
    float ux, uy, uz;  // disk: half axis u divided by its squared length; sphere, cylinder: unit x axis of its uv frame
    uint material;
    float vx, vy, vz;  // disk: half axis v divided by its squared length; sphere: unit z axis (pole) of its uv frame;
                       // cylinder: unit y axis of its uv frame
    int light;
    float sign;    // sphere, cylinder: +1 outward normals, -1 if flip_normals
    float length;  // cylinder
    float pad0, pad1;
} Analytic;  // 80 bytes

// ---- appearance -------------------------------------------------------------------------------------------------
// Names, parameters and conventions are those of Mitsuba 3's BSDFs.
#define IR_MATERIAL_DIFFUSE 0u
#define IR_MATERIAL_CONDUCTOR 1u  // smooth
#define IR_MATERIAL_ROUGH_CONDUCTOR 2u
#define IR_MATERIAL_DIELECTRIC 3u  // smooth
#define IR_MATERIAL_ROUGH_DIELECTRIC 4u
#define IR_MATERIAL_THIN_DIELECTRIC 5u
#define IR_MATERIAL_PLASTIC 6u  // smooth coat on a diffuse base
#define IR_MATERIAL_ROUGH_PLASTIC 7u
#define IR_MATERIAL_KINDS 8u

#define IR_MATERIAL_BECKMANN 0x1u    // flag: microfacets after Beckmann, otherwise GGX
#define IR_MATERIAL_NONLINEAR 0x2u   // flag: plastic whose base colours shift by internal scattering
#define IR_MATERIAL_NORMAL_MAP 0x4u  // flag: `map` holds normals, otherwise heights
#define IR_MATERIAL_MIRRORED_MAP 0x8u  // flag: seen from behind, heights rise towards that side (a map within twosided)
#define IR_NO_MATERIAL (-1)
#define IR_COAT_TABLE 64u  // entries of a rough coat's transmittance table, over the cosine, 0 to 1
typedef struct IR_ALIGNED_16 Material {
    uint kind, flags;  // IR_MATERIAL_*
    int back;          // material of the other side: its own index if both are alike, IR_NO_MATERIAL if that is black
    int texture;       // of the reflectance (replaces r, g, b) or IR_NO_TEXTURE
    float r, g, b;     // diffuse reflectance (diffuse, plastics), linear, [0, 1]
    float opacity;     // probability that a ray meets the surface at all, [0, 1]
    float specular_r, specular_g, specular_b;                 // factor of what is reflected specularly, [0, 1]
    int specular_texture;                                     // replaces it, or IR_NO_TEXTURE
    float transmittance_r, transmittance_g, transmittance_b;  // factor of what is transmitted (dielectrics), [0, 1]
    int opacity_texture;                                      // replaces opacity, or IR_NO_TEXTURE
    float eta_r, eta_g, eta_b;                                // conductors: real part of the index of refraction
    float eta;                   // dielectrics, plastics: index inside over index outside (the normal's side)
    float k_r, k_g, k_b;         // conductors: imaginary part
    float alpha_u, alpha_v;      // roughness along the tangent and the bitangent, > 0
    int alpha_texture;           // replaces both, or IR_NO_TEXTURE
    uint coat;                   // plastics: number of the coat, the same for coats that are alike; 0: none
    uint coat_table;             // rough plastics: where their IR_COAT_TABLE transmittances begin in `texels`
    float internal_reflectance;  // plastics: share of diffuse light that the coat reflects back to the base
    float specular_weight;       // plastics: weight of the coat against the base in the choice of a sample, [0, 1]
    int map;                     // bump map (heights) or normal map, or IR_NO_TEXTURE
    float map_scale;             // factor of the heights
} Material;                      // 128 bytes

#define IR_TEXTURE_RGBA8_SRGB 0u     // one uint a texel, sRGB transfer function, R in the low byte
#define IR_TEXTURE_RGBA8_LINEAR 1u   // one uint a texel, linear
#define IR_TEXTURE_RGB32F 2u         // three floats (as uint bits) a texel, linear
#define IR_TEXTURE_CHECKERBOARD 3u   // no texels: two colours of three floats at `offset`
#define IR_TEXTURE_VERTEX_COLOUR 4u  // no texels: three floats at `offset` + 3 vertex, interpolated
#define IR_WRAP_REPEAT 0u
#define IR_WRAP_MIRROR 1u
#define IR_WRAP_CLAMP 2u
#define IR_FILTER_BILINEAR 0u
#define IR_FILTER_NEAREST 1u
typedef struct IR_ALIGNED_16 Texture {
    uint offset;  // first uint in the texel array
    uint width, height;
    uint format;        // IR_TEXTURE_*
    uint wrap, filter;  // IR_WRAP_*, IR_FILTER_*
    uint pad0, pad1;
    float m00, m01, m02, pad2;  // uv' = M (u, v, 1)^T  (to_uv)
    float m10, m11, m12, pad3;
} Texture;  // 64 bytes

// ---- light ------------------------------------------------------------------------------------------------------
#define IR_LIGHT_QUAD 0u         // parallelogram p + a e1 + b e2, a, b in [0,1]
#define IR_LIGHT_TRIANGLE 1u     // p + a e1 + b e2, a + b <= 1
#define IR_LIGHT_SPHERE 2u       // centre p, radius
#define IR_LIGHT_DISK 3u         // centre p, half axes e1, e2
#define IR_LIGHT_POINT 4u        // position p, (r,g,b) intensity W·sr⁻¹
#define IR_LIGHT_DIRECTIONAL 5u  // n = direction in which the light travels, (r,g,b) irradiance W·m⁻²
#define IR_LIGHT_CONSTANT 6u     // environment of constant radiance (r,g,b) W·m⁻²·sr⁻¹
#define IR_LIGHT_SPOT \
    7u  // position p, direction n, (r,g,b) intensity on the axis W·sr⁻¹, e1x, e1y cosines of the
        // cone's half angle and of the half angle up to which intensity is full
#define IR_LIGHT_ENVMAP \
    8u                        // environment picture, latitude-longitude; (r,g,b) its mean radiance over the sphere, for
                              // the choice among lights; e1, e2, n: the map's x, y, z axes in the scene
#define IR_LIGHT_CYLINDER 9u  // base centre p, axis e1 (to the other end), radius; nx = +1 outward, -1 inward
typedef struct IR_ALIGNED_16 Light {
    float px, py, pz;
    uint kind;  // IR_LIGHT_*
    float e1x, e1y, e1z;
    float area;  // m²; 0 for point, directional, constant
    float e2x, e2y, e2z;
    float radius;
    float nx, ny,
        nz;  // unit emitting-side normal (area lights emit to this side only); sphere: nx = +1 outward, -1 inward
    float probability;  // of being chosen, proportional to power; all sum to 1
    float r, g, b;      // radiance W·m⁻²·sr⁻¹ (or as the kind says)
    float cdf;          // inclusive running sum of probability; the last is exactly 1
    int texture;        // area lights: radiance, which replaces r, g, b (they are its mean); envmap: its picture;
                        // otherwise IR_NO_TEXTURE
    uint primitive;     // textured area lights: the primitive that carries the texture coordinates
    uint table;         // envmap: where its sampling tables begin in `texels` (cl/environment.h)
    uint view;          // envmap: where the tables of what is seen of it begin there (cl/sky_view.h); 0: nothing is known
} Light;  // 96 bytes

// ---- camera, film, the rest -------------------------------------------------------------------------------------
// Ray through film position (x, y) in [0,1]^2, y down: direction = normalize(corner + x dx + y dy).
typedef struct Camera {
    float ox, oy, oz;  // origin
    float near_clip;   // along the view axis, world units
    float cornerx, cornery, cornerz;
    float far_clip;
    float dxx, dxy, dxz;
    float pixel_size;  // edge of a pixel on the plane at unit view depth (geometric mean of both edges)
    float dyx, dyy, dyz;
    float aperture_radius;               // thin lens, world units; 0: pinhole
    float forwardx, forwardy, forwardz;  // unit view axis
    float focus_distance;                // thin lens: depth of the plane in focus, world units
} Camera;                                // 80 bytes

#define IR_RFILTER_BOX 0u
#define IR_RFILTER_TENT 1u
#define IR_RFILTER_GAUSSIAN 2u
#define IR_FOV_AXIS_UNKNOWN 0u  // packed before it was kept
#define IR_FOV_AXIS_X 1u
#define IR_FOV_AXIS_Y 2u
#define IR_FOV_AXIS_DIAGONAL 3u
#define IR_FOV_AXIS_SMALLER 4u
#define IR_FOV_AXIS_LARGER 5u
typedef struct SceneInfo {
    Camera camera;
    uint width, height;    // pixels
    uint rfilter;          // IR_RFILTER_*
    float rfilter_radius;  // pixels (box .5; tent: radius; gaussian: 4 standard deviations, Mitsuba's)
    float rfilter_stddev;  // gaussian, pixels
    uint triangle_count, analytic_count, light_count;
    int environment_light;  // index of the constant or envmap light, or IR_NO_LIGHT
    float diagonal;         // of the bounding box of all surfaces, world units
    uint fov_axis;          // IR_FOV_AXIS_*: along which the scene file gives fields of view; kernels don't read it
    float pad1;
    float min_x, min_y, min_z, pad2;  // bounds after centring
    float max_x, max_y, max_z, pad3;
} SceneInfo;  // 160 bytes

// ---- acceleration structure -------------------------------------------------------------------------------------
// A child reference: inner node: its index. Leaf: IR_LEAF | kind | count << 24 | first, where
//   kind triangles: first = index of a TriangleBlock (8 wide, CPU) or of a TrianglePacked (GPU), count = how many
//   kind analytic:  first = index into Analytic, count = how many.   IR_EMPTY: no child.
#define IR_LEAF 0x80000000u
#define IR_LEAF_ANALYTIC 0x40000000u
#define IR_LEAF_COUNT(ref) (((ref) >> 24) & 0x3fu)
#define IR_LEAF_FIRST(ref) ((ref)&0x00ffffffu)
#define IR_EMPTY 0xffffffffu

// Depths that build_accel() guarantees (nodes on the longest way down): the traversal stacks are sized by them.
#define IR_BVH8_MAX_DEPTH 24
#define IR_BVH2_MAX_DEPTH 64

typedef struct IR_ALIGNED_16 Bvh8Node {  // CPU devices: eight children, boxes as structure of arrays; empty children are inverted
                           // boxes
    float lo_x[8], lo_y[8], lo_z[8], hi_x[8], hi_y[8], hi_z[8];
    uint child[8];  // children first, then IR_EMPTY
    uint count;     // how many children
    uint pad[7];
} Bvh8Node;  // 256 bytes

typedef struct IR_ALIGNED_16 TriangleBlock {  // CPU devices: eight triangles; unused slots are degenerate and never hit
    // Vertices rather than edges, so that neighbours see the very same end points and no ray leaks between them.
    float v0x[8], v0y[8], v0z[8], v1x[8], v1y[8], v1z[8], v2x[8], v2y[8], v2z[8];
    uint primitive[8];
} TriangleBlock;  // 320 bytes

typedef struct IR_ALIGNED_16 Bvh2Node {  // GPU devices: both children's boxes in one 64-byte node
    float lo0x, lo0y, lo0z;
    uint child0;
    float hi0x, hi0y, hi0z;
    uint child1;
    float lo1x, lo1y, lo1z;
    uint pad0;
    float hi1x, hi1y, hi1z;
    uint pad1;
} Bvh2Node;  // 64 bytes

typedef struct IR_ALIGNED_16 TrianglePacked {  // GPU devices: the three vertices
    float v0x, v0y, v0z;
    uint primitive;
    float v1x, v1y, v1z;
    uint pad0;
    float v2x, v2y, v2z;
    uint pad1;
} TrianglePacked;  // 48 bytes

// ---- what a scene needs: kernels are specialised by these (-D IR_FEATURES=...) -----------------------------------
#define IR_FEATURE_TEXTURES 0x1u           // any texture on a surface
#define IR_FEATURE_ANALYTIC 0x2u           // any sphere, disk or cylinder
#define IR_FEATURE_SMOOTH_NORMALS 0x4u     // any triangle that is not flat
#define IR_FEATURE_ENVIRONMENT 0x8u        // constant light or environment picture
#define IR_FEATURE_DELTA_LIGHTS 0x10u      // point, spot or directional light
#define IR_FEATURE_BSDFS 0x20u             // any material that is not diffuse
#define IR_FEATURE_MASKS 0x40u             // any opacity below one
#define IR_FEATURE_BUMPS 0x80u             // any bump or normal map
#define IR_FEATURE_ENVMAP 0x100u           // environment picture
#define IR_FEATURE_TEXTURED_LIGHTS 0x200u  // area light with a texture
#define IR_FEATURE_THIN_LENS 0x400u        // aperture of the camera

#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
static_assert(sizeof(Vertex) == 32 && sizeof(Triangle) == 48 && sizeof(Analytic) == 80 && sizeof(Material) == 128 &&
              sizeof(Texture) == 64 && sizeof(Light) == 96 && sizeof(Camera) == 80 && sizeof(SceneInfo) == 160 &&
              sizeof(Bvh8Node) == 256 && sizeof(TriangleBlock) == 320 && sizeof(Bvh2Node) == 64 &&
              sizeof(TrianglePacked) == 48);
}  // namespace irradia::shared
#endif
#endif
