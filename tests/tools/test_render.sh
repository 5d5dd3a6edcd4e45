#!/usr/bin/env bash
# Tests stipple render: pictures, figures, budgets, cameras, damage, and messages of failures.
# Each value of each option is drawn; long runs draw more combinations.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
model="$FOLDER/model.stipple"
picture="$FOLDER/picture.png"

render() { # model, options: to $picture
    local file=$1
    shift
    run "$STIPPLE" render "$file" -o "$picture" --force "$@"
}

expect_picture() { # width, height: of $picture, from its PNG header
    expect_code 0
    expect_empty out
    local width height
    read -r width height < <(od -An -tu4 --endian=big -j16 -N8 "$picture")
    [ "$width $height" = "$1 $2" ] || fail "$command: the picture is $width $height, expected $1 $2"
}

# Prints the share of covered pixels of $picture, in millionths.
coverage() {
    "$STIPPLE" compare "$picture" "$picture" --json 2>/dev/null | # reports an empty picture on stderr
        awk 'match($0, /"coverage_a": [0-9.]*/) { printf "%d\n", 1e6 * substr($0, RSTART + 14, RLENGTH - 14) + 0.5 }'
}

expect_coverage() { # least, most in millionths
    local covered
    covered=$(coverage)
    covered=${covered:-0}
    [ "$covered" -ge "$1" ] && [ "$covered" -le "$2" ] ||
        fail "$command: $covered millionths are covered, expected $1 to $2"
}

same_picture() { # name kept by keep
    cmp -s "$picture" "$FOLDER/$1.png" || fail "$command: not the picture of $1"
}
keep() { cp "$picture" "$FOLDER/$1.png"; }

stat_of() { # key: of $FOLDER/stats.json
    sed -n "s/.*\"$1\":[[:space:]]*\([^,]*\),*$/\1/p" "$FOLDER/stats.json"
}

make_models() {
    "$STIPPLE" gen sphere -n 300000 -o "$FOLDER/scan.ply" --quiet &&
        "$STIPPLE" prep "$FOLDER/scan.ply" -o "$model" --quiet ||
        { fail "no model"; end_test; }
}

# What a scan without colours has is what a picture shows: intensities, else classes, if they differ.
test_own_colours() {
    local header shown
    while read -r header shown; do
        awk -v header="$header" 'BEGIN {
            gsub(",", " ", header); print header
            for (i = 0; i < 40; i++) for (j = 0; j < 40; j++)
                print i * 0.1, j * 0.1, 0.05 * i % 2, (header ~ /same/ ? (j > 34 ? i : 50) : 10 + i % 7 * 30), i % 2 ? 2 : 6 }' |
            sed s/same/intensity/ >"$FOLDER/own.txt"
        "$STIPPLE" prep "$FOLDER/own.txt" -o "$FOLDER/own.stipple" --force --quiet || fail "no model of $header"
        render "$FOLDER/own.stipple" --size 64x64 --colour "$shown"
        keep own
        render "$FOLDER/own.stipple" --size 64x64
        expect_picture 64 64
        same_picture own
        [ "$shown" = rgb ] && continue
        render "$FOLDER/own.stipple" --size 64x64 --colour rgb
        cmp -s "$picture" "$FOLDER/own.png" && fail "$header: shown like a model that has none"
    done <<'TABLE'
x,y,z,intensity,class intensity
x,y,z,same,class class
x,y,z,same,_ rgb
TABLE
}

# A sphere must fill the smaller side of its ball's picture; the ball of the box is sqrt(3) times
# larger.
test_pictures() {
    render "$model"
    expect_picture 1024 1024
    render "$model" --size 256x256
    expect_picture 256 256
    expect_empty err
    expect_coverage 200000 320000
    keep plain
    if is_long; then
        render "$model" --size 256x256
        same_picture plain
    fi
    render "$model" --size 256x256 --threads 1
    same_picture plain
    for size in "1 1" "1 7" "333 5" "31 257" "2 1024"; do
        # shellcheck disable=SC2086
        set -- $size
        render "$model" --size "$1x$2"
        expect_picture "$1" "$2"
        expect_coverage 1 1000000
    done
    local reconstructs=(box points template3 template5 template7 splat)
    if is_long; then
        for reconstruct in "${reconstructs[@]}"; do
            render "$model" --size 64x64 --reconstruct "$reconstruct"
            expect_picture 64 64
            expect_coverage 100000 320000
        done
        reconstructs=()
    fi
    # each with the next reconstruction; points alone leave gaps
    for shade in phong lambert normal depth level chunk error confidence primitive; do
        reconstruct=${reconstructs[0]:-gauss}
        reconstructs=("${reconstructs[@]:1}")
        render "$model" --size 64x64 --shade $shade --reconstruct "$reconstruct"
        expect_picture 64 64
        if [ "$reconstruct" = points ]; then expect_coverage 100000 320000; else expect_coverage 200000 320000; fi
    done
}

