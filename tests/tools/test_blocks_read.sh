#!/usr/bin/env bash
# Tests that a model in blocks (format 2) gives the same pictures as in format 1, from fewer bytes.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
"$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
"$STIPPLE" gen terrain -n 300000 -o "$FOLDER/s.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/s.ply" -o "$FOLDER/1.stipple" --format 1 --quiet || fail "no model"
"$STIPPLE" convert "$FOLDER/1.stipple" -o "$FOLDER/2.stipple" --format 2 --block 500 --quiet || fail "no blocks"

bytes_read() { # stats
    awk '/"bytes_read":/ { gsub(/[^0-9]/, ""); bytes = $0 } /"cut_complete":[[:space:]]*true/ { complete = 1 }
        END { print complete ? bytes : 0 }' "$1"
}

# Draws both models; prints the bytes read of the second in percent of the first.
compare_views() { # options
    local format
    for format in 1 2; do
        "$STIPPLE" render "$FOLDER/$format.stipple" -o "$FOLDER/$format.png" --stats "$FOLDER/$format.json" \
            --size 256x256 --quiet --force "$@" || fail "no picture: format $format $*"
    done
    cmp "$FOLDER/1.png" "$FOLDER/2.png" || fail "blocks give another picture: $*"
    echo $((100 * $(bytes_read "$FOLDER/2.json") / $(bytes_read "$FOLDER/1.json")))
}

whole=$(compare_views --threshold 1)
coarse=$(compare_views --threshold 3)
near=$(compare_views --threshold 1 --eye 0,0,0.3 --look 0.5,0.5,0)
echo "read: whole $whole %, coarse $coarse %, near $near %"
for percent in $whole $coarse $near; do
    [ "$percent" -gt 0 ] || fail "nothing was read, or the cut was not complete"
    [ "$percent" -lt 75 ] || fail "blocks read $percent % of what chunks read"
done
compare_views --lod geometry --threshold 0.5 >/dev/null
compare_views --lod cpu --threshold 1 --cull back >/dev/null
compare_views --gpu-memory 8M --threshold 0.5 >/dev/null # in several passes
every=$(compare_views --threshold 0)
grown=$((100 * $(stat -c %s "$FOLDER/2.stipple") / $(stat -c %s "$FOLDER/1.stipple")))
[ "$every" -le $((grown + 1)) ] || fail "every sample in blocks: $every % read of a file of $grown %"
end_test
