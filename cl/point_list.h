// Points that want records, pushed by whatever work-item finds one: list[0].state is their number, then they follow in no
// order. The host (render/point_list.h) sorts them by pixel, so that what is made of them does not depend on it.
#ifndef IR_POINT_LIST_H
#define IR_POINT_LIST_H
#include "irradia/shared/record_types.h"
#include "portable.h"

IR_FN void push_point(IR_GLOBAL ShadingPoint* list, const ShadingPoint* q) {
    list[1u + IR_ATOMIC_ADD((volatile IR_GLOBAL uint*)&list[0].state, 1u)] = *q;
}
#endif