test_smooth_edges() {
    local before=default
    render "$model" --size 32x32
    expect_outline "$picture" smooth
    keep default
    for aa in edges none 2 3 4; do
        render "$model" --size 32x32 --aa $aa --stats "$FOLDER/stats.json"
        expect_picture 32 32
        expect_coverage 100000 320000
        [ $aa = edges ] && same_picture default
        [ $aa = none ] && expect_outline "$picture" hard
        if [ $aa != edges ] && cmp -s "$picture" "$FOLDER/$before.png"; then
            fail "$command: the picture of $before"
        fi
        before=$aa
        keep "$aa"
    done
    render "$model" --size 64x64 --aa 5
    expect_usage "--aa takes one of none|edges|2|3|4"
}

test_roads() {
    for lod in geometry cpu full compute; do
        render "$model" --size 256x256 --lod $lod --threshold 0
        expect_picture 256 256
        [ $lod = geometry ] && keep every
        same_picture every
    done
    render "$model" --size 256x256 --lod full --threshold 4
    same_picture every
    local threshold lods=compute
    for threshold in 0.5 2 16; do
        render "$model" --size 256x256 --threshold $threshold
        keep chosen
        if [ $lods = cpu ]; then lods=compute; else lods=cpu; fi
        is_long && lods='cpu compute'
        for lod in $lods; do
            render "$model" --size 256x256 --threshold $threshold --lod $lod
            same_picture chosen
        done
    done
}

# A budget that holds only a part of the model: more passes, the same picture.
test_budget() {
    local passes
    render "$model" --size 256x256 --lod full --stats "$FOLDER/stats.json"
    keep full
    [ "$(stat_of passes)" = 1 ] || fail "$command: $(stat_of passes) passes with 1 GiB"
    for memory in 1500K 2M; do
        local lods='full cpu'
        [ $memory = 1500K ] || lods='geometry compute'
        is_long && lods='full geometry cpu compute'
        for lod in $lods; do
            render "$model" --size 256x256 --lod $lod --threshold 0 --gpu-memory $memory \
                --stats "$FOLDER/stats.json"
            expect_picture 256 256
            same_picture full
            passes=$(stat_of passes)
            [ "${passes:-0}" -ge 2 ] || fail "$command: ${passes} passes with a budget of $memory"
            [ "$(stat_of cut_complete)" = true ] || fail "$command: the cut is not complete"
        done
    done
    render "$model" --size 256x256 --cpu-memory 12M
    same_picture plain
    rm "$picture"
    render "$model" --gpu-memory 1K
    expect_failure "--gpu-memory"
    [ ! -e "$picture" ] || fail "$command: left a picture"
}

test_stats() {
    render "$model" --size 200x200 --repeat 3 --stats "$FOLDER/stats.json"
    expect_code 0
    for key in frame_ms project_ms pull_push_ms shade_ms points_drawn patches_drawn patches_hidden blocks_hidden chunks_drawn \
        chunks_missing cut_complete max_error_px bytes_read gpu_bytes_used gpu_bytes_pinned \
        gpu_bytes_allotted gl_renderer min median p99 max; do
        grep -q "\"$key\":" "$FOLDER/stats.json" || fail "$command: no \"$key\" in the stats"
    done
    [ "$(stat_of chunks_missing)" = 0 ] || fail "$command: chunks_missing $(stat_of chunks_missing)"
    awk -v e="$(stat_of max_error_px)" 'BEGIN { exit !(e > 0 && e <= 1) }' ||
        fail "$command: max_error_px $(stat_of max_error_px) at a threshold of 1"
    awk -v a="$(stat_of min)" -v b="$(stat_of median)" -v c="$(stat_of p99)" -v d="$(stat_of max)" \
        'BEGIN { exit !(0 < a && a <= b && b <= c && c <= d) }' || fail "$command: frame_ms not in order"
    local drawn
    drawn=$(stat_of points_drawn)
    render "$model" --size 200x200 --lod full --stats "$FOLDER/stats.json"
    [ "$(stat_of points_drawn)" -gt "$drawn" ] || fail "$command: no more points than at 1 px"
    [ "$(stat_of points_drawn)" -le 300000 ] || fail "$command: more points than there are"
}

