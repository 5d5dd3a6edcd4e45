# shellcheck shell=bash disable=SC2154
# Helpers of test_real_scans.sh and long_real_scans.sh: every file of the folder STIPPLE_SCANS must be
# prepared, verified and drawn, or refused with the right sentence. Source it after shell.sh.

model=$FOLDER/model.stipple
picture=$FOLDER/picture.png

# Prints a part of the sentence with which prep refuses this file; empty: prep reads it.
refusal_of() { # name within the folder
    case $1 in
        odd/empty.ply | odd/pdal_no-points.las) echo 'has no points: there is nothing to write' ;;
        *_color.png | *_texture.png) echo 'is a picture of colours' ;;
        */ept.json) ;;
        *.jpg | *.json) echo 'which is not read here' ;;
        *README*) echo 'is of no known format' ;;
    esac
}

# Prints how a scan must first be seen (from its scanner, inside, or whole: its metadata name no view then), and how its
# normals are turned if that is by the scanner's position.
first_view_of() { # name
    case $1 in
        grids/office1.pcd | grids/milk_cartoon_all_small_clorox.pcd) echo 'scanner position' ;;
        stanford/bun000.ply | meshlab-rangemaps/lato315.ply) echo 'scanner' ;;
        rooms/room-3.23M-rgb.ply) echo 'interior' ;;
        open3d/fragment.pcd | lidar/FSite8_orig-utm.pcd | lidar/CSite2_orig-utm.pcd | lidar/autzen_trim_7.las | \
            odd/ColouredCubeFloat.e57 | stanford/bun_zipper.ply | stanford-dragon/dragon_vrip.ply | \
            lion/lion_takanawa_342k_rgb_n.ply | tree/tls-spruce-83k.las | tree/eztree_oak_large.obj) echo 'whole' ;;
    esac
}

