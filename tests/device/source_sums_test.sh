#!/bin/sh
# cmake/EmbedKernels.cmake: a file's sums tell of it and of all that it includes, and of nothing else. Arguments: source
# tree, cmake.
set -eu
root=$1 cmake=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/cl" "$work/include/irradia/shared"
cd "$work"
echo '#if IR_ANY
  #  include "b.h"  // under a condition
#endif' > cl/a.cl
printf '#ifndef B\n#define B\n#include "irradia/shared/c.h"\n#include "e.h"\n#endif\n' > cl/b.h
echo '#include "b.h"' > cl/e.h # a ring
echo 'typedef int c;' > include/irradia/shared/c.h
echo '// #include "b.h"' > cl/d.cl

sums() { # of a file
  "$cmake" -D "ROOT=$work" -D "OUTPUT=$work/table.cpp" -P "$root/cmake/EmbedKernels.cmake"
  sed -n "s|^ *{\"$1\", .*{\(0x[0-9a-f]\{16\}u, 0x[0-9a-f]\{16\}u\)}},\$|\1|p" table.cpp
}
fail() {
  echo "$*" >&2
  exit 1
}

a=$(sums a.cl) b=$(sums b.h) d=$(sums d.cl) e=$(sums e.h)
[ -n "$a" ] && [ -n "$b" ] && [ -n "$d" ] || fail "no sums: $(cat table.cpp)"
[ "$a" != "$b" ] && [ "$a" != "$d" ] && [ "$b" != "$d" ] || fail "the same sums of different files: $a, $b, $d"
[ "$a" = "$(sums a.cl)" ] || fail "other sums of the same file"
echo 'typedef long c;' > include/irradia/shared/c.h
[ "$a" != "$(sums a.cl)" ] || fail "a.cl: the same sums, but what b.h includes has changed"
[ "$b" != "$(sums b.h)" ] || fail "b.h: the same sums, but what it includes has changed"
[ "$e" != "$(sums e.h)" ] || fail "e.h: the same sums, but what b.h, which it includes, includes has changed"
[ "$d" = "$(sums d.cl)" ] || fail "d.cl: other sums, but it includes nothing that has changed"
echo 'typedef int c;' > include/irradia/shared/c.h
[ "$a" = "$(sums a.cl)" ] || fail "a.cl: other sums of what it was before"
