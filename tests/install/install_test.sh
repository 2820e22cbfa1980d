#!/bin/sh
# install_test.sh SOURCE_DIR BUILD_DIR CMAKE: what cmake --install puts elsewhere renders: the executable, and a project
# that finds the library by find_package(Irradia). Their pictures are the same.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
scene=$1/scenes/cornell-box.xml
"$3" --install "$2" --prefix "$work/prefix" >"$work/log" || { cat "$work/log"; exit 1; }
"$work/prefix/bin/render" "$scene" -o "$work/a.pfm" --method path --spp 4 --width 16 --height 16 --quiet
"$work/prefix/bin/render" "$scene" -o "$work/a.exr" --method path --spp 4 --width 16 --height 16 --quiet
"$work/prefix/bin/compare" "$work/a.exr" "$work/a.pfm" >"$work/log"

# Kernels that were compiled with the build are installed too: nothing is left to compile, and so to keep.
if [ -d "$2/share/irradia/kernels" ]; then
    mkdir "$work/kernels" "$work/driver"
    for settings in "" "--quality draft" "--quality medium" "--quality fine" "--quality finest" "--method path"; do
        IRRADIA_KERNEL_CACHE=$work/kernels POCL_CACHE_DIR=$work/driver "$work/prefix/bin/render" "$scene" $settings \
            --width 8 --quiet -o "$work/d.pfm"
    done
    [ -z "$(ls "$work/kernels")" ] || { echo "kernels were compiled that are not installed"; exit 1; }
fi

"$3" -S "$1/tests/install/consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/log" 2>&1 &&
    "$3" --build "$work/build" >>"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
"$work/build/consumer" "$scene" "$work/b.pfm"
cmp "$work/a.pfm" "$work/b.pfm"
"$work/build/consumer" "$scene" "$work/b.png" "$work/b.records"
"$work/prefix/bin/render" "$scene" -o "$work/c.pfm" --spp 4 --width 16 --height 16 --load-records "$work/b.records" --quiet
"$work/prefix/bin/compare" "$work/b.png" "$work/a.pfm" >"$work/log"
# No package file or header leads back to the source or build folder.
[ -n "$(find "$work/prefix" -name IrradiaConfig.cmake)" ]
if grep -rlF --include='*.cmake' --include='*.h' -e "$1" -e "$2" "$work/prefix"; then exit 1; fi
