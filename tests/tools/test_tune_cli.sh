#!/usr/bin/env bash
# Tests stipple tune: a report with consistent figures, well-formed files, solvers that reach their
# goals, and messages of failures.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  tune ' || skip_test "built without the renderer"
model="$FOLDER/módel a.stipple"
report="$FOLDER/re port"
"$STIPPLE" gen bumpy -n 60000 -o "$FOLDER/scan.ply" --quiet &&
    "$STIPPLE" prep "$FOLDER/scan.ply" -o "$model" --quiet || { fail "no model"; end_test; }

tune() { # output, options
    local output=$1
    shift
    run "$STIPPLE" tune "$model" -o "$output" --size 96x96 --views 3 --reference 2 --repeat 1 \
        --thresholds 0,0.5,2,8 --quiet "$@"
}

# Prints the number of a key of a threshold in tune.json. cJSON writes one number per line.
figure() { # threshold's place from 1, key
    grep -o "\"$2\":[[:space:]]*[-0-9.e+]*" "$report/tune.json" | sed -n "$1s/.*:[[:space:]]*//p"
}

thousands() { sed -E ':more; s/^([0-9]+)([0-9]{3})/\1,\2/; t more' <<<"$1"; }
drawn() { printf '%.0f' "$(figure "$1" points)"; } # mean points of a threshold's place

holds() { # what, awk's condition
    awk "BEGIN { exit !($2) }" || fail "$1: not $2"
}

test_report() {
    tune "$report"
    expect_code 0
    expect_empty err
    [ "$(ls "$report" | tr '\n' ' ')" = \
        "index.html popping.svg promise.svg quality.svg times.svg tune.csv tune.json " ] ||
        fail "$command: wrote $(ls "$report")"
    [ "$(find "$FOLDER" -name '*.part' -o -name '*.old' | wc -l)" = 0 ] || fail "litter"
    [ "$(wc -l <"$report/tune.csv")" = 13 ] || fail "$(wc -l <"$report/tune.csv") lines of CSV"
    awk -F, 'NR == 1 { n = NF } NF != n || n != 29 { exit 1 }' "$report/tune.csv" ||
        fail "a row of the CSV does not have the fields of its head"
    [ "$(grep -c '^ *[0-9]' "$FOLDER/out")" = 4 ] || fail "the table: $(cat "$FOLDER/out")"
    [ "$(grep -c '^recommended: --threshold [0-9.]*: ' "$FOLDER/out")" = 1 ] || fail "no threshold is recommended"
    grep -q '<strong>recommended: --threshold ' "$report/index.html" || fail "the page recommends no threshold"
    for text in 'popping     what changes' 'Why 0 px may score below 0.5 px: ' " $(thousands "$(drawn 1)") "; do
        expect_text out "$text"
    done
    for text in '<strong>popping</strong>: what' 'Why 0 px may score below' "<td>$(thousands "$(drawn 1)")<"; do
        grep -qF -- "$text" "$report/index.html" || fail "no '$text' on the page"
    done
    # points fall as the threshold rises; quality is best with all points, apart from the smoothing
    # of merging
    for place in 2 3 4; do
        holds "points" "$(figure $place points) <= 1.01 * $(figure $((place - 1)) points)"
        holds "quality" "$(figure $place psnr_db) <= $(figure 1 psnr_db) + 0.3"
        holds "the promise" "$(figure $place measured_px) <= $(figure $place threshold_px)"
        holds "the rule" "$(figure $place predicted_px) <= $(figure $place threshold_px)"
        holds "the bound" "$(figure $place measured_px) <= $(figure $place predicted_px)"
        holds "discs" "$(figure $place discs_measured) > 100 && $(figure $place measured_px) > 0"
        holds "discs beyond" "$(figure $place discs_beyond_threshold) == 0"
    done
    # the row of every sample has no error and no extra change
    holds "every sample's normals" "$(figure 1 normal_mean_deg) < 0.01"
    holds "every sample's change" "$(figure 1 frame_change_extra) < 0.01"
    holds "a change" "$(figure 4 frame_change_extra) > 0.1"
}

