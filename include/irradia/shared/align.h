// Alignment of shared structs, for the kernels: the host's buffers begin at multiples of far more. Told so, a GPU's compiler
// reads a struct's members four at a time instead of one by one (hemispheres on an H100: 1.3 times as fast).
#ifndef IRRADIA_SHARED_ALIGN_H
#define IRRADIA_SHARED_ALIGN_H

#if defined(__CUDACC__)
typedef unsigned int uint;  // of all shared structs: nvcc has it from sys/types.h, NVRTC has not
#endif
#if defined(__OPENCL_VERSION__) || defined(__CUDACC__)
#define IR_ALIGNED_16 __attribute__((aligned(16)))
#else
#define IR_ALIGNED_16
#endif
#endif
