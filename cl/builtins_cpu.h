// The built-in functions that cl/ uses, declared as OpenCL's own header (opencl-c.h) declares them, for `real` and the types
// of lanes and packets. The header declares 15 000 more, which take PoCL 0.1 s a program to read. Only where the host keeps
// the header away (-D IR_OWN_BUILTINS=1: src/device/compile_program.cpp). A built-in that is missing here is an error
// there, upon which the host compiles with the header; tests/app/test_compile_command.cpp sees that none is.
#ifndef IR_BUILTINS_CPU_H
#define IR_BUILTINS_CPU_H

#define IR_DECLARE __attribute__((overloadable))
#define IR_DECLARE_CONST __attribute__((overloadable, const))
#define IR_DECLARE_PURE __attribute__((overloadable, pure))

#define IR_BUILTIN_1(f, type) type IR_DECLARE_CONST f(type);
#define IR_BUILTIN_2(f, type) type IR_DECLARE_CONST f(type, type);
#define IR_BUILTIN_3(f, type) type IR_DECLARE_CONST f(type, type, type);
#ifdef cl_khr_fp64  // so that a double that slips in is one, as elsewhere
#define IR_DOUBLE_TYPE(declare, f) declare(f, double)
#else
#define IR_DOUBLE_TYPE(declare, f)
#endif
#define IR_FLOAT_TYPES(declare, f)                                                                                    \
    declare(f, float) declare(f, float2) declare(f, float3) declare(f, float4) declare(f, float8) declare(f, float16) \
        IR_DOUBLE_TYPE(declare, f)
#define IR_INTEGER_TYPES(declare, f) \
    declare(f, int) declare(f, uint) declare(f, long) declare(f, ulong) declare(f, int8) declare(f, uint8)

IR_FLOAT_TYPES(IR_BUILTIN_1, acos)
IR_FLOAT_TYPES(IR_BUILTIN_1, asin)
IR_FLOAT_TYPES(IR_BUILTIN_1, atan)
IR_FLOAT_TYPES(IR_BUILTIN_2, atan2)
IR_FLOAT_TYPES(IR_BUILTIN_1, cos)
IR_FLOAT_TYPES(IR_BUILTIN_1, erf)
IR_FLOAT_TYPES(IR_BUILTIN_1, erfc)
IR_FLOAT_TYPES(IR_BUILTIN_1, exp)
IR_FLOAT_TYPES(IR_BUILTIN_1, exp2)
IR_FLOAT_TYPES(IR_BUILTIN_1, fabs)
IR_FLOAT_TYPES(IR_BUILTIN_1, floor)
IR_FLOAT_TYPES(IR_BUILTIN_3, fma)
IR_FLOAT_TYPES(IR_BUILTIN_1, log)
IR_FLOAT_TYPES(IR_BUILTIN_1, log2)
IR_FLOAT_TYPES(IR_BUILTIN_2, pow)
IR_FLOAT_TYPES(IR_BUILTIN_1, rsqrt)
IR_FLOAT_TYPES(IR_BUILTIN_1, sin)
IR_FLOAT_TYPES(IR_BUILTIN_1, sqrt)
IR_FLOAT_TYPES(IR_BUILTIN_1, tan)
IR_BUILTIN_1(native_cos, float)
IR_BUILTIN_1(native_cos, float8)
IR_BUILTIN_1(native_sin, float)
IR_BUILTIN_1(native_sin, float8)

IR_FLOAT_TYPES(IR_BUILTIN_2, max)
IR_FLOAT_TYPES(IR_BUILTIN_2, min)
IR_FLOAT_TYPES(IR_BUILTIN_3, clamp)
IR_INTEGER_TYPES(IR_BUILTIN_2, max)
IR_INTEGER_TYPES(IR_BUILTIN_2, min)
IR_INTEGER_TYPES(IR_BUILTIN_3, clamp)
IR_INTEGER_TYPES(IR_BUILTIN_1, popcount)
#define IR_BUILTIN_BY_NUMBER(type)          \
    type IR_DECLARE_CONST max(type, float); \
    type IR_DECLARE_CONST min(type, float); \
    type IR_DECLARE_CONST clamp(type, float, float);
IR_BUILTIN_BY_NUMBER(float3)
IR_BUILTIN_BY_NUMBER(float8)
IR_BUILTIN_BY_NUMBER(float16)

