#!/usr/bin/env bash
# Tests tools/bench/gpu and its script run: the folder has all libraries, and works without the build. Takes every sixth
# program of those that draw, and in long runs all.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

build=$(dirname "$STIPPLE")
[ -x "$build/stipple-bench" ] || skip_test "built without the renderer"
[ -z "${STIPPLE_SANITIZE:-}" ] || skip_test "programs with sanitizers are too large"
folder="$FOLDER/the folder"
programs=("$build"/tests/test_gl_*)
if ! is_long; then
    mkdir -p "$FOLDER/build/tests"
    ln -s "$build/stipple" "$build/stipple-bench" "$FOLDER/build"
    for ((i = 0; i < ${#programs[@]}; i += 6)); do sixth+=("${programs[i]}"); done
    programs=("${sixth[@]}" "$build"/tests/test_gl_{exr,layout,stages})
    ln -sf "${programs[@]}" "$FOLDER/build/tests"
    build=$FOLDER/build
fi

run bash "$SOURCE/tools/bench/gpu" --build "$build"
expect_code 2
expect_text err "name the folder"
run bash "$SOURCE/tools/bench/gpu" --build "$FOLDER/nowhere" "$folder"
expect_code 1
expect_text err "is not there"
[ ! -e "$folder" ] || fail "$command: left a folder"
run bash "$SOURCE/tools/bench/gpu" --build "$build" "$folder"
expect_code 0
expect_empty err
[ "$code" = 0 ] || end_test
run bash "$SOURCE/tools/bench/gpu" --build "$build" "$folder"
expect_code 1
expect_text err "exists"

for source in "$SOURCE"/tests/*/test_gl_*.c; do
    name=${source##*/} name=${name%.c}
    [[ $name = test_gl_exr || " ${programs[*]##*/} " != *" $name "* ]] || [ -e "$folder/tests/$name.gz" ] ||
        fail "no $name in the folder"
done
[ "$(du -sk "$folder" | cut -f1)" -le $((60 * 1024)) ] || fail "$(du -sh "$folder") are more than 60 MiB"

# Every library is in the folder, or one that a machine with a driver has.
of_machine=' ld-linux-x86-64.so.2 ld-linux-aarch64.so.1 libc.so.6 libm.so.6 libdl.so.2 libpthread.so.0 librt.so.1
    libGL.so.1 libEGL.so.1 libOpenGL.so.0 libGLX.so.0 libGLdispatch.so.0 '
cp -r "$folder/tests" "$FOLDER/tests"
gzip -d "$FOLDER"/tests/*
checked=0
for each in "$folder"/bin/* "$FOLDER"/tests/* "$folder"/lib/*; do
    while read -r library; do
        checked=$((checked + 1))
        [ -e "$folder/lib/$library" ] || [[ $of_machine == *[[:space:]]"$library"[[:space:]]* ]] ||
            fail "$(basename "$each") needs $library, which is not in the folder"
    done < <(readelf -dW "$each" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p')
done
! readelf -dW "$folder"/bin/* "$FOLDER"/tests/* | grep -E '\((RUNPATH|RPATH)\)' || fail "a program has a run path"
[ "$checked" -gt 100 ] || fail "readelf names only $checked libraries"

# Calls the folder's script from another folder, without any of this machine's settings.
mkdir "$FOLDER/else where"
away() { (cd "$FOLDER/else where" && run env -i PATH=/usr/bin:/bin "${settings[@]}" "$folder/run" "$@"; exit "$code"); }
call() { # options of run
    code=0
    away "$@" || code=$?
    command="run $*"
}
settings=(GALLIVM_PERF=nopt LP_NUM_THREADS=0) # as tests/CMakeLists.txt sets them

call --swift
expect_code 2
expect_text err "not an option"
call --tests layout,swift
expect_code 2
expect_text err "there is no swift"
call --small --seconds 0
expect_code 3
expect_empty err
expect_text out "8 steps are left"
call --small
expect_code 0
expect_empty err
[ "$(grep -c ' s): passed$' "$FOLDER/out")" = 8 ] || fail "the steps: $(cat "$FOLDER/out")"
expect_text out "tests: 2 passed, 0 failed, 0 skipped"
call --small
expect_code 0
expect_lines out 1

# Each row has the columns of its table, once for each combination, with numbers that make sense.
results="$FOLDER/else where/results"
plain() { sed -E 's/^("[^"]*",){4}//' "$results/$1.csv"; } # without date, GPU, driver and command
plain frames | awk -F, '
    NR == 1 { next }
    NF != 14 || $1 != 10000 { print "fields: " $0; bad = 1 }
    { keys[$2 "," $3 "," $5]++ }
    {
        for (i = 6; i <= 14; i++) if ($i !~ /^[0-9]+([.][0-9]+)?$/) { print "no number: " $0; bad = 1 }
        if ($8 + 0 > $7 + 0 || $7 + 0 > $9 + 0 || $8 <= 0) { print "median: " $0; bad = 1 }
        if ($10 <= 0 || $12 <= 0 || $14 <= 0 || ($3 == "full" && $14 != 10000)) { print "nothing: " $0; bad = 1 }
    }
    END {
        pictures = split("64x64 96x64", picture, " ")
        roads = split("geometry compute cpu full", road, " ")
        methods = split("gauss box template5 splat", method, " ")
        for (p = 1; p <= pictures; p++) for (r = 1; r <= roads; r++) for (m = 1; m <= methods; m++)
            if (keys[picture[p] "," road[r] "," method[m]] != 1) { print picture[p], road[r], method[m]; bad = 1 }
        exit bad || NR != 33
    }' >"$FOLDER/bad" || fail "frames.csv: $(cat "$FOLDER/bad" "$results/frames.csv")"
plain stream | awk -F, '
    NR == 1 { next }
    NF != 8 || $1 != 10000 || $5 != 1 { print "fields: " $0; bad = 1 }
    { for (i = 3; i <= 8; i++) if ($i !~ /^[0-9]+([.][0-9]+)?$/ || $i <= 0) { print "no number: " $0; bad = 1 } }
    END { exit bad || NR != 3 }' >"$FOLDER/bad" || fail "stream.csv: $(cat "$FOLDER/bad" "$results/stream.csv")"
date='^"[0-9]{4}-[0-9]{2}-[0-9]{2}","[^"]+","[0-9]+[.][0-9]+[^"]*","run --small",10000,'
for name in frames stream; do
    rows=$(($(wc -l <"$results/$name.csv") - 1))
    [ "$(grep -cE "$date" "$results/$name.csv")" = $rows ] || fail "$name.csv: $(head -3 "$results/$name.csv")"
    ! grep -F "$FOLDER" "$results/$name.csv" || fail "$name.csv names a folder"
done
[ "$(grep -c '^| 10000 |' "$results/table.md")" = 34 ] || fail "table.md: $(cat "$results/table.md")"

# Outcomes of tests: each gets a line. A failed one is tried again only when asked.
fake() { printf '#!/bin/bash\n%s\n' "$2" | gzip >"$folder/tests/test_gl_$1.gz"; }
fake good 'echo "[  SKIPPED ] 2 test(s), listed below:" >&2'
fake bad 'echo "wrong picture" >&2; exit 1'
fake idle 'echo "skipped: no such GPU"; exit 77'
fake slow 'exec sleep 30'
outcomes() { call --sizes '' --output outcomes --seconds 600 "$@"; }
outcomes --tests good,bad,idle
expect_code 1
expect_text out ": passed, 2 of its checks skipped"
expect_text out ": failed: exit 1: wrong picture"
expect_text out ": skipped: no such GPU"
expect_text out "tests: 1 passed, 1 failed, 1 skipped"
fake bad 'exit 0'
outcomes --tests good,bad,idle
expect_code 1
expect_lines out 1
outcomes --tests good,bad,idle --retry
expect_code 0
expect_lines out 2
expect_text out "tests: 2 passed, 0 failed, 1 skipped"
fake later 'sleep 2'
outcomes --tests later,slow --seconds 6 # slow has only what is left of the time
expect_code 3
expect_text out "1 steps are left"
outcomes --tests later,slow --seconds 1
expect_code 1
expect_text out ": failed: longer than 1 s"

# Nothing draws; then one of the folder's libraries does not load, and the machine's is taken.
settings=(__EGL_VENDOR_LIBRARY_FILENAMES=/dev/null)
outcomes --tests good
expect_code 1
expect_text err "nothing can be drawn here: "
settings=()
library=$folder/lib/libzstd.so.1
mv "$library" "$FOLDER/library"
echo broken >"$library"
if [ -e "/lib/$(uname -m)-linux-gnu/libzstd.so.1" ]; then
    call --sizes '' --output broken --tests good
    expect_code 0
fi
end_test
