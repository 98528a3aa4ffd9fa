#!/bin/bash -eu
# Builds the harnesses for OSS-Fuzz, with their seeds, dictionaries and shared libraries.
# KINDLING_FUZZ_TARGET=fuzz_images builds some of them, to try this script without OSS-Fuzz.
# SPDX-License-Identifier: Apache-2.0
# The packages' C++ libraries use libstdc++; the engine brings its own copy of libc++.
flags=${CXXFLAGS//-stdlib=libc++/}
build=$WORK/build
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_COMPILER="$CXX" "-DCMAKE_CXX_FLAGS=$flags" \
  -DKINDLING_BUILD_FUZZ=ON "-DKINDLING_FUZZ_ENGINE=$LIB_FUZZING_ENGINE" -DKINDLING_BUILD_TESTS=OFF -DKINDLING_BUILD_BENCH=OFF
cmake --build "$build" --target "${KINDLING_FUZZ_TARGET:-fuzz}"
# The machines that run the harnesses have none of the packages.
mkdir -p "$OUT/lib"
pack() { # FILE: copies it to $OUT with the libraries that it needs
  cp "$1" "$OUT"
  ldd "$1" | awk '$3 ~ /^\// { print $3 }' | grep -v -E '/(libc|libm|libdl|libpthread|librt|ld-linux.*)\.so' | xargs -r cp -n -t "$OUT/lib"
  patchelf --set-rpath '$ORIGIN/lib' "$OUT/$(basename "$1")"
}
pack "$build/kindling_oiio.so"
python3 tests/fuzz/make_seeds.py "$WORK/seeds" --programs "$build/tests/fuzz"
for harness in "$build"/tests/fuzz/fuzz_*; do
  name=$(basename "$harness")
  [[ -x $harness && -f $harness && $name != fuzz_seeds_* ]] || continue
  pack "$harness"
  kind=${name#fuzz_}
  [ ! -d "$WORK/seeds/$kind" ] || zip -q -j "$OUT/${name}_seed_corpus.zip" "$WORK/seeds/$kind"/*
  [ ! -f "tests/fuzz/dictionaries/$kind.dict" ] || cp "tests/fuzz/dictionaries/$kind.dict" "$OUT/$name.dict"
  printf '[libfuzzer]\nrss_limit_mb = 3072\nmalloc_limit_mb = 1100\nmax_len = 65536\ntimeout = 30\nentropic_feature_frequency_threshold = 8\n' >"$OUT/$name.options"
done
for library in "$OUT"/lib/*; do patchelf --set-rpath '$ORIGIN' "$library"; done
