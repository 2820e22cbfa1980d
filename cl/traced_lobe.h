// Glossy light beside the records: lobes that are traced, because they are narrow or no record covers them. A ray that
// follows the lobe ends, where it can, in the irradiance cache: its records are better than the grid's cells.
#ifndef IR_TRACED_LOBE_H
#define IR_TRACED_LOBE_H
#include "indirect.h"
#include "radiance.h"

typedef struct Caches {
    const Cache* irradiance;
    const RadianceCache* radiance;
} Caches;

// As path_radiance, of a path whose last ray followed a lobe.
IR_FN real3 lobe_radiance(const SceneData* s, const Grid* grid, const Caches* caches, PathState path, uint edges, Rng* rng,
                          RayCount* rays) {
    const Surface* f = &path.surface;
    real3 e;
    // Records count paths of all lengths, or of those that begin at the camera.
    if (edges != 0xffffffffu || !is_diffuse(f) || !cache_lookup(caches->irradiance, f->p, f->ns, coat_of(f), &e))
        return path_radiance(s, grid, path, edges, true, rng, rays);
    real3 sum = path.throughput * f->albedo * e * IR_INV_PI;
    if (known_vertex(s, &path, false, rng, rays, &sum))
        sum += path_radiance(s, grid, path, edges, true, rng, rays);
    return sum;
}

// One sample of the radiance that f's lobe reflects of indirect light, for points that no record covers.
IR_FN real3 sampled_lobe(const SceneData* s, const Grid* grid, const Caches* caches, const Surface* f, uint edges, Rng* rng,
                         RayCount* rays) {
    PathState path = path_from(*f, 0.0f);
    real3 direct = black();  // known already
    if (!path_bounce(s, &path, true, false, rng, rays, &direct)) return black();
    return lobe_radiance(s, grid, caches, path, edges, rng, rays);
}
#endif