check_first_view() { # name
    local wanted found
    wanted=$(first_view_of "$1")
    [ -n "$wanted" ] || return 0
    found=$("$STIPPLE" info --json "$model" | awk -F '"' '
        $2 == "why" { why = $4 }
        $2 == "orientation" { orientation = $4 == "position" ? " position" : "" }
        END { print (why ? why : "whole") orientation }')
    [ "$found" = "$wanted" ] || fail "$1: seen first: $found, expected: $wanted"
}

check_prep() { # name: every point is stored or rejected by name, and the model is sound
    local read stored rejected triangles
    read=$(field points_in)
    stored=$(field points_out)
    triangles=$(sed -n 's/.*"triangles":[[:space:]]*\([0-9]*\),$/\1/p' "$FOLDER/stats.json")
    rejected=$(sed -n '/"rejected"/,/}/s/.*:[[:space:]]*\([0-9]*\),\{0,1\}$/\1/p' "$FOLDER/stats.json" | paste -sd+ -)
    [ $((read + ${triangles:-0})) -gt 0 ] && [ "$read" = $((stored + ${rejected:-0})) ] ||
        fail "$1: $read points read, $stored stored and $rejected rejected"
    run "$STIPPLE" verify "$model"
    expect_code 0
    expect_text out ": sound: $((stored + 3 * ${triangles:-0})) points" # corners are points, too
}

draw() { # options
    run "$STIPPLE" render "$model" -o "$picture" --force --quiet --aa none --size 256x256 --stats "$FOLDER/stats.json" "$@"
    expect_code 0
    grep -q '"cut_complete":[[:space:]]*true' "$FOLDER/stats.json" || fail "$command: the cut is not complete"
}

# The default view must show something. No sample may be coarser than the threshold allows unless
# there is no finer one. Every sample must make the same picture by either road; if few directions are
# asked for, every third scan shows that.
check_picture() { # name
    local error
    draw
    "$STIPPLE" compare "$picture" "$picture" --json 2>/dev/null | found '"coverage_a": 0*\.*0*[1-9]' ||
        fail "$1: the picture is empty"
    error=$(field max_error_px)
    if [ "$directions" != 26 ] && [ $((drawn % 3)) != 0 ] && awk -v error="$error" 'BEGIN { exit !(error <= 1) }'; then
        return
    fi
    draw --threshold 0
    awk -v error="$error" -v finest="$(field max_error_px)" \
        'BEGIN { exit !(error <= 1 || error <= finest) }' || fail "$1: an error of $error px is drawn, 1 is the threshold"
    mv "$picture" "$FOLDER/every.png"
    draw --lod full
    cmp -s "$picture" "$FOLDER/every.png" || fail "$1: --lod full and --threshold 0 differ"
}

# Writes cameras as a path of `fly`, one second each: $directions of the 26 around the box (faces,
# edges and corners of a cube), then three eyes inside. Writes also a clip box that ends in the
# middle.
write_views() {
    "$STIPPLE" info --json "$model" | tr -d '[]' | awk -F '[:,]' -v count="$directions" -v clip="$FOLDER/clip" '
        function point(x, y, z) { return sprintf("[%.12g, %.12g, %.12g]", x, y, z) }
        function view(eye, look, up) {
            printf "%s{\"time\": %d, \"eye\": %s, \"look\": %s, \"up\": %s}", n ? ",\n" : "", n, eye, look, up
            n++
        }
        /"box_min"/ { for (i = 1; i <= 3; i++) low[i] = $(i + 1) }
        /"box_max"/ { for (i = 1; i <= 3; i++) high[i] = $(i + 1) }
        END {
            for (i = 1; i <= 3; i++) { mid[i] = (low[i] + high[i]) / 2; side[i] = high[i] - low[i] }
            away = sqrt(side[1] ^ 2 + side[2] ^ 2 + side[3] ^ 2) / 2 / sin(atan2(1, 1) / 2)
            middle = point(mid[1], mid[2], mid[3])
            printf "{\"keyframes\": ["
            for (k = 0; k < 27; k++) {
                x = k % 3 - 1; y = int(k / 3) % 3 - 1; z = int(k / 9) - 1
                size = sqrt(x * x + y * y + z * z)
                if (size == 0 || int((k + 1) * count / 27) == int(k * count / 27) && count < 26)
                    continue
                view(point(mid[1] + away * x / size, mid[2] + away * y / size, mid[3] + away * z / size), middle,
                    x || z ? "[0, 1, 0]" : "[0, 0, 1]")
            }
            for (i = -1; i <= 1; i++)
                view(point(mid[1] + i * side[1] / 4, mid[2] + i * side[2] / 8, mid[3] + i * side[3] / 8),
                    i ? middle : point(mid[1] - side[1] / 4, mid[2], mid[3]), "[0, 0, 1]")
            print "]}"
            printf "%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", low[1], low[2], low[3], mid[1], high[2], high[3] >clip
        }' >"$FOLDER/views.json"
}

fly() { # model, folder, options
    local from=$1 to=$2
    shift 2
    run "$STIPPLE" fly "$from" --path "$FOLDER/views.json" --rate 1 -o "$FOLDER/$to" --force --quiet \
        --aa none --size "${width}x$width" "$@"
    expect_code 0
}

# Four million samples of a mesh's surface say what a picture must cover.
fly_truth() { # name
    local mesh=$1
    [ "$1" != odd/bunny_nan_inf_dup.ply ] || mesh=stanford/bun_zipper.ply # has its vertices
    [ -d "$FOLDER/truth" ] && return
    "$STIPPLE" prep "$STIPPLE_SCANS/$mesh" --sample 4M -o "$FOLDER/dense.stipple" --force --quiet 2>/dev/null || return
    fly "$FOLDER/dense.stipple" truth --cull none --threshold 0
}

# Whether `--cull auto` covers 99.9 % of the true surface and of the pixels within its outline.
# `none` may cover more, since the discs of backs reach beyond the outline.
is_true() { # name, frame
    fly_truth "$1" || return
    "$STIPPLE" compare "$FOLDER/auto/$2" "$FOLDER/truth/$2" --json |
        awk -v width="$width" -F '[:,]' 'BEGIN { bad = 1 }
            { bad = $12 > 0.001 * $10 * width * width || $8 < 0.999 * $10 }
            END { exit bad }'
}

# Culling must not uncover a pixel: in each view `--cull auto` must cover 99.9 % of what `--cull
# none` covers, or, for a mesh, of the true surface. In small pictures outlines may differ by a
# pixel, because that is a larger share of all pixels.
check_cull() { # name, options
    local name=$1 cull frame figures
    shift
    rm -rf "$FOLDER/truth"
    for cull in none auto; do
        fly "$model" $cull --cull $cull "$@"
    done
    for frame in "$FOLDER/none"/*.png; do
        cmp -s "$FOLDER/auto/${frame##*/}" "$frame" && continue
        run "$STIPPLE" compare "$FOLDER/auto/${frame##*/}" "$frame" --json
        grep -q 'neither picture covers a pixel' "$FOLDER/err" ||
            awk -F '[:,]' -v width="$width" 'BEGIN { bad = 1 }
                { bad = $12 > 0.001 * $10 * width * width || (width >= 1024 && $8 < 0.999 * $10) }
                END { exit bad }' "$FOLDER/out" ||
            { figures=$(cat "$FOLDER/out") && [ $# = 0 ] && is_true "$name" "${frame##*/}"; } ||
            fail "$name $*: ${frame##*/}: --cull auto leaves out what --cull none shows: $figures"
    done
}

# Scans that the gate leaves to long runs, because it tries another one of the same kind.
is_left_out() { # name
    [ "$directions" != 26 ] || return
    case $1 in
        lidar/CSite2_orig-utm.pcd | grids/office1.pcd | grids/aloeGT_disparity.png) ;;
        *) false ;;
    esac
}

