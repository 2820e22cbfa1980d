// The scene as a kernel sees it: the arrays of shared/scene_types.h behind one private struct, and the arguments
// that every kernel which traces rays begins with.
#ifndef IR_SCENE_H
#define IR_SCENE_H
#include "irradia/shared/scene_types.h"
#include "portable.h"

#ifdef IR_CPU  // the traversal a device runs: see trace.h
typedef Bvh8Node AccelNode;
typedef TriangleBlock AccelTriangle;
#else
typedef Bvh2Node AccelNode;
typedef TrianglePacked AccelTriangle;
#endif

typedef struct SceneData {
    IR_GLOBAL const AccelNode* nodes;
    IR_GLOBAL const AccelTriangle* leaves;
    IR_GLOBAL const Analytic* analytics;
    IR_GLOBAL const Triangle* triangles;
    IR_GLOBAL const Vertex* vertices;
    IR_GLOBAL const Material* materials;
    IR_GLOBAL const Texture* textures;
    IR_GLOBAL const uint* texels;
    IR_GLOBAL const Light* lights;
    IR_GLOBAL const SceneInfo* info;
} SceneData;

#define IR_SCENE_ARGS                                                                                               \
    IR_GLOBAL const AccelNode *nodes, IR_GLOBAL const AccelTriangle *leaves, IR_GLOBAL const Analytic *analytics,   \
        IR_GLOBAL const Triangle *triangles, IR_GLOBAL const Vertex *vertices, IR_GLOBAL const Material *materials, \
        IR_GLOBAL const Texture *textures, IR_GLOBAL const uint *texels, IR_GLOBAL const Light *lights,             \
        IR_GLOBAL const SceneInfo *info
#define IR_SCENE_INIT(s)     \
    SceneData s;             \
    s.nodes = nodes;         \
    s.leaves = leaves;       \
    s.analytics = analytics; \
    s.triangles = triangles; \
    s.vertices = vertices;   \
    s.materials = materials; \
    s.textures = textures;   \
    s.texels = texels;       \
    s.lights = lights;       \
    s.info = info
#endif
