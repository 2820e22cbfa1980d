// What cl/ uses of CUDA's own headers, for compilers that read CUDA C++ where no CUDA toolkit is installed:
// declarations as nvcc has them, nothing to run. Device code that names anything else of CUDA's is not of the dialect.
#ifndef IRRADIA_TESTS_CUDA_BUILTINS_H
#define IRRADIA_TESTS_CUDA_BUILTINS_H
#define __host__ __attribute__((host))
#define __device__ __attribute__((device))
#define __global__ __attribute__((global))
#define __shared__ __attribute__((shared))
#define __forceinline__ inline __attribute__((always_inline))
#define __noinline__ __attribute__((noinline))
#define __align__(n) __attribute__((aligned(n)))

using size_t = decltype(sizeof 0);

struct float3 {
    float x, y, z;
};
__device__ float3 make_float3(float x, float y, float z);

struct uint3 {
    unsigned x, y, z;
};
extern const __device__ uint3 threadIdx, blockIdx, blockDim, gridDim;
__device__ void __syncthreads();
__device__ void __threadfence();

__device__ unsigned __float_as_uint(float x);
__device__ float __uint_as_float(unsigned x);
__device__ int __popc(unsigned x);
__device__ unsigned atomicAdd(unsigned* p, unsigned v);
__device__ unsigned atomicMin(unsigned* p, unsigned v);
__device__ unsigned atomicMax(unsigned* p, unsigned v);
__device__ unsigned atomicOr(unsigned* p, unsigned v);
__device__ unsigned atomicCAS(unsigned* p, unsigned expected, unsigned v);

#define CUDA_OF_ONE(name) __device__ float name(float x);
CUDA_OF_ONE(fabs)
CUDA_OF_ONE(sqrt)
CUDA_OF_ONE(rsqrt)
CUDA_OF_ONE(floor)
CUDA_OF_ONE(exp)
CUDA_OF_ONE(exp2)
CUDA_OF_ONE(log)
CUDA_OF_ONE(log2)
CUDA_OF_ONE(sin)
CUDA_OF_ONE(cos)
CUDA_OF_ONE(tan)
CUDA_OF_ONE(acos)
CUDA_OF_ONE(asin)
CUDA_OF_ONE(erf)
CUDA_OF_ONE(erfc)
#undef CUDA_OF_ONE
__device__ float pow(float x, float y);
__device__ float fma(float x, float y, float z);
__device__ float atan2(float y, float x);
__device__ void sincosf(float x, float* s, float* c);
__device__ bool isfinite(float x);
#define CUDA_OF_TYPE(type)               \
    __device__ type min(type a, type b); \
    __device__ type max(type a, type b);
CUDA_OF_TYPE(int)
CUDA_OF_TYPE(unsigned)
CUDA_OF_TYPE(unsigned long)
CUDA_OF_TYPE(float)
#undef CUDA_OF_TYPE
#endif