test_cameras() {
    local text
    echo '{"eye": [0, 0, 5], "look": [0, 0, 0], "up": [0, 1, 0], "height": 4, "size": [96, 64]}' \
        >"$FOLDER/camera.json"
    render "$model" --camera "$FOLDER/camera.json"
    expect_picture 96 64
    # a unit sphere, 16 pixels per unit: pi * 16 * 16 of 96 * 64 pixels
    expect_coverage 115000 150000
    render "$model" --camera "$FOLDER/camera.json" --size 64x64
    expect_picture 64 64
    render "$model" --eye 0,0,3 --look 0,0,9 --size 64x64
    expect_picture 64 64
    expect_coverage 0 0
    render "$model" --eye 0,0,0 --look 0,0,1 --size 64x64
    expect_picture 64 64
    render "$model" --eye 0,5,0 --look 0,0,0 --size 64x64
    expect_failure "--up"
    render "$model" --eye 1,1,1 --look 1,1,1
    expect_failure "the camera's eye"
    render "$model" --fovy 180
    expect_failure "180"
    render "$model" --colour elevation --palette heat --size 64x64
    expect_picture 64 64
    render "$model" --color elevation --colour-range -1,1.5e3 --size 64x64
    expect_picture 64 64
    render "$model" --colour intensity
    expect_failure "--colour intensity: the model has none"
    render "$model" --colour class
    expect_failure "--colour class: the model has no classes"
    for text in 1 1,0 1,2,3 0,nan x,y; do
        render "$model" --colour elevation --colour-range "$text"
        expect_failure "--colour-range $text"
    done
    for text in '' '{' '[]' '{"eye": [0, 0]}' '{"up": "y"}' '{"fovy_deg": "40"}' '{"size": [1, -1]}' \
        '{"look": [0, 0, null]}' '{"size": [1e9, 1]}'; do
        echo "$text" >"$FOLDER/bad.json"
        render "$model" --camera "$FOLDER/bad.json"
        expect_failure "bad.json"
    done
    render "$model" --camera "$FOLDER/none.json"
    expect_failure "none.json"
}

# Clip box, classes, eye-dome lighting, overlays: what remains of the picture, and what is refused.
test_filters() {
    local text whole along_z=(--size 64x64 --eye 0,0,4 --look 0,0,0 --up 0,1,0)
    render "$model" "${along_z[@]}"
    whole=$(coverage)
    render "$model" "${along_z[@]}" --clip -2,-2,-2,2,0,2
    expect_picture 64 64
    expect_coverage $((whole * 2 / 5)) $((whole * 3 / 5))
    render "$model" "${along_z[@]}" --clip -2,-2,-2,2,2,0 --cull back # the far half shows its back
    expect_coverage 0 $((whole / 2))
    render "$model" "${along_z[@]}" --clip -2,-2,-2,2,2,0
    expect_coverage $((whole * 8 / 10)) "$whole"
    render "$model" "${along_z[@]}" --clip -0.1,-0.1,-0.1,0.1,0.1,0.1 # inside the hollow sphere
    expect_picture 64 64
    expect_coverage 0 0
    for text in 1 1,2,3,4,5 0,0,0,1,1,nan 0,0,0,1,1,inf 1,0,0,0,1,1 0,0,0,1,1,1,1 5,5,5,6,6,6; do
        render "$model" --clip "$text"
        expect_failure "--clip $text"
    done
    local looks=("--edl=0.5 --shade error --overlay 0.4" "--edl --shade confidence --overlay 1" "--edl 2" "--edl 0")
    ! is_long || looks+=(--edl --edl=0.5 "--shade error --overlay 0.4")
    for text in "${looks[@]}"; do
        # shellcheck disable=SC2086
        render "$model" "${along_z[@]}" $text
        expect_picture 64 64
        expect_coverage "$whole" "$whole"
    done
    render "$model" --overlay 0.5
    expect_failure "--overlay"
    render "$model" --shade level --overlay 1.5
    expect_failure "--overlay 1.5"
    render "$model" --edl -1
    expect_failure "--edl -1"
    render "$model" --classes 2
    expect_failure "--classes: the model has no classes"
}

