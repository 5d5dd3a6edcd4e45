#!/usr/bin/env bash
# Kills prep at 100 moments, in memory and with temporary files, and runs it on 20 disks that are
# too small. A file under the output's name must always be whole, and the next run must leave
# nothing but its own files.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
scan="$FOLDER/scan.ply"
mkdir "$FOLDER/models"
"$STIPPLE" gen statue -n 300000 --order random -o "$scan" --quiet || fail "no scan"
words=(prep "$scan" -o "$FOLDER/models/m.stipple" --threads 2 --quiet)

# If the output exists, it must be whole.
check_output() {
    if [ -e "$FOLDER/models/m.stipple" ]; then
        "$STIPPLE" verify "$FOLDER/models/m.stipple" --quiet || fail "$1: a file that is not sound"
        rm "$FOLDER/models/m.stipple"
    fi
}

began=$(date +%s%N)
"$STIPPLE" "${words[@]}" || fail "no run"
took=$((($(date +%s%N) - began) / 1000000))
check_output "a whole run"
killed=0
for i in $(seq 100); do
    more=()
    [ $((i % 2)) = 0 ] && more=(--memory 130M)
    "$STIPPLE" "${words[@]}" "${more[@]}" &
    child=$!
    milliseconds=$((took * (i - 1) / 90))
    sleep "$((milliseconds / 1000)).$(printf %03d $((milliseconds % 1000)))"
    kill -KILL $child 2>/dev/null && killed=$((killed + 1))
    wait $child 2>/dev/null
    check_output "kill $i"
done
[ $killed -ge 50 ] || fail "only $killed of 100 runs were killed"
"$STIPPLE" "${words[@]}" || fail "the run after the kills failed"
[ "$(ls -A "$FOLDER/models")" = m.stipple ] || fail "after kills: $(ls -A "$FOLDER/models")"
check_output "the run after the kills"

size=$((300000 * 5))
for i in $(seq 20); do
    mkdir -p "$FOLDER/small"
    mount -t tmpfs -o "size=$((size * i / 20 / 4096 * 4096))" stipple-test "$FOLDER/small" \
        2>/dev/null || break
    run "$STIPPLE" prep "$scan" -o "$FOLDER/small/m.stipple" --threads 2 --quiet
    [ -z "$(ls -A "$FOLDER/small")" ] || [ "$(ls -A "$FOLDER/small")" = m.stipple ] ||
        fail "disk $i: left $(ls -A "$FOLDER/small")"
    if [ -e "$FOLDER/small/m.stipple" ]; then
        "$STIPPLE" verify "$FOLDER/small/m.stipple" --quiet || fail "disk $i: not sound"
    else
        expect_failure "the disk is full"
    fi
    umount "$FOLDER/small"
done
end_test
