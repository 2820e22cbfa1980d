// One dialect for three compilers: OpenCL C 1.2, CUDA C++ (nvcc, NVRTC), and host C++ in double precision (tests).
// Everything else in cl/ uses only what is defined here: `real`, `real3`, make_real3, dot, cross, length, normalize,
// IR_FN, IR_GLOBAL, ... No vector literals, no swizzles, no built-in that one of the three lacks.
//
// IR_CALL_FN: functions large and often called, which GPU compilers would copy into every caller, for minutes; they stay
// functions there where a scene's materials make them large (-D IR_FEATURES). None may call another one: where they did,
// kernels left their memory on NVIDIA (driver 580.159, H100 and H200), once in a billion paths or at once (20 of 24 renders of
// a scene with glass); with calls one deep, and with none, no render of 40 did.
//
// IR_ONCE_FN: compiled once on CPU devices, not again at every call: PoCL puts a kernel three times into its object, with
// all that is inlined there. Compiling takes a third less so, running as long. On GPUs it is IR_FN: see path.h.
//
// Functions that take IR_LOCAL memory are IR_INLINE_FN, never IR_FN: where one stays a function of its own, LLVM puts
// the address of the kernel's array into it instead of the parameter, which PoCL 3.1 does not see when it moves the
// array: what the function writes is lost.
#ifndef IR_PORTABLE_H
#define IR_PORTABLE_H

#if defined(__OPENCL_VERSION__)  // ------------------------------------------------------------------ OpenCL C
#if defined(IR_OWN_BUILTINS)
#include "builtins_cpu.h"
#endif
#define IR_FN static
#define IR_INLINE_FN static __attribute__((always_inline))
#if !defined(IR_CPU) && (IR_FEATURES & 0x20u)  // IR_FEATURE_BSDFS
#define IR_CALL_FN static __attribute__((noinline))
#else
#define IR_CALL_FN static
#endif
#if defined(IR_CPU)
#define IR_ONCE_FN static __attribute__((noinline))
#else
#define IR_ONCE_FN IR_FN
#endif
#define IR_KERNEL __kernel
#define IR_GLOBAL __global
#define IR_LOCAL __local
#define IR_CONSTANT __constant
#define IR_LOCAL_ARRAY(type, name, size) __local type name[size]
#define IR_LOCAL_ID ((uint)get_local_id(0))
#define IR_LOCAL_SIZE ((uint)get_local_size(0))
#if defined(IR_SHARED_OUT)  // src/device/launch.h: groups lie along the third axis, from 1 on
#define IR_GROUP_ID ((uint)(get_group_id(2) + get_global_offset(2)) - 1u)
#define IR_GLOBAL_ID (IR_GROUP_ID * IR_LOCAL_SIZE + IR_LOCAL_ID)
#else
#define IR_GROUP_ID ((uint)get_group_id(0))
#define IR_GLOBAL_ID ((uint)get_global_id(0))
#endif
#define IR_BARRIER() barrier(CLK_LOCAL_MEM_FENCE)
#define IR_BARRIER_ALL() barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)  // what the group wrote anywhere
// What a work-item wrote before is seen by those of other groups that see what it writes after. NVIDIA's mem_fence holds
// for the own group only (membar.cta): of list entries others then saw the link, but not yet what lies there.
#ifdef __NV_CL_C_VERSION
#define IR_GLOBAL_FENCE() asm volatile("membar.gl;" ::: "memory")
#else
#define IR_GLOBAL_FENCE() mem_fence(CLK_GLOBAL_MEM_FENCE)
#endif
#if defined(IR_CPU) && defined(__clang__) && !defined(IR_NO_PREFETCH)  // oclgrind has no such instruction
#define IR_PREFETCH(p) __builtin_prefetch((const void*)(size_t)(p))  // OpenCL's own is nothing in PoCL
#define IR_PREFETCH_OWN(p) __builtin_prefetch((const void*)(size_t)(p), 1)  // to be written: no other core keeps it
#else
#define IR_PREFETCH(p)
#define IR_PREFETCH_OWN(p)
#endif
#define IR_AS_UINT(x) as_uint(x)
#define IR_AS_FLOAT(x) as_float(x)
#define IR_ATOMIC_ADD(p, v) atomic_add(p, v)
#define IR_ATOMIC_MIN(p, v) atomic_min(p, v)
#define IR_ATOMIC_MAX(p, v) atomic_max(p, v)
#define IR_ATOMIC_OR(p, v) atomic_or(p, v)
#define IR_ATOMIC_CAS(p, expected, v) atomic_cmpxchg(p, expected, v)
typedef float real;
typedef float3 real3;
#define make_real3(x, y, z) ((float3)((x), (y), (z)))
#define R(x) x##f  // a literal of type real
#define real_sincos(x, s, c)  \
    do {                      \
        *(s) = native_sin(x); \
        *(c) = native_cos(x); \
    } while (0)