test_classes() {
    local sheet="$FOLDER/sheet.stipple" whole words along_z=(--size 64x64 --eye 0,0,4 --look 0,0,0 --up 0,1,0)
    "$STIPPLE" gen sheet -n 20000 --normals -o "$FOLDER/sheet.ply" --quiet &&
        "$STIPPLE" prep "$FOLDER/sheet.ply" -o "$sheet" --quiet || fail "no sheet"
    render "$sheet" "${along_z[@]}" --cull back # shows class 1; class 2 is the other side
    whole=$(coverage)
    local lists=("--classes unclassified,ground" "--hide-classes 2,Low-Vegetation")
    ! is_long || lists+=("--classes 1" "--hide-classes ground")
    for words in "${lists[@]}"; do
        # shellcheck disable=SC2086
        render "$sheet" "${along_z[@]}" --cull back $words
        expect_coverage "$whole" "$whole"
    done
    lists=("--classes 2" "--hide-classes 1,2")
    ! is_long || lists+=("--hide-classes 1")
    for words in "${lists[@]}"; do
        # shellcheck disable=SC2086
        render "$sheet" "${along_z[@]}" --cull back $words
        expect_picture 64 64
        expect_coverage 0 0
    done
    for text in 256 -1 1,,2 1, 1.5 grund; do
        render "$sheet" --classes "$text"
        expect_failure "--classes $text"
    done
    render "$sheet" --classes 1 --hide-classes 2
    expect_failure "--hide-classes"
}

test_usage() {
    run "$STIPPLE" render "$model"
    expect_usage "-o I.png"
    for words in "--sharpness 3" "--lod best" "--size 0x5" "--size 5" "--threshold -1" \
        "--threshold nan" "--repeat 1e9" "--eye 1,2" "--gpu-memory x"; do
        # shellcheck disable=SC2086
        render "$model" $words
        expect_usage "${words%% *}"
    done
    render "$model" --edl=x
    expect_usage "--edl takes a number or nothing"
    render "$model" --clip=
    expect_usage "--clip takes a text"
    echo kept >"$picture"
    run "$STIPPLE" render "$model" -o "$picture" --size 8x8
    expect_failure "exists"
    [ "$(cat "$picture")" = kept ] || fail "$command: the existing picture is gone"
    run "$STIPPLE" render "$model" -o "$FOLDER/none/picture.png" --size 8x8
    expect_failure "none/picture.png"
    run "$STIPPLE" render "$model" -o "$FOLDER/picture.xyz" --size 8x8
    expect_failure "picture.xyz"
    render "$model" --size 8x8 --shaders "$FOLDER/nowhere"
    expect_failure "nowhere"
}

damage() { # byte, of damaged.stipple
    cp "$model" "$FOLDER/damaged.stipple"
    local old
    old=$(od -An -tu1 -j"$1" -N1 "$model")
    printf "\\x$(printf %02x $((old ^ 255)))" |
        dd of="$FOLDER/damaged.stipple" bs=1 seek="$1" conv=notrunc status=none
}

# Prints the number of the chunk that verify finds damaged.
damaged_chunk() {
    "$STIPPLE" verify "$FOLDER/damaged.stipple" 2>&1 | sed -n 's/.*: chunk \([0-9]*\): .*/\1/p'
}

