#!/usr/bin/env bash
# Tests stipple fly: its frames equal render's, ffprobe understands its films, runs that end early
# can continue, and failures are explained.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  fly ' || skip_test "built without the renderer"
model="$FOLDER/módel a.stipple"
path="$FOLDER/path.json"
frames="$FOLDER/frames"

# Makes a walk of 13 frames at 10 per second; the third keyframe is frame 13.
make_inputs() {
    "$STIPPLE" gen bumpy -n 100000 -o "$FOLDER/scan.ply" --quiet &&
        "$STIPPLE" prep "$FOLDER/scan.ply" -o "$model" --quiet ||
        { fail "no model"; end_test; }
    cat >"$path" <<'END'
{"keyframes": [
 {"time": 0, "eye": [3, 0, 1], "look": [0, 0, 0], "up": [0, 0, 1], "fovy_deg": 45},
 {"time": 0.5, "eye": [0, 3, 1], "look": [0, 0, 0]},
 {"time": 1.2, "eye": [-1.5, -0.5, 0.5], "look": [0, 0.25, 0], "fovy_deg": 60}]}
END
}

# As run, but removes the progress that appears on slow machines.
run_fly() { # command
    run "$@"
    sed -i '/^frames: /d' "$FOLDER/err"
}

fly() { # output, options
    local output=$1
    shift
    run_fly "$STIPPLE" fly "$model" --path "$path" --rate 10 --size 96x64 -o "$output" "$@"
}

count() { # files of a pattern in a folder
    find "$1" -maxdepth 1 -name "$2" | wc -l
}

same_frames() { # folder: holds what $frames holds
    local name
    for name in "$frames"/frame_*; do
        cmp -s "$name" "$1/${name##*/}" || fail "$command: ${name##*/} differs from the frame of a single run"
    done
    [ "$(count "$1" 'frame_*')" = "$(count "$frames" 'frame_*')" ] || fail "$command: more frames"
    [ "$(count "$1" '*.part')" = 0 ] || fail "$command: litter in $(ls "$1")"
}

test_frames() {
    fly "$frames" --depth --normals --stats "$FOLDER/stats.json"
    expect_code 0
    expect_empty out
    expect_empty err
    [ "$(count "$frames" 'frame_0000??.png')" = 13 ] || fail "$command: $(count "$frames" '*.png') frames"
    [ "$(field frames)" = 13 ] || fail "stats: $(field frames) frames"
    for key in seconds frame_ms project_ms points_drawn cut_complete max_error_px gl_renderer; do
        grep -q "\"$key\":" "$FOLDER/stats.json" || fail "$command: no \"$key\" in the stats"
    done
    # the last keyframe must equal render's picture, depth and normals
    run "$STIPPLE" render "$model" --eye=-1.5,-0.5,0.5 --look 0,0.25,0 --up 0,0,1 --fovy 60 \
        --size 96x64 -o "$FOLDER/last.png" --depth "$FOLDER/d.exr" --normals "$FOLDER/n.exr"
    expect_code 0
    cmp -s "$FOLDER/last.png" "$frames/frame_000013.png" || fail "not the picture of render"
    cmp -s "$FOLDER/d.exr" "$frames/frame_000013_depth.exr" || fail "not the depths of render"
    cmp -s "$FOLDER/n.exr" "$frames/frame_000013_normals.exr" || fail "not the normals of render"
    cmp -s "$frames/frame_000001.png" "$frames/frame_000002.png" && fail "the camera does not move"
    expect_outline "$frames/frame_000001.png" smooth
    fly "$FOLDER/hard" --aa none --frames 1
    expect_outline "$FOLDER/hard/frame_000001.png" hard
    fly "$FOLDER/chosen" --where 'z>0' --frames 13
    run "$STIPPLE" render "$model" --eye=-1.5,-0.5,0.5 --look 0,0.25,0 --up 0,0,1 --fovy 60 \
        --size 96x64 -o "$FOLDER/chosen.png" --where 'z>0'
    cmp -s "$FOLDER/chosen.png" "$FOLDER/chosen/frame_000013.png" || fail "--where: not the picture of render"
    cmp -s "$FOLDER/chosen.png" "$FOLDER/last.png" && fail "--where chooses nothing"
    # everything is there: fly must make nothing and say so
    fly "$frames" --depth --normals
    expect_code 0
    expect_text err "13 frames were there already, 0 are new"
    fly "$frames" --quiet
    expect_code 0
    expect_empty err
}

