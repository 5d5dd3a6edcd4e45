#!/usr/bin/env bash
# Tests that the tests labelled `threadless`, which the thread sanitizer does not run, have no
# thread of ours. Only the pool, the spill, the stream of chunks, the viewer's profile and its screenshot start
# threads, so none of these programs may contain one of the five.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
[ -z "${STIPPLE_SANITIZE:-}" ] || skip_test "programs with sanitizers keep what they do not use, the pool too"

starts=$(grep -rlE 'pthread_create|thrd_create|std::(thread|async)' "$SOURCE"/{base,formats,preprocess} \
    "$SOURCE"/{runtime,tools,tests} --include='*.c' --include='*.cpp' --exclude-dir=inject | sort)
expected=$(for file in base/pool.c base/spill.c runtime/stream/stream.c tools/view/view_profile.c \
    tools/view/view_shot.c; do
    echo "$SOURCE/$file"
done)
[ "$starts" = "$expected" ] || fail "threads are started in $starts"

# grep must read to the end: with -q, nm would fail writing to a closed pipe.
has_pool() {
    "${NM:-nm}" "$1" | grep -E ' T (stp_(pool|spill|stream)_create|view_(profile|shot)_begin)$' >/dev/null
}

has_pool ./test_base || fail "the pool is not seen in test_base, which has it"
for name in $THREADLESS; do
    source=$(echo "$SOURCE"/tests/*/"$name".*)
    if [[ $source == *.sh ]]; then
        # Scripts must only look at files.
        ! grep -q '"\$STIPPLE"' "$source" || fail "$name runs the program"
    elif [ -e "./$name" ]; then
        ! has_pool "./$name" || fail "$name has the pool: take it off the list in CMakeLists.txt"
    elif [ ! -e "$source" ]; then
        fail "$name is no test"
    fi
done
end_test
