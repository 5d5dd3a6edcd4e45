#!/usr/bin/env bash
# Tests EPT sets and scans on a web server, nginx: prep must write the same bytes as from files, read
# no more than it needs, and say where a server fails.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/nginx.sh"
command -v python3 >/dev/null || skip_test "python3 is not installed"

# Writes an EPT of 3000 points on a bowl in depths 0 to 2, binary.
write_set() { # folder
    mkdir -p "$1/ept-data" "$1/ept-hierarchy"
    python3 - "$1" <<'END'
import json, random, struct, sys
folder, nodes = sys.argv[1], {}
random.seed(1)
for i in range(3000):
    x, y = random.randrange(6400), random.randrange(6400)
    at = (x, y, ((x - 3200) ** 2 + (y - 3200) ** 2) // 6400)
    depth = 0 if i % 10 < 2 else 1 if i % 10 < 5 else 2
    key = (depth,) + tuple((c << depth) // 6400 for c in at)
    nodes.setdefault(key, []).append(struct.pack("<iiiH", *at, 300 + i % 5000))
def field(name, offset):
    return {"name": name, "type": "signed", "size": 4, "scale": 0.01, "offset": offset}
json.dump({"bounds": [500, 600, 700, 564, 664, 764], "dataType": "binary", "hierarchyType": "json",
           "points": 3000, "span": 16, "srs": {}, "version": "1.0.0",
           "schema": [field("X", 500), field("Y", 600), field("Z", 700),
                      {"name": "Intensity", "type": "unsigned", "size": 2}]},
          open(folder + "/ept.json", "w"))
json.dump({"-".join(map(str, key)): len(points) for key, points in nodes.items()},
          open(folder + "/ept-hierarchy/0-0-0-0.json", "w"))
for key, points in nodes.items():
    open(folder + "/ept-data/" + "-".join(map(str, key)) + ".bin", "wb").write(b"".join(points))
END
}

root=$FOLDER/www
write_set "$root/a b/bowl"
"$STIPPLE" gen bumpy -n 3000 -o "$root/a.las" --quiet || fail "no LAS"
printf '%s 0 0\n' $(seq 400) | awk '{ print NR % 20, int(NR / 20), NR % 7 }' >"$root/b.xyz"

server_body() { echo "location /whole/ { alias $root/; max_ranges 0; }"; }
start_nginx "$root"

# made INPUT MODEL options...: prep must succeed, silently.
made() {
    local input=$1 output=$2
    shift 2
    run "$STIPPLE" prep "$input" -o "$FOLDER/$output" --quiet --force --stats "$FOLDER/stats.json" "$@"
    expect_code 0
    expect_empty err
}

same() { # models
    cmp -s "$FOLDER/$1" "$FOLDER/$2" || fail "$command: $1 and $2 differ"
}

set="$root/a b/bowl"
made "$set/ept.json" near.stipple --threads 1
[ "$(field points_out)" = 3000 ] || fail "$(field points_out) points of the set"
made "$set" folder.stipple --threads 2
same near.stipple folder.stipple
made "$root/a b" above.stipple
same near.stipple above.stipple
made "$web/a b/bowl/ept.json?key=secret" far.stipple --temp "$FOLDER"
same near.stipple far.stipple
! grep -aq secret "$FOLDER/far.stipple" || fail "the model has the address's query"

# A part is read from the tiles that it needs.
box=500,600,516,616
made "$set" part.stipple --bounds $box
stored=$(field points_out)
"$STIPPLE" info "$FOLDER/part.stipple" --json | found -F "\"bounds $box" || fail "the model says nothing of its part"
[ "$stored" -gt 50 ] && [ "$(field outside)" -gt 0 ] && [ "$(field points_in)" -lt 2000 ] ||
    fail "part: $(field points_in) read, $stored stored, $(field outside) outside"
: >"$FOLDER/access.log"
made "$web/a b/bowl/ept.json" far.stipple --bounds $box
same part.stipple far.stipple
! grep -q 'ept-data/2-3-3-' "$FOLDER/access.log" || fail "a tile far from the box was fetched"
made "$set" coarse.stipple --resolution 2
[ "$(field points_in)" = 1500 ] || fail "$(field points_in) points at a resolution of 2"

# Other scans are copied first.
made "$root/a.las" near.stipple
made "$web/a.las" far.stipple --temp "$FOLDER"
same near.stipple far.stipple
made "$root/b.xyz" near.stipple
made "$web/b.xyz" far.stipple
same near.stipple far.stipple

# Commands that draw take them, too; only the model of files is kept.
if "$STIPPLE" --help | found '^  render '; then
    export XDG_CACHE_HOME=$FOLDER/cache
    for from in "$set/ept.json" "$web/a b/bowl/ept.json" "$set"; do
        run "$STIPPLE" render "$from" -o "$FOLDER/next.png" --size 64x64 --quiet --force
        expect_code 0
        [ -e "$FOLDER/first.png" ] || cp "$FOLDER/next.png" "$FOLDER/first.png"
        same first.png next.png
    done
    [ "$(ls "$XDG_CACHE_HOME/stipple" | wc -l)" = 1 ] || fail "kept: $(ls "$XDG_CACHE_HOME/stipple")"
fi

failed() { # INPUT TEXT options...
    local input=$1 text=$2
    shift 2
    run "$STIPPLE" prep "$input" -o "$FOLDER/none.stipple" --quiet "$@"
    expect_failure "$text"
    [ ! -e "$FOLDER/none.stipple" ] || fail "$command: wrote a model"
}

failed "$web/none.las" "404"
failed "$web/none/ept.json" "404"
failed "$web/whole/a.las" "range"
failed "$web/a.las" "has no levels of detail" --resolution 1
failed "$set" "there is nothing to write" --bounds 0,0,1,1
run "$STIPPLE" prep "$set" -o "$FOLDER/none.stipple" --bounds 1,2,0,3
expect_failure "--bounds 1,2,0,3: give"
run "$STIPPLE" prep "$set" -o "$FOLDER/none.stipple" --resolution -1
expect_failure "--resolution -1: give a positive length"
missing=$(ls "$set/ept-data" | grep '^2-3-3-' | head -1)
rm "$set/ept-data/$missing"
failed "$web/a b/bowl/ept.json" "$missing"
failed "$set" "the EPT needs it"

run "$STIPPLE" info "$set/ept.json"
expect_failure "is a scan (EPT)"
[ -z "$(find "$FOLDER" -maxdepth 1 -name '*.part')" ] || fail "temporary files are left"
end_test
