// Sizes of the tables of what is seen of an environment picture (cl/sky_view.h); see scene_types.h for the rules.
#ifndef IRRADIA_SHARED_SKY_TYPES_H
#define IRRADIA_SHARED_SKY_TYPES_H

#define IR_SKY_COLUMNS 32u  // of tiles, around the picture
#define IR_SKY_ROWS 16u     // from pole to pole
#define IR_SKY_TILES (IR_SKY_COLUMNS * IR_SKY_ROWS)
#define IR_SKY_HEADER 8u       // words before the tables
#define IR_SKY_UNSEEN 0.125f   // share of light samples that take the whole picture
// Words of what a path tells: the key of the finest cell it left the scene from (0: it did not), the tile, its bounces.
#define IR_SKY_EVENT_WORDS 3u
#endif
