#!/bin/sh
# minimal_bundle_test.sh SOURCE_DIR CMAKE: tools/minimal-bundle makes an archive that holds what a minimal build needs,
# makes the same bytes twice, and what it holds can be configured. (That it compiles takes minutes: see the README in it.)
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$1/tools/minimal-bundle" "$work/a.tar.gz"
"$1/tools/minimal-bundle" "$work/b.tar.gz" >"$work/log"
cmp "$work/a.tar.gz" "$work/b.tar.gz"
tar -C "$work" -xzf "$work/a.tar.gz"
cd "$work/irradia-minimal"
for file in build.sh README generated/embedded_kernels.cpp src/app/render_main.cpp src/core/packed_scene.cpp \
    third_party/include/CL/cl.h third_party/include/CLI/CLI.hpp third_party/include/nlohmann/json.hpp; do
    [ -s "$file" ] || { echo "the bundle lacks $file"; exit 1; }
done
# Every header that the sources name besides the compiler's own is there.
grep -rhoE '^#include <[A-Za-z_]+/[^>]*>' src include | grep -vE '<(sys|bits)/' | sed -E 's/.*<(.*)>/\1/' | sort -u |
    while read -r header; do
        [ -e "third_party/include/$header" ] || { echo "the bundle lacks <$header>"; exit 1; }
    done
"$2" -S . -B build -DIRRADIA_MINIMAL=ON >"$work/log" || { cat "$work/log"; exit 1; }
grep -q 'OpenCL_INCLUDE_DIR:PATH=.*third_party/include' build/CMakeCache.txt
grep 'render_main.cpp' build/compile_commands.json | grep -q 'isystem [^ ]*/third_party/include'
