#!/usr/bin/env bash
# The tests labelled `threadless`, which the thread sanitizer does not run, have no thread of ours:
# no program of theirs holds the pool, the spill, a stream of chunks or the screenshot,
# which alone start threads.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

starts=$(grep -rlE 'pthread_create|thrd_create|std::(thread|async)' "$SOURCE"/{base,formats,preprocess} \
    "$SOURCE"/{runtime,tools,tests} --include='*.c' --include='*.cpp' --exclude-dir=inject | sort)
expected=$(for file in base/pool.c base/spill.c runtime/stream/stream.c tools/view/view_shot.c; do
    echo "$SOURCE/$file"
done)
[ "$starts" = "$expected" ] || fail "threads are started in $starts"

# grep reads to the end: nm would die of a pipe that nobody reads.
has_pool() {
    "${NM:-nm}" "$1" | grep -E ' T (stp_(pool|spill|stream)_create|view_shot_begin)$' >/dev/null
}

has_pool ./test_base || fail "the pool is not seen in test_base, which has it"
for name in $THREADLESS; do
    source=$(echo "$SOURCE"/tests/*/"$name".*)
    if [[ $source == *.sh ]]; then
        # Scripts that look at files alone.
        ! grep -q '"\$STIPPLE"' "$source" || fail "$name runs the program"
    elif [ -e "./$name" ]; then
        ! has_pool "./$name" || fail "$name has the pool: take it off the list in CMakeLists.txt"
    elif [ ! -e "$source" ]; then
        fail "$name is no test"
    fi
done
end_test
