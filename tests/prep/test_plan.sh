#!/usr/bin/env bash
# Tests prep --plan: it says what prep then needs, and writes nothing.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
mkdir "$FOLDER/models"
"$STIPPLE" gen statue -n 60000 --order random -o "$FOLDER/a.ply" --quiet || fail "no scan"
"$STIPPLE" gen terrain -n 50000 -o "$FOLDER/b.las" --quiet || fail "no scan"
words=(prep "$FOLDER/a.ply" "$FOLDER/b.las" -o "$FOLDER/models/m.stipple" --threads 2)

plan() { # further words
    run "$STIPPLE" "${words[@]}" "$@" --plan
    expect_code 0
    expect_empty err
    [ -z "$(ls -A "$FOLDER/models")" ] || fail "--plan wrote $(ls -A "$FOLDER/models")"
    cp "$FOLDER/out" "$FOLDER/plan"
}

plan
expect_text out "points           110000"
expect_text out "temporary files  none"
# The file is as large as it says.
check_size() { # words of prep
    local forecast
    forecast=$(sed -n 's/^file  *about \(.*\) to \(.*\) MB .*/\1 \2/p' "$FOLDER/plan")
    run "$STIPPLE" "$@" --quiet
    expect_code 0
    stat -c %s "$FOLDER/models/m.stipple" |
        awk -v f="$forecast" '{ split(f, mb); exit !(mb[1] <= 1e-6 * $1 && 1e-6 * $1 <= mb[2]) }' ||
        fail "$*: $(stat -c %s "$FOLDER/models/m.stipple") bytes, expected $forecast MB"
    rm "$FOLDER/models"/*
}
check_size "${words[@]}"
[ "$(grep -cE '^ *[0-9]+( +[0-9]+[.][0-9]){8}$' "$FOLDER/plan")" = 8 ] || fail "no table: $(cat "$FOLDER/plan")"

# Triangles between maps need 140 bytes a point more, here 15 MB.
plan --maps --memory 336M
expect_text out "temporary files  none"
plan --maps --gaps fill --memory 336M
expect_text out "temporary files  about"

# Grids take fewer bytes; lines and triangles count by their vertices.
points=("${words[@]}")
awk 'BEGIN { print "P2\n500 500\n255"; for (i = 0; i < 250000; i++) print 99 + int(90 * sin(i % 500 / 99)) }' >"$FOLDER/g.pgm"
"$STIPPLE" gen tree -n 4000 -o "$FOLDER/leaves.ply" --mesh "$FOLDER/tree.ply" --quiet || fail "no tree"
words=(prep "$FOLDER/g.pgm" -o "$FOLDER/models/m.stipple")
plan
check_size "${words[@]}"
words=(prep "$FOLDER/tree.ply" --lines auto -o "$FOLDER/models/m.stipple")
plan
expect_text out "lines, triangles"
check_size "${words[@]}"
words=("${points[@]}")

# The temporary files are those that the run announces.
plan --memory 140M
run "$STIPPLE" "${words[@]}" --memory 140M
expect_code 0
[ "$(grep -o 'about [0-9.]* GB, at most [0-9.]* GB' "$FOLDER/err")" = "$(sed -n 's/^temp.*\(about.*GB\) a rank\(.*GB\) if.*/\1\2/p' "$FOLDER/plan")" ] ||
    fail "other temporary files: $(head -1 "$FOLDER/err") $(head -3 "$FOLDER/plan")"

# More points than 32 bits count are planned; what is too many is said before anything is read, by
# the plan too. The files have holes.
pad() { # file, bytes of a record, records
    truncate -s $(($(stat -c %s "$1") + $2 * $3)) "$1" || skip_test "no room for a file of holes"
}
vertices() { # file, how many
    printf '%s\n' ply "format binary_little_endian 1.0" "element vertex $2" "property float x" \
        "property float y" "property float z" end_header >"$1"
    pad "$1" 12 "$2"
}
many() { # points, inputs
    run timeout 60 "$STIPPLE" prep "${@:2}" -o "$FOLDER/models/big.stipple" --memory 4096G --plan
    expect_code 0
    expect_text out "points           $1"
}
refuse() { # message, inputs
    run timeout 60 "$STIPPLE" prep "${@:2}" -o "$FOLDER/models/big.stipple" --threads 1
    expect_failure "at most $1: split the input"
    run timeout 60 "$STIPPLE" prep "${@:2}" -o "$FOLDER/models/big.stipple" --threads 1 --plan
    expect_failure "at most $1: split the input"
}
mkdir "$FOLDER/big" "$FOLDER/halves"
cp "$FOLDER/b.las" "$FOLDER/big/b.las"
# LAS 1.4: its number of points at byte 247, and again as that of the first returns.
for at in 247 255; do
    printf '\000\362\005\052\001\000\000\000' | dd of="$FOLDER/big/b.las" bs=1 seek=$at conv=notrunc status=none
done
pad "$FOLDER/big/b.las" 36 5000000000
many 5000000000 "$FOLDER/big/b.las"
refuse "4294967293 points that become maps" "$FOLDER/big/b.las" --maps
printf 'Pf\n70000 70000\n-1.0\n' >"$FOLDER/big/c.pfm"
pad "$FOLDER/big/c.pfm" 4 4900000000
many 4900000000 "$FOLDER/big/c.pfm" --spacing 1,1
vertices "$FOLDER/halves/d.ply" 2500000000
vertices "$FOLDER/halves/e.ply" 2500000000
many 5000000000 "$FOLDER/halves"
# What does not fit on this disk is planned, too.
vertices "$FOLDER/big/g.ply" 200000000000
run timeout 60 "$STIPPLE" prep "$FOLDER/big/g.ply" -o "$FOLDER/models/big.stipple" --memory 1G --plan
expect_code 1
expect_text err "GB of temporary files are needed"
expect_text out "file             about 800.00 to 1800.00 GB"
grep -Eq '^ *1024 ' "$FOLDER/out" || fail "no times"
vertices "$FOLDER/big/f.ply" 300000000000
refuse "274877906943 points in a model" "$FOLDER/big/f.ply"
run timeout 60 "$STIPPLE" prep --append "$FOLDER/big/b.las" -o "$FOLDER/models/m.stipple"
expect_failure "append them in several runs"

run "$STIPPLE" "${words[@]}" --force --plan --append
expect_usage "--plan plans a new model"
echo no scan >"$FOLDER/bad.ply"
run "$STIPPLE" "${words[@]}" "$FOLDER/bad.ply" --plan --force
expect_code 1
expect_text out "points           110000"
expect_text err "1 of 3 inputs could not be read, as said above: the plan is of the others"
run "$STIPPLE" prep "$FOLDER/none.ply" -o "$FOLDER/models/n.stipple" --plan
expect_failure "none.ply"
end_test