float IR_DECLARE_CONST dot(float, float);
float IR_DECLARE_CONST dot(float3, float3);
float3 IR_DECLARE_CONST cross(float3, float3);
float IR_DECLARE_CONST length(float);
float IR_DECLARE_CONST length(float3);
float IR_DECLARE_CONST normalize(float);
float3 IR_DECLARE_CONST normalize(float3);

#define IR_BUILTIN_SELECT(type, test) type IR_DECLARE_CONST select(type, type, test);
IR_BUILTIN_SELECT(float, int)
IR_BUILTIN_SELECT(float, uint)
IR_BUILTIN_SELECT(int, int)
IR_BUILTIN_SELECT(int, uint)
IR_BUILTIN_SELECT(uint, int)
IR_BUILTIN_SELECT(uint, uint)
IR_BUILTIN_SELECT(float4, int4)
IR_BUILTIN_SELECT(float8, int8)
IR_BUILTIN_SELECT(float8, uint8)
IR_BUILTIN_SELECT(float16, int16)
IR_BUILTIN_SELECT(float16, uint16)
IR_BUILTIN_SELECT(uint16, int16)
IR_BUILTIN_SELECT(uint16, uint16)
IR_BUILTIN_SELECT(int8, int8)
IR_BUILTIN_SELECT(int16, int16)
int IR_DECLARE_CONST all(int);
int IR_DECLARE_CONST all(int8);
int IR_DECLARE_CONST all(int16);
int IR_DECLARE_CONST any(int);
int IR_DECLARE_CONST any(int8);
int IR_DECLARE_CONST any(int16);
char8 IR_DECLARE_CONST convert_char8(int8);
char16 IR_DECLARE_CONST convert_char16(int16);
float8 IR_DECLARE_CONST convert_float8(int8);

#define IR_BUILTIN_LOAD(n, type)                                      \
    type##n IR_DECLARE_PURE vload##n(size_t, const __global type*);   \
    type##n IR_DECLARE_PURE vload##n(size_t, const __constant type*); \
    type##n IR_DECLARE_PURE vload##n(size_t, const __local type*);    \
    type##n IR_DECLARE_PURE vload##n(size_t, const __private type*);  \
    void IR_DECLARE vstore##n(type##n, size_t, __global type*);       \
    void IR_DECLARE vstore##n(type##n, size_t, __local type*);        \
    void IR_DECLARE vstore##n(type##n, size_t, __private type*);
IR_BUILTIN_LOAD(4, float)
IR_BUILTIN_LOAD(8, float)
IR_BUILTIN_LOAD(16, float)
IR_BUILTIN_LOAD(4, uint)
IR_BUILTIN_LOAD(8, uint)
IR_BUILTIN_LOAD(16, uint)
IR_BUILTIN_LOAD(8, int)
IR_BUILTIN_LOAD(16, int)

#define IR_BUILTIN_ATOMIC(f)                              \
    int IR_DECLARE f(volatile __global int* p, int v);    \
    uint IR_DECLARE f(volatile __global uint* p, uint v); \
    int IR_DECLARE f(volatile __local int* p, int v);     \
    uint IR_DECLARE f(volatile __local uint* p, uint v);
IR_BUILTIN_ATOMIC(atomic_add)
IR_BUILTIN_ATOMIC(atomic_max)
IR_BUILTIN_ATOMIC(atomic_min)
IR_BUILTIN_ATOMIC(atomic_or)
int IR_DECLARE atomic_cmpxchg(volatile __global int* p, int expected, int v);
uint IR_DECLARE atomic_cmpxchg(volatile __global uint* p, uint expected, uint v);
int IR_DECLARE atomic_cmpxchg(volatile __local int* p, int expected, int v);
uint IR_DECLARE atomic_cmpxchg(volatile __local uint* p, uint expected, uint v);

size_t IR_DECLARE_CONST get_global_id(uint dimension);
size_t IR_DECLARE_CONST get_global_offset(uint dimension);
size_t IR_DECLARE_CONST get_group_id(uint dimension);
size_t IR_DECLARE_CONST get_local_id(uint dimension);
size_t IR_DECLARE_CONST get_local_size(uint dimension);
void __attribute__((overloadable, convergent)) barrier(cl_mem_fence_flags flags);
void IR_DECLARE mem_fence(cl_mem_fence_flags flags);
#endif
