#!/usr/bin/env bash
# Kills writing commands at 200 moments, and lets them write every format on 200 disks that are too small.
# A file under a final name must always be whole, and the next run must leave nothing but its own
# files. (long_prep_kills.sh kills prep while it has less memory than it wants.)
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
model="$FOLDER/m.stipple"
"$STIPPLE" gen statue -n 60000 --order random -o "$FOLDER/s.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/s.ply" -o "$model" --quiet || fail "no model"

# A model with one wrong bit, which repair flips back: in 1 s if the model is small.
"$STIPPLE" gen statue -n 10000 --order random -o "$FOLDER/h.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/h.ply" -o "$FOLDER/hurt.stipple" --quiet || fail "no model"
byte=$(od -An -tu1 -j20000 -N1 "$FOLDER/hurt.stipple")
# shellcheck disable=SC2059
printf "\\x$(printf %x $((byte ^ 4)))" | dd of="$FOLDER/hurt.stipple" bs=1 seek=20000 conv=notrunc status=none
"$STIPPLE" verify "$FOLDER/hurt.stipple" --quiet 2>/dev/null && fail "no damage"

made="$FOLDER/made"
mkdir "$made"
trap 'umount "$made" 2>/dev/null; rm -rf "$FOLDER"' EXIT
draws=0
"$STIPPLE" --help | found '^  render ' && draws=1

# commands[NAME] is the command that writes $made/NAME; {} stands for the folder.
declare -A commands=(
    [p.stipple]="prep $FOLDER/s.ply -o {}/p.stipple --force"
    [p.json]="prep $FOLDER/s.ply -o $FOLDER/p.stipple --stats {}/p.json --force"
    [c.stipple]="convert $model -o {}/c.stipple --codec zstd --force"
    [e.ply]="export $model -o {}/e.ply --force"
    [r.stipple]="verify $FOLDER/hurt.stipple --repair -o {}/r.stipple --force"
    [g.las]="gen sphere -n 100000 -o {}/g.las --force"
)
if [ $draws = 1 ]; then
    commands[t]="tune $model -o {}/t --force --size 64x64 --views 1 --repeat 1"
    commands[f]="fly $model --turntable 1 --rate 4 --size 64x64 --depth -o {}/f --force"
    commands[d.exr]="render $model -o $FOLDER/i.png --size 100x100 --depth {}/d.exr --force"
    for ending in png jpg tif bmp exr; do
        commands[i.$ending]="render $model -o {}/i.$ending --size 300x300 --force"
    done
    command -v ffmpeg >/dev/null && for ending in mp4 mov mkv webm; do
        commands[v.$ending]="fly $model --turntable 1 --rate 10 --size 200x200 -o {}/v.$ending --force"
    done
fi
each=$((200 / ${#commands[@]} + 1))

is_whole() { # path
    case $1 in
        *.stipple) "$STIPPLE" verify "$1" --quiet ;;
        *.ply | *.las) "$STIPPLE" prep "$1" -o "$FOLDER/check.stipple" --force --quiet ;;
        *.json) python3 -m json.tool "$1" >/dev/null ;;
        *.png | *.jpg | *.tif | *.bmp | *.exr) "$STIPPLE" compare "$1" "$1" >/dev/null ;;
        *.mp4 | *.mov | *.mkv | *.webm) ffmpeg -v error -xerror -i "$1" -f null - 2>/dev/null ;;
        */t) [ -s "$1/index.html" ] && [ -s "$1/tune.json" ] ;;
        *) false ;;
    esac
}

# Every file under a final name must be whole; a report as well.
check_whole() { # name, when
    local file
    for file in "$made/$1" "$made/f"/*; do
        [ ! -e "$file" ] || [ "$file" = "$made/f" ] || is_whole "$file" || fail "$2: $file is not whole"
    done
}

# Kills the command until `each` runs died of it, at moments all over its time.
kill_runs() { # name, milliseconds that a run takes, words of the command
    local name=$1 took=$2 killed=0 i child
    shift 2
    for ((i = 1; killed < each && i <= 4 * each; i++)); do
        [ $((i % 2)) = 0 ] && rm -rf "${made:?}"/*
        "$STIPPLE" "$@" --quiet >/dev/null 2>&1 &
        child=$!
        sleep "$(printf '%d.%03d' $((took * (i % each) / each / 1000)) $((took * (i % each) / each % 1000)))"
        kill -KILL $child 2>/dev/null
        wait $child 2>/dev/null
        [ $? = 137 ] && killed=$((killed + 1))
        check_whole "$name" "$name, kill $i"
    done
    kills=$((kills + killed))
    "$STIPPLE" "$@" --quiet >/dev/null || fail "the run after the kills: $*"
    [ "$(ls -A "$made")" = "$name" ] || fail "after kills: $(ls -A "$made")"
    check_whole "$name" "$name, after kills"
}

# Runs the command on disks that have from no free block up to almost what the output fills.
fill_disks() { # name, blocks that the output fills, words of the command
    local name=$1 size=$2 i left
    shift 2
    for ((i = 0; i < each; i++)); do
        mount -t tmpfs -o "size=$((4096 * (size * i / each + 1)))" stipple-test "$made" 2>/dev/null || return
        printf x >"$made/.other"
        run "$STIPPLE" "$@" --quiet
        [ "$code" = 0 ] || full=$((full + 1))
        [ "$code" -le 1 ] || fail "$name, disk $i: exit $code"
        [ "$code" = 0 ] || [ "$(wc -l <"$FOLDER/err")" = 1 ] || fail "$name, disk $i: $(head -3 "$FOLDER/err")"
        left=$(ls -A -I .other "$made")
        [ "$code" != 0 ] || [ "$left" = "$name" ] || fail "$name, disk $i: exit 0 and '$left'"
        [ "$code" = 0 ] || [ -z "$left" ] || [ "$left" = f ] || fail "$name, disk $i: exit $code and '$left'"
        check_whole "$name" "$name, disk $i"
        umount "$made" || fail "$name, disk $i: something still uses the disk"
    done
}

kills=0
full=0
for name in "${!commands[@]}"; do
    read -ra words <<<"${commands[$name]//\{\}/$made}"
    rm -rf "${made:?}"/*
    began=$(date +%s%N)
    "$STIPPLE" "${words[@]}" --quiet >/dev/null || fail "no run: ${words[*]}"
    kill_runs "$name" $((($(date +%s%N) - began) / 1000000)) "${words[@]}"
    blocks=$(find "$made" -type f -size +0 -printf '%s\n' | awk '{ n += int(($1 + 4095) / 4096) } END { print n }')
    fill_disks "$name" "$blocks" "${words[@]}"
    echo "$name: $kills kills and $full full disks so far, $failures wrong"
done
[ $kills -ge 200 ] || fail "only $kills runs were killed"
if [ $full = 0 ]; then
    echo "full disks are not tested: nothing can be mounted here"
elif [ $full -lt 200 ]; then
    fail "only $full disks were full"
fi
end_test
