// What the work-items of a group that share one task have in common: memory, and barriers between their steps. A group of
// one (IR_GROUP == 1), as on CPU devices, has that memory on its stack and waits for nobody: the kernel's body is then a
// function like any other, which is compiled once instead of three times (IR_ONCE_FN), and nobody's sums have to be added
// up. With 64 work-items, which a CPU core runs one after the other, a hemisphere takes 1.1 times as long.
#ifndef IR_GROUP_H
#define IR_GROUP_H
#include "portable.h"

#if IR_GROUP == 1
#define IR_GROUP_SPACE
#define IR_GROUP_ARRAY(type, name, size) type name[size]
#define IR_GROUP_BARRIER()
#define IR_GROUP_BARRIER_ALL()
#define IR_GROUP_FN IR_ONCE_FN
#else
#define IR_GROUP_SPACE IR_LOCAL
#define IR_GROUP_ARRAY(type, name, size) IR_LOCAL_ARRAY(type, name, size)
#define IR_GROUP_BARRIER() IR_BARRIER()
#define IR_GROUP_BARRIER_ALL() IR_BARRIER_ALL()
#define IR_GROUP_FN IR_INLINE_FN
#endif
#endif