check_file() { # name
    local sentence options=()
    sentence=$(refusal_of "$1")
    # an EPT's coarse levels do for the gate; test_scan_ept reads the others
    [[ $directions = 26 || $1 != */ept.json ]] || options=(--resolution 2)
    run "$STIPPLE" prep "$STIPPLE_SCANS/$1" -o "$model" --force --quiet --stats "$FOLDER/stats.json" "${options[@]}"
    if [ -n "$sentence" ]; then
        expect_failure "$sentence"
        expect_text err "$1"
        return
    fi
    expect_code 0
    [ "$code" = 0 ] || return
    drawn=$((drawn + 1))
    check_prep "$1"
    check_first_view "$1"
    check_picture "$1"
    # if few directions are asked for, every third scan, another one than in check_picture, is seen from them
    [ "$directions" = 26 ] || [ $((drawn % 3)) = 1 ] || return
    write_views
    check_cull "$1"
    [ "$directions" != 26 ] || check_cull "$1" --clip "$(cat "$FOLDER/clip")"
}

check_folder() { # find's test of the size; for check_cull how many directions, and the pictures' width
    local file seconds
    drawn=0 directions=$2 width=$3
    [ -n "${STIPPLE_SCANS:-}" ] || skip_test "STIPPLE_SCANS names no folder of real scans"
    "$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
    while IFS= read -r -d '' file; do
        is_left_out "${file#"$STIPPLE_SCANS"/}" && continue
        seconds=$SECONDS
        printf '%s: ' "${file#"$STIPPLE_SCANS"/}"
        check_file "${file#"$STIPPLE_SCANS"/}"
        echo "$((SECONDS - seconds)) s"
    done < <( # tiles of an EPT are read with its ept.json
        find -L "$STIPPLE_SCANS" -type f -size "$1" -not -path '*/ept-data/*' -print0 | sort -z
    )
    echo "$drawn scans drawn"
    [ "$drawn" != 0 ] || fail "$STIPPLE_SCANS has no scan of this size"
}
