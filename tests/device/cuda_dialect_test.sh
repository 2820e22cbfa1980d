#!/bin/sh
# Device code is CUDA C++, too: a compiler reads every kernel of cl/ as that, by the declarations of cuda_builtins.h, as a
# scene of diffuse surfaces asks for it and as one with everything does. Arguments: source tree, clang.
set -eu
root=$1 clang=$2
[ -x "$clang" ] || {
  echo "no clang found, which PoCL's packages bring along (clang-15 on Debian 12): install clang" >&2
  exit 1
}
cd "$root"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

read_as_cuda() { # file, definitions
  file=$1
  shift
  "$clang" -x cuda -std=c++17 -D__CUDACC__ -nostdinc -nocudainc -nocudalib --cuda-device-only --cuda-gpu-arch=sm_70 \
    -fsyntax-only -w -include tests/device/cuda_builtins.h -I cl -I include -DIR_M=16 -DIR_N=32 -DIR_GROUP=256 -DIR_ORDER=4 \
    -DIR_WEIGHT=0 -DIR_DIRECT_MIS=1 -DIR_GRADIENT_LIMIT=1 "$@" "$file"
}

failed=0
check() { # file, definitions
  read_as_cuda "$@" 2> "$work/errors" && return
  echo "$*: not CUDA C++:" >&2
  cat "$work/errors" >&2
  failed=1
}

echo 'IR_KERNEL void f(IR_GLOBAL float4* x) { x->xyz = (float3)(1.0f, 2.0f, 3.0f); }' > "$work/no.cl"
! read_as_cuda "$work/no.cl" -include cl/portable.h 2> "$work/errors" || {
  echo "vector literals and swizzles are taken for CUDA C++: this test can't fail" >&2
  exit 1
}

kernels=0
for file in cl/*.cl; do
  kernels=$((kernels + 1))
  check "$file" -DIR_FEATURES=0xffffu -DIR_AOVS=1 -DIR_LOBES=1 -DIR_RADIANCE=1 -DIR_GRID=1 -DIR_GRADIENT=2 -DIR_RADIUS=0 \
    -DIR_GLOBAL_CELLS=1
  case $file in # what a scene of diffuse surfaces never asks for
    *tabulate_lobes.cl | *find_disagreements.cl | *radiance_test.cl | *texture_test.cl | *shapes_test.cl | *learn_sky.cl) ;;
    *) check "$file" -DIR_FEATURES=0u -DIR_GRID=2 -DIR_GRADIENT=1 -DIR_RADIUS=2 -DIR_GLOBAL_CELLS=0 -DIR_RADIANCE=0 ;;
  esac
done
[ "$kernels" -gt 20 ] || {
  echo "only $kernels files in cl/: this is not the source tree" >&2
  exit 1
}
exit $failed
