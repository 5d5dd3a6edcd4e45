#!/usr/bin/env bash
# Tests prep --outliers: planted outliers are marked or dropped, and listed by file and index. Any
# number of threads and any memory gives the same bytes (more of both in long runs). Marks are exported,
# counted and drawn.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
mkdir "$FOLDER/in"
"$STIPPLE" gen bumpy -n 200000 --noise 0.1 --order random -o "$FOLDER/in/b.ply" --quiet || fail "no scan"

# One file before and one after the ball, with points far from it and from each other.
far() { # name, points a line
    local lines
    lines=$(cat)
    {
        printf 'ply\nformat ascii 1.0\nelement vertex %s\n' "$(wc -l <<<"$lines")"
        printf 'property float x\nproperty float y\nproperty float z\nend_header\n%s\n' "$lines"
    } >"$FOLDER/in/$1"
}
far a.ply <<<$'9 0 0\nnan 1 1\n0 9 0\n0 0 9'
far c.ply <<<$'-9 0 0\n0 -9 0'

prepare() { # drop or mark, further options
    run "$STIPPLE" prep "$FOLDER/in" -o "$FOLDER/$1.stipple" --outliers "$@" --threads 1
    expect_code 0
}

# Memory alone, and files of points if memory is small, must give the same bytes.
check_bytes() { # drop or mark, then lists of options
    local how=$1
    shift
    ! is_long || set -- "--threads 2" "--threads 2 --memory 130M" "--threads 4 --memory 210M"
    for options in "$@"; do
        # shellcheck disable=SC2086
        "$STIPPLE" prep "$FOLDER/in" -o "$FOLDER/m.stipple" --force --outliers $how $options --quiet
        cmp -s "$FOLDER/$how.stipple" "$FOLDER/m.stipple" || fail "$how $options: other bytes"
    done
    "$STIPPLE" verify "$FOLDER/$how.stipple" --quiet || fail "$how: verify"
}
prepare mark
check_bytes mark "--threads 4 --memory 210M"

number() { # of a key of the statistics
    sed -n "s/.*\"$1\":[[:space:]]*\([0-9.e+]*\).*/\1/p" "$FOLDER/stats.json" | head -1
}

prepare drop --rejects "$FOLDER/rejects.csv" --stats "$FOLDER/stats.json"
expect_text err "200006 points read, 200000 stored, 6 rejected (1 not finite, 5 outliers)"
expect_text err "outliers: 5 dropped (0.0025 %), more than 3 local spacings from everything else"
expect_text err "  outliers "
[ "$(number points_out)" = 200000 ] || fail "points_out"
[ "$(number outlier)" = 5 ] || fail "rejected outliers"
{
    echo file,index,reason
    echo "\"$FOLDER/in/a.ply\",1,not_finite"
    for i in 0 2 3; do echo "\"$FOLDER/in/a.ply\",$i,outlier"; done
    for i in 0 1; do echo "\"$FOLDER/in/c.ply\",$i,outlier"; done
} >"$FOLDER/expected.csv"
cmp "$FOLDER/rejects.csv" "$FOLDER/expected.csv" || fail "rejects"
run "$STIPPLE" info "$FOLDER/drop.stipple"
expect_text out "outliers       5 dropped, more than 3 local spacings"
"$STIPPLE" export "$FOLDER/drop.stipple" -o "$FOLDER/m.ply" --quiet
! head -20 "$FOLDER/m.ply" | grep -a outlier || fail "a property of outliers, though none is marked"
check_bytes drop "--threads 2" "--threads 2 --memory 130M"

run "$STIPPLE" prep "$FOLDER/in" -o "$FOLDER/m.stipple" --force --outliers mark \
    --outlier-distance 4 --stats "$FOLDER/stats.json"
expect_code 0
expect_text err "200005 stored, 1 rejected (1 not finite)"
expect_text err "outliers: 5 marked (0.0025 %), more than 4 local spacings from everything else"
[ "$(number outliers_marked)" = 5 ] || fail "outliers_marked"
run "$STIPPLE" info "$FOLDER/m.stipple"
expect_text out "attributes     normal colour outlier"
expect_text out "outliers       5 marked, more than 4 local spacings"

# `outlier` is the last property of each vertex; it must be 1 five times.
"$STIPPLE" export "$FOLDER/m.stipple" -o "$FOLDER/m.ply" --force --quiet
[ "$(head -20 "$FOLDER/m.ply" | grep -acx "property uchar outlier")" = 1 ] || fail "no property"
header=$(head -20 "$FOLDER/m.ply" | grep -abo end_header | cut -d: -f1)
ones=$(tail -c +$((header + 12)) "$FOLDER/m.ply" | od -An -v -tu1 -w28 |
    awk '{ ones += $28 == 1; other += $28 > 1 } END { print ones + 0, other + 0, NR }')
[ "$ones" = "5 0 200005" ] || fail "marks: $ones"

# Without --outliers prep must not look for any. A smaller ball has as many.
"$STIPPLE" gen bumpy -n 5000 -o "$FOLDER/in/b.ply" --force --quiet
run "$STIPPLE" prep "$FOLDER/in" -o "$FOLDER/m.stipple" --force
! grep -q outliers "$FOLDER/err" || fail "outliers without being asked"
[ "$("$STIPPLE" info "$FOLDER/m.stipple" | grep -c outlier)" = 0 ] || fail "info says outliers"

usage() { # text, options
    local text=$1
    shift
    run "$STIPPLE" prep "$FOLDER/in" -o "$FOLDER/n.stipple" "$@"
    expect_usage "$text"
}
usage "--outliers" --outliers burn
usage "give --outliers mark or drop" --outlier-distance 3
usage "give 1 or more" --outliers drop --outlier-distance 0.5
usage "--outlier-distance" --outliers drop --outlier-distance nan

if "$STIPPLE" --help | found '^  render '; then
    run "$STIPPLE" render "$FOLDER/m.stipple" -o "$FOLDER/m.png" --colour outliers --size 64x64
    [ "$code" = 1 ] || fail "outliers were drawn, though none is marked"
    expect_text err "prepare it with --outliers mark"
    run "$STIPPLE" render "$FOLDER/mark.stipple" -o "$FOLDER/m.png" --colour outliers --size 64x64
    expect_code 0
fi
end_test
