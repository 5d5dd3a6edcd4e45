#!/usr/bin/env bash
# Tests the outputs of all commands, first and second ones. Without --force none replaces a file.
# Even with --force none is written over an input or another output. A refused request writes
# nothing at all.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
work="$FOLDER/results"
mkdir "$work"
echo '{"size": [8, 8]}' >"$FOLDER/camera.json"

# A request is $words; its outputs follow -o, --mesh, --truth and --stats. {} stands for the folder
# $work.
request() { # further words
    run "$STIPPLE" "${words[@]//\{\}/$work}" "$@"
}

# Lets each output exist in turn: the request must be refused, and no other output may appear.
check_existing() { # names of the outputs
    local name
    for name in "$@"; do
        rm -rf "${work:?}"/*
        echo kept >"$work/$name"
        request
        expect_failure "$name exists"
        [ "$(cat "$work/$name")" = kept ] || fail "$command: $name is gone"
        [ "$(ls -A "$work")" = "$name" ] || fail "$command: wrote $(ls -A "$work")"
    done
    for name in "$@"; do
        echo kept >"$work/$name"
    done
    request --force
    expect_code 0
    for name in "$@"; do
        [ -s "$work/$name" ] && [ "$(head -c 5 "$work/$name")" != kept ] ||
            fail "$command: $name was not replaced"
    done
    [ "$(ls -A "$work" | wc -l)" = $# ] || fail "$command: left $(ls -A "$work")"
}

# The request must be refused even with --force, with a sentence that has the text; nothing may be
# written.
check_refused() { # text
    rm -rf "${work:?}"/*
    request --force
    expect_failure "$1"
    [ -z "$(ls -A "$work")" ] || fail "$command: wrote $(ls -A "$work")"
}

words=(gen bumpy -n 100 -o '{}/o.ply' --mesh '{}/m.ply' --truth '{}/t.png' --size 8x8 --quiet)
words+=(--mesh-triangles 1000)
check_existing o.ply m.ply t.png
words=(gen bumpy -n 100 -o '{}/same' --mesh '{}/../results/same' --quiet)
check_refused "written twice"
words=(gen bumpy -n 100 -o '{}/o.ply' --truth "$FOLDER/camera.json" --camera "$FOLDER/camera.json")
check_refused "camera.json is also an input"
words=(gen bumpy -n 100 -o '{}/o.ply' --truth '{}/none/t.png' --size 8x8 --quiet)
check_refused "none/t.png"

"$STIPPLE" gen sphere -n 1000 -o "$FOLDER/scan.ply" --quiet || fail "no scan"
words=(prep "$FOLDER/scan.ply" -o '{}/m.stipple' --stats '{}/s.json' --quiet)
check_existing m.stipple s.json
cp "$work/m.stipple" "$FOLDER/model.stipple"
words=(prep "$FOLDER/scan.ply" -o '{}/same' --stats '{}/./same' --quiet)
check_refused "written twice"
words=(prep "$FOLDER/scan.ply" -o '{}/m.stipple' --stats "$FOLDER/scan.ply" --quiet)
check_refused "scan.ply is also an input"

words=(export "$FOLDER/model.stipple" -o '{}/o.ply' --quiet)
check_existing o.ply
words=(profile "$FOLDER/model.stipple" --line=-9,0,9,0 -o '{}/p.csv' --quiet)
check_existing p.csv

if "$STIPPLE" --help | found '^  render '; then
    words=(render "$FOLDER/model.stipple" -o '{}/i.png' --stats '{}/s.json' --size 8x8)
    check_existing i.png s.json
    words=(render "$FOLDER/model.stipple" -o '{}/same.png' --stats '{}/same.png' --size 8x8)
    check_refused "written twice"
    words=(render "$FOLDER/model.stipple" -o '{}/i.png' --stats "$FOLDER/model.stipple" --size 8x8)
    check_refused "model.stipple is also an input"
    words=(render "$FOLDER/model.stipple" -o '{}/i.png' --stats "$FOLDER/camera.json")
    words+=(--camera "$FOLDER/camera.json")
    check_refused "camera.json is also an input"
    "$STIPPLE" verify "$FOLDER/model.stipple" --quiet || fail "the model was written over"
fi
grep -q size "$FOLDER/camera.json" || fail "the camera was written over"
end_test
