// Counters that kernels add to while they run (cl/film.h) and the host collects: of rays by kind, and of requests.
// There is a set of them for every few groups of a launch: threads that all add to one word wait for each other.
#ifndef IRRADIA_SHARED_COUNTER_TYPES_H
#define IRRADIA_SHARED_COUNTER_TYPES_H

#define IR_RAYS_CAMERA 0u
#define IR_RAYS_HEMISPHERE 1u
#define IR_RAYS_BOUNCE 2u
#define IR_RAYS_SHADOW 3u
#define IR_REQUESTS 4u  // pixels of shade_pixels that want a record
#define IR_COUNTERS 5u  // 32 bits each

#define IR_COUNTER_SETS 64u
#define IR_COUNTER_STRIDE 16u  // words from one set to the next: a cache line
#ifndef IR_COUNTER_GROUPS
#define IR_COUNTER_GROUPS 16u  // groups in sequence that share a set
#endif
#endif