# Parts of the film, made in any order, must equal those of the whole.
test_parts() {
    fly "$FOLDER/parts" --frames 9: --depth --normals
    expect_code 0
    [ "$(count "$FOLDER/parts" '*.png')" = 5 ] || fail "$command: $(ls "$FOLDER/parts")"
    fly "$FOLDER/parts" --frames 4 --depth --normals
    [ "$(count "$FOLDER/parts" '*.png')" = 6 ] || fail "$command: $(ls "$FOLDER/parts")"
    fly "$FOLDER/parts" --depth --normals
    expect_text err "6 frames were there already, 7 are new"
    same_frames "$FOLDER/parts"
    # a frame that lost a part must be made again
    rm "$FOLDER/parts/frame_000005_depth.exr"
    fly "$FOLDER/parts" --depth --normals --frames :6
    expect_text err "5 frames were there already, 1 are new"
    same_frames "$FOLDER/parts"
}

# Waits until a folder has this number of frames; fails after a minute.
wait_for_frames() { # folder, number
    local i
    for ((i = 0; i < 600; i++)); do
        [ -d "$1" ] && [ "$(count "$1" '*.png')" -ge "$2" ] && return 0
        sleep 0.1
    done
    return 1
}

# A signal ends the run in its middle; the next run must complete it to the same bytes. A run that
# was complete before the signal proves nothing and does not count.
test_ended() { # signal
    local process folder="$FOLDER/ended $1" before
    "$STIPPLE" fly "$model" --path "$path" --rate 10 --size 96x64 -o "$folder" --depth --normals \
        --threads 1 >/dev/null 2>"$FOLDER/err" </dev/null &
    process=$!
    wait_for_frames "$folder" 3 || fail "no frames within a minute"
    kill "-$1" $process
    wait $process
    code=$?
    command="fly, ended by $1"
    before=$(count "$folder" '*.png')
    if [ "$1" = INT ] && [ "$code" != 0 ]; then
        expect_code 1
        expect_text err "$before of 13 frames done: the same command goes on"
    fi
    [ "$code" = 0 ] && echo "not interrupted: the run had ended before"
    fly "$folder" --depth --normals
    expect_code 0
    [ "$before" = 13 ] || expect_text err "$before frames were there already"
    same_frames "$folder"
}

test_other_job() {
    local words
    for words in "--threshold 2" "--shade normal" "--size 97x64" "--rate 5"; do
        # shellcheck disable=SC2086
        fly "$frames" $words
        expect_failure "another job"
        expect_text err "--force"
    done
    "$STIPPLE" gen bumpy -n 2000 -o "$FOLDER/other.ply" --quiet
    "$STIPPLE" prep "$FOLDER/other.ply" -o "$FOLDER/other.stipple" --quiet
    run_fly "$STIPPLE" fly "$FOLDER/other.stipple" --path "$path" --rate 10 --size 96x64 -o "$frames"
    expect_failure "another job (model"
    # budgets, threads and file names may not change a pixel
    cp "$model" "$FOLDER/same.stipple"
    run_fly "$STIPPLE" fly "$FOLDER/same.stipple" --path "$path" --rate 10 --size 96x64 -o "$frames" \
        --gpu-memory 64M --threads 1
    expect_code 0
    cp -r "$frames" "$FOLDER/forced"
    echo mine >"$FOLDER/forced/frame_notes.png"
    fly "$FOLDER/forced" --threshold 2 --force --frames 1:2
    expect_code 0
    [ "$(count "$FOLDER/forced" 'frame_0*')" = 2 ] || fail "$command: $(ls "$FOLDER/forced")"
    [ "$(cat "$FOLDER/forced/frame_notes.png")" = mine ] || fail "$command: took a file that is not its own"
    rm "$FOLDER/forced/fly.json"
    fly "$FOLDER/forced" --threshold 2
    expect_failure "no fly.json"
    echo '{' >"$FOLDER/forced/fly.json"
    fly "$FOLDER/forced" --threshold 2
    expect_failure "fly.json"
}

expect_film() { # file, width, height, frames
    local probe
    expect_code 0
    expect_empty err
    probe=$(ffprobe -v error -count_frames -select_streams v -of csv=p=0 \
        -show_entries stream=width,height,pix_fmt,r_frame_rate,nb_read_frames "$1")
    [ "$probe" = "$2,$3,yuv420p,10/1,$4" ] || fail "$command: ffprobe says $probe"
}

