#!/usr/bin/env bash
# Kills writing commands at 200 random moments, and fills 200 small disks with every output format.
# A file under a final name must always be whole, and the next run must leave nothing but its own
# files. (long_prep_kills.sh kills prep while it has less memory than it wants.)
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
model="$FOLDER/m.stipple"
"$STIPPLE" gen statue -n 60000 --order random -o "$FOLDER/s.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/s.ply" -o "$model" --quiet || fail "no model"
cp "$model" "$FOLDER/hurt.stipple"
printf 'damage' | dd of="$FOLDER/hurt.stipple" bs=1 seek=300000 conv=notrunc status=none
out="$FOLDER/out"
mkdir "$out"
draws=0
"$STIPPLE" --help | grep -q '^  render ' && draws=1

# commands[NAME] is the command that writes $out/NAME; {} stands for the folder.
declare -A commands=(
    [p.stipple]="prep $FOLDER/s.ply -o {}/p.stipple --force"
    [c.stipple]="convert $model -o {}/c.stipple --codec zstd --force"
    [e.ply]="export $model -o {}/e.ply --force"
    [r.stipple]="verify $FOLDER/hurt.stipple --repair -o {}/r.stipple --force"
    [g.las]="gen sphere -n 100000 -o {}/g.las --force"
)
if [ $draws = 1 ]; then
    commands[t]="tune $model -o {}/t --force --size 64x64 --views 1 --repeat 1"
    commands[f]="fly $model --turntable 1 --rate 4 --size 64x64 -o {}/f --force"
    commands[i.png]="render $model -o {}/i.png --size 300x300 --force"
    command -v ffmpeg >/dev/null &&
        commands[v.mp4]="fly $model --turntable 1 --rate 10 --size 200x200 -o {}/v.mp4 --force"
fi

# If the file exists under its final name, it must be whole.
check_whole() { # name, when
    [ -e "$out/$1" ] || return 0
    case $1 in
        *.stipple) "$STIPPLE" verify "$out/$1" --quiet || fail "$2: $1 is not sound" ;;
        *.ply | *.las) "$STIPPLE" prep "$out/$1" -o "$FOLDER/check.stipple" --force --quiet ||
            fail "$2: $1 cannot be read" ;;
        *.png) "$STIPPLE" compare "$out/$1" "$out/$1" >/dev/null || fail "$2: $1 cannot be read" ;;
        *.mp4) ffmpeg -v error -xerror -i "$out/$1" -f null - 2>/dev/null || fail "$2: $1 cannot be read" ;;
        t) [ -s "$out/t/index.html" ] && [ -s "$out/t/tune.json" ] || fail "$2: half a report" ;;
        f) for picture in "$out"/f/*.png; do
            [ ! -e "$picture" ] || "$STIPPLE" compare "$picture" "$picture" >/dev/null ||
                fail "$2: $picture cannot be read"
        done ;;
    esac
}

kills=0
for name in "${!commands[@]}"; do
    read -ra words <<<"${commands[$name]//\{\}/$out}"
    rm -rf "${out:?}"/*
    began=$(date +%s%N)
    "$STIPPLE" "${words[@]}" --quiet >/dev/null || fail "no run: ${words[*]}"
    took=$((($(date +%s%N) - began) / 1000000))
    each=$((200 / ${#commands[@]} + 1))
    for i in $(seq $each); do
        [ $((i % 2)) = 0 ] && rm -rf "${out:?}"/*
        "$STIPPLE" "${words[@]}" --quiet >/dev/null 2>&1 &
        child=$!
        milliseconds=$((took * i / each))
        sleep "$((milliseconds / 1000)).$(printf %03d $((milliseconds % 1000)))"
        kill -KILL $child 2>/dev/null && kills=$((kills + 1))
        wait $child 2>/dev/null
        check_whole "$name" "kill $i"
    done
    "$STIPPLE" "${words[@]}" --quiet >/dev/null || fail "the run after the kills: ${words[*]}"
    [ "$(ls -A "$out")" = "$name" ] || fail "after kills: $(ls -A "$out")"
    check_whole "$name" "after kills"
    size=$(du -sB4096 "$out" | cut -f1)
    for i in $(seq $each); do
        mount -t tmpfs -o "size=$((4096 * (size * i / each + 1)))" stipple-test "$out" 2>/dev/null || break
        run "$STIPPLE" "${words[@]}" --quiet
        [ "$code" = 0 ] || [ "$(wc -l <"$FOLDER/err")" = 1 ] || fail "$name: $(head -3 "$FOLDER/err")"
        left=$(ls -A "$out")
        [ "$code" != 0 ] || [ "$left" = "$name" ] || fail "disk $i: exit 0 and '$left'"
        [ "$code" = 0 ] || [ -z "$left" ] || [ "$left" = f ] || fail "disk $i: exit $code and '$left'"
        check_whole "$name" "disk $i"
        umount "$out"
    done
done
echo "$kills kills"
[ $kills -ge 100 ] || fail "only $kills runs were killed"
end_test