test_well_formed() {
    local svg
    if command -v python3 >/dev/null; then
        python3 - "$report" <<'END' || fail "python finds errors in the report"
import csv, html.parser, json, sys, xml.dom.minidom
folder = sys.argv[1]
with open(folder + "/tune.json") as f:
    found = json.load(f)
assert len(found["views"]) == 3 and len(found["settings"][0]["thresholds"]) == 4
rows = list(csv.DictReader(open(folder + "/tune.csv")))
assert len(rows) == 12 and all(float(r["psnr_db"]) > 0 for r in rows)
for name in ("quality", "times", "promise", "popping"):
    xml.dom.minidom.parse(f"{folder}/{name}.svg")
class Page(html.parser.HTMLParser):
    void, stack, pictures = ("meta", "img", "input"), [], 0
    def handle_starttag(self, tag, attributes):
        link = dict(attributes).get("src", dict(attributes).get("href", "data:"))
        assert link.startswith("data:"), link
        self.pictures += tag == "img" and "src" in dict(attributes)
        if tag not in self.void:
            self.stack.append(tag)
    def handle_endtag(self, tag):
        assert tag in self.void or self.stack.pop() == tag, tag
page = Page()
page.feed(open(folder + "/index.html").read())
assert not page.stack and page.pictures == 3 * (1 + 2 * 3), page.pictures
END
    fi
    grep -qE '(src|href)="http' "$report/index.html" && fail "the page asks for the network"
    if command -v xmllint >/dev/null; then
        for svg in "$report"/*.svg; do
            xmllint --noout "$svg" || fail "$svg is no XML"
        done
    fi
}

# The solvers must reach a quality between two thresholds of the sweep and a given memory, and name
# impossible goals. With --save, render must draw with the solved threshold.
test_solvers() {
    local psnr bytes
    psnr=$(figure 3 psnr_db)
    psnr=$(awk "BEGIN { print ($psnr + $(figure 4 psnr_db)) / 2 }")
    cp "$model" "$FOLDER/saved.stipple"
    model="$FOLDER/saved.stipple" tune "$FOLDER/solved" --psnr "$psnr" --save
    expect_code 0
    awk "BEGIN { exit !($(sed -n 's/^threshold \([0-9.]*\) px.*/\1/p' "$FOLDER/out") > 0) }" ||
        fail "no threshold: $(cat "$FOLDER/out")"
    holds "solved" "$(sed -n 's/^threshold .*: psnr \([0-9.]*\), .*/\1/p' "$FOLDER/out") - $psnr < 0.5"
    holds "solved" "$psnr - $(sed -n 's/^threshold .*: psnr \([0-9.]*\), .*/\1/p' "$FOLDER/out") < 0.5"
    run "$STIPPLE" info "$FOLDER/saved.stipple" --json
    grep -q "\"threshold_px\":" "$FOLDER/out" || fail "the model has no threshold"
    run "$STIPPLE" verify "$FOLDER/saved.stipple" --quiet
    expect_code 0
    bytes=$(figure 1 gpu_bytes)
    tune "$FOLDER/solved" --force --bytes $((2 * bytes)) --thresholds 0,2
    expect_code 0
    expect_text out "threshold 0 px: bytes $(thousands "$bytes"), asked for $(thousands $((2 * bytes)))"
    grep -q '"solved"' "$FOLDER/solved/tune.json" || fail "no answer in the JSON"
    tune "$FOLDER/none" --psnr 90 --views 1
    expect_failure "--psnr: 90.00 dB cannot be reached with these views: thresholds from 0 to"
    tune "$FOLDER/none" --fps 1e9 --views 1
    expect_failure "frames a second cannot be reached"
    [ ! -e "$FOLDER/none" ] || fail "a report was written though the goal cannot be reached"
}

test_default() {
    tune "$FOLDER/marked" --thresholds 0,1 --views 1
    expect_code 0
    [ "$(grep -c 'default$' "$FOLDER/out")" = 1 ] && grep -q '^ *1 .* default$' "$FOLDER/out" ||
        fail "the default is not marked: $(cat "$FOLDER/out")"
    grep -qF '<td>1 (default)<' "$FOLDER/marked/index.html" || fail "the page marks no default"
}

test_settings() {
    tune "$FOLDER/two" --compare gauss,points --thresholds 0.5,2 --views 1
    expect_code 0
    expect_text out "at equal points"
    grep -q '"equal_points"' "$FOLDER/two/tune.json" || fail "no equal points"
    [ "$(wc -l <"$FOLDER/two/tune.csv")" = 5 ] || fail "rows of two settings"
    tune "$FOLDER/terms" --terms --thresholds 0.5,2 --views 1
    expect_code 0
    for name in rule none radius colour silhouette all; do
        [ "$(grep -c "^$name," "$FOLDER/terms/tune.csv")" = 2 ] || fail "--terms: no rows of $name"
    done
}

test_views() {
    echo '{"keyframes": [{"time": 0, "eye": [3, 0, 1], "look": [0, 0, 0], "up": [0, 0, 1]},
        {"time": 1, "eye": [0, 3, 1], "look": [0, 0, 0]}]}' >"$FOLDER/path.json"
    tune "$FOLDER/path" --path "$FOLDER/path.json" --thresholds 1 --views 1
    expect_code 0
    grep -q ',path at 0.50 s,' "$FOLDER/path/tune.csv" || fail "no view in the middle of the path"
    tune "$FOLDER/eye" --eye 3,1,1 --look 0,0,0 --thresholds 1
    expect_code 0
    [ "$(wc -l <"$FOLDER/eye/tune.csv")" = 2 ] || fail "tune used other views than the given camera's"
}