test_films() {
    if ! command -v ffmpeg >/dev/null || ! command -v ffprobe >/dev/null; then
        echo "films are not tested: ffmpeg is not installed"
        return
    fi
    fly "$FOLDER/film é.mp4"
    expect_film "$FOLDER/film é.mp4" 96 64 13
    fly "$FOLDER/again.mp4"
    cmp -s "$FOLDER/again.mp4" "$FOLDER/film é.mp4" || fail "$command: not the same bytes"
    fly "$FOLDER/film é.mp4"
    expect_failure "exists already"
    fly "$FOLDER/film.mkv" --size 33x31 --frames 2:4
    expect_film "$FOLDER/film.mkv" 34 32 3
    fly "$FOLDER/film.webm" --frames 1:3
    expect_film "$FOLDER/film.webm" 96 64 3
    (cd "$FOLDER" && "$STIPPLE" fly "$model" --turntable 1 --rate 10 --size 16x16 -o -film.MOV) ||
        fail "a name that begins with a minus"
    [ -s "$FOLDER/-film.MOV" ] || fail "no film of a name that begins with a minus"
    # the colours of frame 5, as far as compression keeps them
    ffmpeg -v error -nostdin -i "$FOLDER/film é.mp4" -vf 'select=eq(n\,4)' -frames:v 1 \
        "$FOLDER/five.png" </dev/null
    run "$STIPPLE" compare "$FOLDER/five.png" "$frames/frame_000005.png" --json
    awk -v p="$(sed -n 's/.*"psnr_db": \([0-9.]*\).*/\1/p' "$FOLDER/out")" 'BEGIN { exit !(p > 30) }' ||
        fail "the film's fifth frame is another: $(cat "$FOLDER/out")"
}

# Tests fly without ffmpeg, and with an ffmpeg that fails at once, after a while, or at the end.
test_no_film() {
    local empty="$FOLDER/bin" script
    mkdir "$empty"
    run_fly env PATH="$empty" "$STIPPLE" fly "$model" --path "$path" --size 8x8 -o "$FOLDER/none.mp4"
    expect_failure "not installed"
    expect_text err "PNG"
    for script in 'echo sorry, no codec >&2; exit 7' 'head -c 300 >/dev/null; echo sorry, no codec >&2; exit 7' \
        'cat >/dev/null; echo sorry, no codec >&2; exit 7' 'kill -9 $$'; do
        printf '#!/bin/sh\nPATH=%s\n%s\n' "$PATH" "$script" >"$empty/ffmpeg"
        chmod +x "$empty/ffmpeg"
        run_fly env PATH="$empty" "$STIPPLE" fly "$model" --path "$path" --rate 10 --size 99x99 -o "$FOLDER/none.mp4"
        expect_failure "none.mp4: ffmpeg failed"
        [ "$script" = 'kill -9 $$' ] || expect_text err "sorry, no codec"
    done
    [ "$(count "$FOLDER" 'none.mp4*')" = 0 ] || fail "left $(ls "$FOLDER"/none.mp4*)"
}

# Ctrl-C while ffmpeg hangs.
test_film_ended() {
    local process
    # this ffmpeg says that it runs, and then takes no frame
    # shellcheck disable=SC2016
    printf '#!/bin/sh\nPATH=%s\n: >"$STARTED"\nexec sleep 600\n' "$PATH" >"$FOLDER/bin/ffmpeg"
    STARTED="$FOLDER/started" PATH="$FOLDER/bin" "$STIPPLE" fly "$model" --path "$path" \
        --size 512x512 -o "$FOLDER/none.mp4" >/dev/null 2>"$FOLDER/err" </dev/null &
    process=$!
    for _ in $(seq 600); do
        [ -e "$FOLDER/started" ] && break
        sleep 0.1
    done
    sleep 1
    kill -INT $process
    wait $process
    code=$?
    command="fly to a film, ended"
    expect_code 1
    expect_text err "interrupted"
    [ "$(count "$FOLDER" 'none.mp4*')" = 0 ] || fail "left $(ls "$FOLDER"/none.mp4*)"
}

test_paths() {
    run_fly "$STIPPLE" fly "$model" --turntable 1 --rate 4 --size 32x32 -o "$FOLDER/turn" --eye 3,0,0 \
        --look 0,0,0 --up 0,0,1
    expect_code 0
    [ "$(count "$FOLDER/turn" '*.png')" = 4 ] || fail "$command: $(ls "$FOLDER/turn")"
    run "$STIPPLE" render "$model" --eye 0,3,0 --look 0,0,0 --up 0,0,1 --size 32x32 -o "$FOLDER/quarter.png"
    run "$STIPPLE" compare "$FOLDER/quarter.png" "$FOLDER/turn/frame_000002.png" --json
    awk -v p="$(sed -n 's/.*"psnr_db": \([0-9.]*\).*/\1/p' "$FOLDER/out")" \
        'BEGIN { exit !(p == "" || p > 40) }' || fail "a quarter of a turn is $(cat "$FOLDER/out")"
    echo '{"keyframes": [{"time": 0, "eye": [0, 0, 3]}]}' >"$FOLDER/bad.json"
    run_fly "$STIPPLE" fly "$model" --path "$FOLDER/bad.json" -o "$FOLDER/none"
    expect_failure 'bad.json: keyframe 1: "look" is missing'
    run_fly "$STIPPLE" fly "$model" --path "$FOLDER/none.json" -o "$FOLDER/none"
    expect_failure "none.json"
    fly "$FOLDER/none" --frames 1:14
    expect_failure "frames 1 to 13"
    fly "$FOLDER/none" --rate 0.5 --frames 7:
    expect_failure "frames 1 to 2"
    [ ! -e "$FOLDER/none" ] || fail "a folder was made without frames"
}

