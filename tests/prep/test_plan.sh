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
[ "$(grep -cE '^ *[0-9]+( +[0-9]+[.][0-9]){8}$' "$FOLDER/plan")" = 8 ] || fail "no table: $(cat "$FOLDER/plan")"

# Triangles between maps need 140 bytes a point more, here 15 MB.
plan --maps --memory 320M
expect_text out "temporary files  none"
plan --maps --gaps fill --memory 320M
expect_text out "temporary files  about"

# The temporary files are those that the run announces.
plan --memory 140M
run "$STIPPLE" "${words[@]}" --memory 140M
expect_code 0
[ "$(grep -o 'about [0-9.]* GB, at most [0-9.]* GB' "$FOLDER/err")" = "$(sed -n 's/^temp.*\(about.*GB\) a rank\(.*GB\) if.*/\1\2/p' "$FOLDER/plan")" ] ||
    fail "other temporary files: $(head -1 "$FOLDER/err") $(head -3 "$FOLDER/plan")"

run "$STIPPLE" "${words[@]}" --force --plan --append
expect_usage "--plan plans a new model"
run "$STIPPLE" prep "$FOLDER/none.ply" -o "$FOLDER/models/n.stipple" --plan
expect_failure "none.ply"
end_test
