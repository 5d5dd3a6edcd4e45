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
forecast=$(sed -n 's/^file  *about \(.*\) to \(.*\) MB .*/\1 \2/p' "$FOLDER/plan")
run "$STIPPLE" "${words[@]}" --quiet
expect_code 0
stat -c %s "$FOLDER/models/m.stipple" |
    awk -v f="$forecast" '{ split(f, mb); exit !(mb[1] <= 1e-6 * $1 && 1e-6 * $1 <= mb[2]) }' ||
    fail "$(stat -c %s "$FOLDER/models/m.stipple") bytes, expected $forecast MB"
rm -r "$FOLDER/models"/*
[ "$(grep -cE '^ *[0-9]+( +[0-9]+[.][0-9]){8}$' "$FOLDER/plan")" = 8 ] || fail "no table: $(cat "$FOLDER/plan")"

# Triangles between maps need 140 bytes a point more, here 15 MB.
plan --maps --memory 336M
expect_text out "temporary files  none"
plan --maps --gaps fill --memory 336M
expect_text out "temporary files  about"

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
vertices "$FOLDER/big/f.ply" 300000000000
refuse "274877906943 points in a model" "$FOLDER/big/f.ply"
run timeout 60 "$STIPPLE" prep --append "$FOLDER/big/b.las" -o "$FOLDER/models/m.stipple"
expect_failure "append them in several runs"

run "$STIPPLE" "${words[@]}" --force --plan --append
expect_usage "--plan plans a new model"
run "$STIPPLE" prep "$FOLDER/none.ply" -o "$FOLDER/models/n.stipple" --plan
expect_failure "none.ply"
end_test