test_usage() {
    run_fly "$STIPPLE" fly "$model" --turntable 1
    expect_usage "-o F.mp4"
    run_fly "$STIPPLE" fly "$model" -o "$FOLDER/none"
    expect_usage "--path"
    fly "$FOLDER/none" --turntable 3
    expect_usage "--turntable"
    for words in "--rate 0" "--rate 1e9" "--frames 0:3" "--frames 3:2" "--frames x" "--frames 1:2:3" \
        "--threshold -1" "--turntable 0"; do
        # shellcheck disable=SC2086
        run_fly "$STIPPLE" fly "$model" -o "$FOLDER/none" --path "$path" $words
        expect_usage "${words%% *}"
    done
    for name in film.gif film.avi frame.png; do
        fly "$FOLDER/$name"
        expect_usage "$name"
    done
    fly "$FOLDER/none.mp4" --depth
    expect_usage "--depth"
    fly "$FOLDER/scan.ply"
    expect_failure "scan.ply is a file"
    fly "$FOLDER/none/folder"
    expect_failure "none/folder"
    run "$STIPPLE" render "$model" -o "$FOLDER/a.png" --depth "$FOLDER/a.png"
    expect_usage ".exr"
    run "$STIPPLE" render "$model" -o "$FOLDER/a.png" --depth "$FOLDER/a.exr" --normals "$FOLDER/a.exr"
    expect_failure "written twice"
}

# Writes frames to a small file system mounted with these options; lists what is left there in
# $FOLDER/out.
fly_mounted() { # mount options
    # shellcheck disable=SC2016
    run_fly unshare -rm sh -c 'mount -t tmpfs -o "$1" none "$0" && shift && "$@" && exit 0
        code=$?; ls "$0"; exit $code' "$FOLDER/mounted" "$1" "$STIPPLE" fly "$model" --path "$path" \
        --rate 10 --size 200x200 -o "$FOLDER/mounted"
    expect_code 1
    expect_lines err 1
}

# A read-only folder, and a full disk.
test_no_room() {
    mkdir "$FOLDER/mounted"
    # shellcheck disable=SC2016
    if ! unshare -rm sh -c 'mount -t tmpfs -o size=64k none "$0"' "$FOLDER/mounted" 2>/dev/null; then
        echo "read-only folders and full disks are not tested: nothing can be mounted here"
        return
    fi
    fly_mounted size=64k
    expect_text err "the disk is full"
    grep -q '^frame_000001.png$' "$FOLDER/out" || fail "$command: not one frame"
    grep -q 'part$' "$FOLDER/out" && fail "$command: litter on a full disk"
    fly_mounted ro
    expect_text err "mounted/"
    expect_text err "Read-only"
    expect_empty out
}

# If a chunk is damaged, only that chunk is lost: its parent is drawn, and fly says so.
test_damage() {
    local size at said
    size=$(stat -c %s "$model")
    for ((at = size - 3000; at > 0; at -= 1500)); do
        cp "$model" "$FOLDER/damaged.stipple"
        printf '\xff\x00\xff\x00' | dd of="$FOLDER/damaged.stipple" bs=1 seek=$at conv=notrunc status=none
        said=$("$STIPPLE" verify "$FOLDER/damaged.stipple" 2>&1 || true)
        [[ $said == *'chunk '[1-9]* ]] && break
    done
    run_fly "$STIPPLE" fly "$FOLDER/damaged.stipple" --turntable 1 --rate 4 --size 64x64 --threshold 0 \
        -o "$FOLDER/damaged" --quiet
    expect_failure "--allow-damage"
    [ "$(count "$FOLDER/damaged" '*.png')" -lt 4 ] || fail "$command: all frames were drawn though the model is damaged"
    run_fly "$STIPPLE" fly "$FOLDER/damaged.stipple" --turntable 1 --rate 4 --size 64x64 --threshold 0 \
        -o "$FOLDER/damaged" --allow-damage --quiet
    expect_code 0
    expect_lines err 1
    expect_text err "its parent is drawn instead"
    [ "$(count "$FOLDER/damaged" '*.png')" = 4 ] || fail "$command: $(ls "$FOLDER/damaged")"
}

make_inputs
test_frames
test_parts
test_ended KILL
test_ended INT
test_other_job
test_films
test_no_film
test_film_ended
test_paths
test_usage
test_no_room
test_damage
end_test