test_damage() {
    local size at root= child=
    size=$(stat -c %s "$model")
    for ((at = size - 100; at > 0 && (${#root} == 0 || ${#child} == 0); at -= 4500)); do
        damage $at
        case $(damaged_chunk) in
            '') ;;
            0) root=$at ;;
            *) child=$at ;;
        esac
    done
    [ -n "$root" ] && [ -n "$child" ] || { fail "no byte of a root, or of a child, was found"; return; }
    damage "$root"
    rm -f "$picture"
    render "$FOLDER/damaged.stipple" --size 256x256
    expect_failure "chunk 0"
    [ ! -e "$picture" ] || fail "$command: left a picture"
    damage "$child"
    for lod in full geometry cpu compute; do
        if is_long || [ $lod = full ] || [ $lod = compute ]; then
            rm -f "$picture"
            render "$FOLDER/damaged.stipple" --size 256x256 --threshold 0 --lod $lod --quiet
            expect_failure "--allow-damage"
            [ ! -e "$picture" ] || fail "$command: a picture that lacks a chunk"
        fi
        render "$FOLDER/damaged.stipple" --size 256x256 --threshold 0 --lod $lod --allow-damage --quiet
        expect_picture 256 256
        expect_lines err 1
        expect_text err "warning"
        expect_text err "parent"
        # the whole sphere is still there, but changed
        expect_coverage 200000 320000
        cmp -s "$picture" "$FOLDER/every.png" && fail "$command: the picture does not show the damage"
        [ $lod = full ] && keep damaged
        same_picture damaged
    done
    run "$STIPPLE" render "$FOLDER/damaged.stipple" -o "$picture" --force --quiet --size 64x64
    expect_code 0
    expect_empty err
    head -c $((size - 500)) "$model" >"$FOLDER/damaged.stipple"
    render "$FOLDER/damaged.stipple"
    expect_failure "damaged.stipple"
}

# The depths of a picture are a depth camera's image: prepared again, the sphere's near side lies where it was.
test_depths_are_a_scan() {
    render "$model" --size 200x200 --eye 0,0,3 --look 0,0,0 --up 0,1,0 --fovy 45 --depth "$FOLDER/depth.exr"
    expect_code 0
    run "$STIPPLE" prep "$FOLDER/depth.exr" --pinhole 241.42,241.42,99.5,99.5 -o "$FOLDER/depth.stipple" --quiet
    expect_code 0
    "$STIPPLE" info --json "$FOLDER/depth.stipple" | tr -d '[]' | awk -F '[:,]' '
        /"box_min"/ { for (i = 1; i <= 3; i++) low[i] = $(i + 1) }
        /"box_max"/ { for (i = 1; i <= 3; i++) high[i] = $(i + 1) }
        END { exit !(low[1] < -0.9 && low[1] > -1.02 && high[2] > 0.9 && high[2] < 1.02 && low[3] > 1.98 && low[3] < 2.02 &&
                     high[3] > 2.5 && high[3] < 3) }' || fail "$command: not the near side of the sphere"
}

test_contours() {
    render "$model" --size 128x128 --contours 0.25
    expect_picture 128 128
    keep lines
    render "$model" --size 128x128 --contours 0.25,0.1
    expect_picture 128 128
    cmp -s "$picture" "$FOLDER/lines.png" && fail "$command: the picture of another base"
    for text in 0 -1 x 1, 1,2,3 nan; do
        render "$model" --contours=$text
        expect_failure "--contours $text"
    done
}

test_light() {
    render "$model" --size 128x128
    keep camera
    render "$model" --size 128x128 --light 315,45
    expect_picture 128 128
    cmp -s "$picture" "$FOLDER/camera.png" && fail "$command: the picture of a light at the camera"
    for text in 315 x,1 1,91 1,2,3 nan,1; do
        render "$model" --light=$text
        expect_failure "--light $text"
    done
}

# Scans of very few points.
test_tiny() {
    local name points
    declare -A scans=(
        [one]="0 0 0" [far]="4e5 5e6 30" [two]=$'0 0 0\n1 0 0' [three]=$'0 0 0\n1 0 0\n0 1 0'
        [equal]=$'1 2 3\n1 2 3\n1 2 3\n1 2 3\n1 2 3' [line]=$'0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0'
    )
    scans[plane]=$(for i in $(seq 0 899); do echo "$((i % 30)) $((i / 30)) 0"; done)
    for name in "${!scans[@]}"; do
        points=${scans[$name]}
        printf 'ply\nformat ascii 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\nend_header\n%s\n' \
            "$(wc -l <<<"$points")" "$points" >"$FOLDER/$name.ply"
        run "$STIPPLE" prep "$FOLDER/$name.ply" -o "$FOLDER/$name.stipple" --quiet
        expect_code 0
        local some=("--size 64x64" "--size 5x99 --lod full")
        if [[ $name = one || $name = equal || $name = plane ]]; then
            some+=("--size 1x1 --lod cpu" "--size 64x64 --shade error --reconstruct box")
            ! is_long || some+=("--size 1x1" "--size 64x64 --lod cpu" "--size 64x64 --shade error" "--size 64x64 --reconstruct box")
        fi
        for options in "${some[@]}"; do
            # shellcheck disable=SC2086
            render "$FOLDER/$name.stipple" $options --stats "$FOLDER/stats.json"
            expect_code 0
            expect_empty err
            expect_coverage 1 1000000
            grep -qE 'null|nan|inf' "$FOLDER/stats.json" &&
                fail "$command: not a number in the stats: $(grep -E 'null|nan|inf' "$FOLDER/stats.json")"
        done
    done
}

# The halves are those of two pictures, but for the two columns of the divider.
test_beside() {
    local y at
    local view=(--size 60x40)
    beside_one() { # name, model, options
        run "$STIPPLE" render "$2" -o "$FOLDER/$1.ppm" --force "${view[@]}" "${@:3}"
        expect_code 0
    }
    beside_one left "$model" --colour elevation
    beside_one right "$model" --colour elevation --shade normal
    beside_one both "$model" --colour elevation --beside "--shade normal"
    for y in 0 17 20 39; do
        at=$((13 + 180 * y)) # the header, and bytes of a row
        cmp -s -i $at -n $((3 * 29)) "$FOLDER/both.ppm" "$FOLDER/left.ppm" || fail "row $y: the left half is another"
        cmp -s -i $((at + 3 * 31)) -n $((3 * 29)) "$FOLDER/both.ppm" "$FOLDER/right.ppm" ||
            fail "row $y: the right half is another"
        [ "$(od -An -tu1 -j $((at + 3 * 29)) -N 6 "$FOLDER/both.ppm" | tr -s ' ')" = " 0 0 0 255 255 255" ] ||
            fail "row $y: no divider"
    done
    cmp -s "$FOLDER/left.ppm" "$FOLDER/right.ppm" && fail "--shade normal changes nothing"
    "$STIPPLE" gen plane -n 20000 -o "$FOLDER/plane.ply" --quiet
    "$STIPPLE" prep "$FOLDER/plane.ply" -o "$FOLDER/plane.stipple" --quiet
    view+=(--eye 1,-3,2 --look 0,0,0 --up 0,0,1)
    beside_one left "$model"
    beside_one right "$FOLDER/plane.stipple" --threshold 2
    beside_one both "$model" --beside "$FOLDER/plane.stipple --threshold 2"
    at=$((13 + 180 * 20))
    cmp -s -i $((at + 3 * 31)) -n $((3 * 29)) "$FOLDER/both.ppm" "$FOLDER/right.ppm" || fail "the second model is not at the right"
    render "$model" --beside "--shade normal" --stats "$FOLDER/stats.json"
    expect_usage "--beside is for one picture"
    render "$model" --beside "--size 3x3"
    expect_usage "--size"
    render "$model" --beside "$FOLDER/none.stipple"
    expect_failure "none.stipple"
}

test_no_gl() {
    rm -f "$picture"
    run env __EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent "$STIPPLE" render "$model" -o "$picture"
    expect_failure "OpenGL 4.5"
    run env MESA_GL_VERSION_OVERRIDE=3.3 "$STIPPLE" render "$model" -o "$picture"
    expect_failure "OpenGL 4.5"
    [ ! -e "$picture" ] || fail "without OpenGL, a picture"
}

make_models
test_own_colours
test_pictures
test_smooth_edges
test_roads
test_budget
test_stats
test_cameras
test_filters
test_classes
test_usage
test_damage
test_depths_are_a_scan
test_contours
test_light
test_tiny
test_beside
test_no_gl
end_test