#elif defined(__CUDACC__)  // -------------------------------------------------------------------------- CUDA C++
#include "irradia/shared/align.h"  // uint
typedef unsigned long ulong;  // as sys/types.h has it, which nvcc (not NVRTC) includes: 64 bits on Linux
#define IR_FN static __device__
#define IR_INLINE_FN static __device__ __forceinline__
#define IR_CALL_FN static __device__ __noinline__
#define IR_ONCE_FN IR_FN
#define IR_KERNEL extern "C" __global__
#define IR_GLOBAL
#define IR_LOCAL
#define IR_LOCAL_ARRAY(type, name, size) __shared__ type name[size]
#define IR_CONSTANT static __device__ const
#define IR_LOCAL_ID (threadIdx.x)
#define IR_LOCAL_SIZE (blockDim.x)
#define IR_GROUP_ID (blockIdx.x)
#define IR_GLOBAL_ID (blockIdx.x * blockDim.x + threadIdx.x)
#define IR_BARRIER() __syncthreads()
#define IR_BARRIER_ALL() __syncthreads()
#define IR_GLOBAL_FENCE() __threadfence()
#define IR_PREFETCH(p)
#define IR_PREFETCH_OWN(p)
#define IR_AS_UINT(x) __float_as_uint(x)
#define IR_AS_FLOAT(x) __uint_as_float(x)
#define IR_ATOMIC_ADD(p, v) atomicAdd((uint*)(p), v)
#define IR_ATOMIC_MIN(p, v) atomicMin((uint*)(p), v)
#define IR_ATOMIC_MAX(p, v) atomicMax((uint*)(p), v)
#define IR_ATOMIC_OR(p, v) atomicOr((uint*)(p), v)
#define IR_ATOMIC_CAS(p, expected, v) atomicCAS((uint*)(p), expected, v)
typedef float real;
typedef float3 real3;
#define make_real3(x, y, z) make_float3((x), (y), (z))
#define R(x) x##f
#define real_sincos(x, s, c) sincosf(x, s, c)

#else  // ------------------------------------------------------------------- host C++, double precision (tests)
#include <algorithm>
#include <cmath>
#include <cstdint>
#define IR_FN inline
#define IR_INLINE_FN inline
#define IR_CALL_FN inline
#define IR_ONCE_FN IR_FN
#define IR_GLOBAL
#define IR_LOCAL
#define IR_CONSTANT static const
// The including file opens `namespace X {` around its includes of cl/ headers after including this one.
namespace irradia::host {
using uint = std::uint32_t;
using real = double;
struct real3 {
    double x, y, z;
};
inline real3 make_real3(double x, double y, double z) { return {x, y, z}; }
using std::abs;
using std::acos;
using std::asin;
using std::atan2;
using std::cos;
using std::erf;
using std::erfc;
using std::exp;
using std::floor;
using std::isfinite;
using std::log;
using std::max;
using std::min;
using std::pow;
using std::sin;
using std::sqrt;
using std::tan;
inline real fabs(real x) { return std::fabs(x); }
inline real rsqrt(real x) { return 1.0 / std::sqrt(x); }
inline void real_sincos(real x, real* s, real* c) {
    *s = std::sin(x);
    *c = std::cos(x);
}
}  // namespace irradia::host
#define R(x) x
#endif

#if defined(__CUDACC__)
#define IR_VEC_FN static __device__ inline
#elif !defined(__OPENCL_VERSION__)
#define IR_VEC_FN inline
namespace irradia::host {
#endif
#if !defined(__OPENCL_VERSION__)
IR_VEC_FN real3 operator+(real3 a, real3 b) { return make_real3(a.x + b.x, a.y + b.y, a.z + b.z); }
IR_VEC_FN real3 operator-(real3 a, real3 b) { return make_real3(a.x - b.x, a.y - b.y, a.z - b.z); }
IR_VEC_FN real3 operator-(real3 a) { return make_real3(-a.x, -a.y, -a.z); }
IR_VEC_FN real3 operator*(real3 a, real3 b) { return make_real3(a.x * b.x, a.y * b.y, a.z * b.z); }
IR_VEC_FN real3 operator*(real3 a, real s) { return make_real3(a.x * s, a.y * s, a.z * s); }
IR_VEC_FN real3 operator*(real s, real3 a) { return make_real3(a.x * s, a.y * s, a.z * s); }
IR_VEC_FN real3& operator+=(real3& a, real3 b) { return a = a + b; }
IR_VEC_FN real3& operator-=(real3& a, real3 b) { return a = a - b; }
IR_VEC_FN real3& operator*=(real3& a, real3 b) { return a = a * b; }
IR_VEC_FN real3& operator*=(real3& a, real s) { return a = a * s; }
IR_VEC_FN real dot(real3 a, real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
IR_VEC_FN real3 cross(real3 a, real3 b) {
    return make_real3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
IR_VEC_FN real length(real3 a) { return sqrt(dot(a, a)); }
IR_VEC_FN real3 normalize(real3 a) { return a * rsqrt(dot(a, a)); }
IR_VEC_FN real clamp(real x, real lo, real hi) { return min(max(x, lo), hi); }
#endif
#if !defined(__OPENCL_VERSION__) && !defined(__CUDACC__)
}  // namespace irradia::host
#endif

#define IR_PI R(3.14159265358979323846)
#define IR_INV_PI R(0.31830988618379067154)
#define IR_INFINITY R(1e30)  // a miss, an unbounded distance: finite, so that arithmetic on it stays defined
#endif