test_refusals() {
    tune "$report"
    expect_failure "exists: give another folder, or --force"
    echo mine >"$report/mine.txt"
    tune "$report" --force
    expect_failure "holds mine.txt, which is not of a report"
    [ "$(cat "$report/mine.txt")" = mine ] || fail "a file that is not ours is gone"
    rm "$report/mine.txt"
    tune "$model"
    expect_failure "is a file: give -o a folder"
    tune "$FOLDER/no/where"
    expect_failure "the folder cannot be made"
    run "$STIPPLE" tune http://127.0.0.1:1/m.stipple -o "$FOLDER/x" --save --psnr 20
    expect_failure "is on a server: --save cannot change it"
    run "$STIPPLE" tune "$model"
    expect_usage "-o DIR is missing"
    tune "$FOLDER/x" --threshold 1
    expect_usage "--thresholds"
    tune "$FOLDER/x" --thresholds 1,1
    expect_usage "--thresholds 1,1"
    tune "$FOLDER/x" --lod full
    expect_usage "--lod full"
    tune "$FOLDER/x" --fps 10 --psnr 30
    expect_usage "give one of"
    tune "$FOLDER/x" --save
    expect_usage "--save"
    tune "$FOLDER/x" --compare gauss,blur
    expect_usage "--compare"
    tune "$FOLDER/x" --terms --compare gauss,splat
    expect_usage "--terms"
    tune "$FOLDER/x" --error-terms colour,colour
    expect_failure "--error-terms colour,colour"
    tune "$FOLDER/x" --error-terms hue
    expect_failure "--error-terms hue"
    tune "$FOLDER/x" --views 0
    expect_usage "--views"
    [ ! -e "$FOLDER/x" ] || fail "a refused request wrote"
}

# A model of one point, and a model of lines alone, where no disc is measured.
test_small() {
    printf '%s\n' '0 0 0' >"$FOLDER/point.xyz"
    "$STIPPLE" prep "$FOLDER/point.xyz" -o "$FOLDER/point.stipple" --quiet || fail "no point"
    run "$STIPPLE" tune "$FOLDER/point.stipple" -o "$FOLDER/point" --size 64x64 --views 2 \
        --thresholds 0,1 --repeat 1 --quiet
    expect_code 0
    printf 'v %d 0 0\n' 0 1 2 3 4 5 6 7 >"$FOLDER/line.obj"
    echo 'l 1 2 3 4 5 6 7 8' >>"$FOLDER/line.obj"
    "$STIPPLE" prep "$FOLDER/line.obj" -o "$FOLDER/line.stipple" --quiet || fail "no line"
    run "$STIPPLE" tune "$FOLDER/line.stipple" -o "$FOLDER/line" --size 64x64 --views 2 \
        --thresholds 0,1 --repeat 1 --quiet
    expect_code 0
    awk '/^ *[0-9]/ && ($11 != "-" || $12 != "-") { exit 1 }' "$FOLDER/out" ||
        fail "a line was measured: $(cat "$FOLDER/out")"
    [ "$(grep -c '"measured_px":[[:space:]]*null' "$FOLDER/line/tune.json")" -gt 0 ] &&
        ! grep -q '"measured_px":[[:space:]]*[0-9]' "$FOLDER/line/tune.json" ||
        fail "measured_px is a number without discs"
    ! grep -q '"median":[[:space:]]*[0-9]' "$FOLDER/line/tune.json" || fail "a ratio was computed without discs"
    [ "$(tail -1 "$FOLDER/line/tune.csv" | cut -d, -f27-29)" = "0,," ] ||
        fail "$(tail -1 "$FOLDER/line/tune.csv")"
    grep -q '<td>-</td>' "$FOLDER/line/index.html" || fail "the page has a number without discs"
}

# Ctrl-C must leave nothing behind.
test_interrupted() {
    "$STIPPLE" tune "$model" -o "$FOLDER/cut" --quiet 2>"$FOLDER/err" &
    local pid=$!
    sleep 1
    kill -INT $pid
    wait $pid
    [ $? = 1 ] || fail "an interrupted run does not exit 1"
    expect_text err "interrupted: nothing was written"
    [ -z "$(ls -d "$FOLDER"/cut* 2>/dev/null)" ] || fail "left $(ls -d "$FOLDER"/cut*)"
}

test_report
test_well_formed
test_solvers
test_default
test_settings
test_views
test_refusals
test_small
test_interrupted
end_test
