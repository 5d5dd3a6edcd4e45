#!/usr/bin/env bash
# Tests many inputs for one model: files, folders, patterns and lists. Every record is accounted
# for, by file and index if asked; reports can be read by programs.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
scans="$FOLDER/scäns here"
mkdir -p "$scans/b/c" "$scans/.hidden" "$FOLDER/none"

ply() { # number of vertices; then their lines on stdin
    printf 'ply\nformat ascii 1.0\nelement vertex %s\n' "$1"
    printf 'property float x\nproperty float y\nproperty float z\nend_header\n'
    cat
}

"$STIPPLE" gen sphere -n 1000 -o "$scans/a.ply" --quiet
"$STIPPLE" gen torus -n 2000 -o "$scans/b/b.PLY" --quiet
ply 4 <<<$'0 0 0\nnan 0 1\n1 1 1\ninf 2 2' >"$scans/b/c/bad, \"q\".ply"
ply 3 <<<$'0 0 nan\n0 0 2\n1 1 1' >"$scans/b/c/bed.ply"
ply 1 <<<'5 5 5' >"$scans/.hidden/not.ply"
echo no scan >"$scans/readme.md"

# prepared READ STORED INPUT...: prep must report these numbers of points.
prepared() {
    local read=$1 stored=$2
    shift 2
    run "$STIPPLE" prep "$@" -o "$FOLDER/m.stipple" --force --stats "$FOLDER/stats.json"
    expect_code 0
    expect_text err "$read points read, $stored stored, $((read - stored)) rejected"
    grep -q "\"points_in\":[[:space:]]*$read,\$" "$FOLDER/stats.json" || fail "$*: points_in"
    grep -q "\"points_out\":[[:space:]]*$stored,\$" "$FOLDER/stats.json" || fail "$*: points_out"
    grep -q "\"not_finite\":[[:space:]]*$((read - stored)),\$" "$FOLDER/stats.json" ||
        fail "$*: rejected"
}

prepared 3007 3004 "$scans"
cp "$FOLDER/m.stipple" "$FOLDER/folder.stipple"
prepared 3007 3004 "$scans/a.ply" "$scans/b/b.PLY" "$scans"/b/c/*
cmp -s "$FOLDER/m.stipple" "$FOLDER/folder.stipple" || fail "a folder's model is not that of its files in order of their names"
prepared 3007 3004 "$scans/[ab]*"
prepared 7 4 "$scans/b/c/b?d*.ply"
printf '# a list\r\n\r\nscäns here/a.ply\r\nscäns here/b\r\n' >"$FOLDER/list.txt"
prepared 3007 3004 "@$FOLDER/list.txt"
cmp -s "$FOLDER/m.stipple" "$FOLDER/folder.stipple" || fail "a list's model is not that of its files in order"

# of a mesh in a folder, whatever its format
mkdir "$FOLDER/scene"
printf '%s' '{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":0}]}],' \
    '"accessors":[{"bufferView":0,"componentType":5121,"count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":12}],' \
    '"buffers":[{"uri":"data:;base64,AAECAwQFBgcICQoL"}]}' >"$FOLDER/scene/points.GLTF"
run "$STIPPLE" prep "$FOLDER/scene" -o "$FOLDER/scene.stipple" --quiet
expect_code 0
run "$STIPPLE" info "$FOLDER/scene.stipple"
expect_text out "points         4"
"$STIPPLE" info "$FOLDER/m.stipple" --json >"$FOLDER/info.json"
for name in a.ply b.PLY 'bad, \"q\".ply' bed.ply; do
    grep -qF "\"$name\"" "$FOLDER/info.json" || fail "the metadata has no $name"
done

# Rejects are written one per line.
run "$STIPPLE" prep "$scans" -o "$FOLDER/m.stipple" --force --quiet --rejects "$FOLDER/rejects.csv"
expect_code 0
{
    echo file,index,reason
    echo "\"$scans/b/c/bad, \"\"q\"\".ply\",1,not_finite"
    echo "\"$scans/b/c/bad, \"\"q\"\".ply\",3,not_finite"
    echo "\"$scans/b/c/bed.ply\",0,not_finite"
} >"$FOLDER/expected.csv"
cmp "$FOLDER/rejects.csv" "$FOLDER/expected.csv" || fail "rejects"
run "$STIPPLE" prep "$scans" -o "$FOLDER/n.stipple" --quiet --rejects "$FOLDER/rejects.csv"
expect_failure "rejects.csv exists"
[ ! -e "$FOLDER/n.stipple" ] || fail "a model though the rejects could not be written"

# --progress json: each line is an object, stages come in order, and the last estimate of the time
# left is small.
run "$STIPPLE" prep "$scans" -o "$FOLDER/m.stipple" --force --progress json
expect_code 0
number='(-?[0-9.]+|null)'
object="^\\{\"stage\": \"[a-z]+\", \"done\": $number, \"total\": $number, \"seconds\": $number,"
object+=" \"seconds_left\": $number\\}\$"
reports=$(grep -c '^{' "$FOLDER/err")
[ "$reports" -ge 5 ] || fail "$reports reports"
[ "$(grep -cE "$object" "$FOLDER/err")" = "$reports" ] || fail "a line of the progress is not an object"
stages=$(sed -n 's/^{"stage": "\([a-z]*\)".*/\1/p' "$FOLDER/err" | uniq | tr '\n' ' ')
[ "$stages" = "read sort surface orientation closed patches " ] || fail "stages: $stages"

refuse() { # text, inputs
    local text=$1
    shift
    run "$STIPPLE" prep "$@" -o "$FOLDER/new.stipple"
    expect_failure "$text"
    [ ! -e "$FOLDER/new.stipple" ] || fail "$*: wrote"
}
refuse "has the name of a scan" "$FOLDER/none"
refuse "no file is named like this" "$scans/*.las"
refuse "names no file" @/dev/null
refuse "none.txt" "@$FOLDER/none.txt"
refuse "gone.ply" "$scans" "$scans/gone.ply" --strict
refuse "gone.ply" "$scans/gone.ply"
refuse "the list of inputs \`$FOLDER/none.txt\` cannot be opened" "@$FOLDER/none.txt"
ply 0 </dev/null >"$FOLDER/no points.ply"
refuse "no points.ply has no points: there is nothing to write" "$FOLDER/no points.ply"

# A list from Windows. No file may be given twice, under any name.
printf '\xef\xbb\xbfscäns here/a.ply\r\n' >"$FOLDER/marked.txt"
prepared 1000 1000 "@$FOLDER/marked.txt"
refuse "a.ply is the same file as $scans/a.ply: give it once" "$scans/a.ply" "$scans"
ln -s a.ply "$scans/c.ply"
refuse "c.ply is the same file as $scans/a.ply" "$scans"
rm "$scans/c.ply"

# A file that only has the name of a scan must be reported, and prep must not wait for a pipe.
mkdir -p "$FOLDER/odd/loop"
cp "$scans/a.ply" "$FOLDER/odd/a.ply"
ln -s .. "$FOLDER/odd/loop/up"
prepared 1000 1000 "$FOLDER/odd"
ln -s gone.las "$FOLDER/odd/link.las"
refuse "link.las: cannot be opened: No such file" "$FOLDER/odd" --strict
rm "$FOLDER/odd/link.las"
mkfifo "$FOLDER/odd/pipe.ply"
refuse "pipe.ply is not a regular file" "$FOLDER/odd" --strict
rm "$FOLDER/odd/pipe.ply"

# An input that cannot be read is left out alone, wherever it stands: it is named at the end, and
# the exit code is 1.
sick="$FOLDER/sïck ones"
mkdir -p "$sick/shut" "$FOLDER/open"
"$STIPPLE" gen sphere -n 70000 -o "$sick/a.ply" --quiet
cp "$scans/b/c/bed.ply" "$sick/c bed.ply"
cp "$sick/a.ply" "$sick/d.ply"
"$STIPPLE" gen torus -n 70000 -o "$FOLDER/whole.las" --quiet
: >"$sick/é empty.ply"
printf '\x89PNG\r\n\x1a\n....' >"$sick/foreign.ply"
ply 150002 < <(yes '1 2 3' | head -n 150000; echo '1 nan 3'; echo '1 2 x') >"$sick/b late.ply"
ply 5 <<<'1 2 3' >"$sick/e cut.ply"
head -c 1000000 "$FOLDER/whole.las" >"$sick/f cut.las"
good=("$sick/a.ply" "$sick/c bed.ply")
rm "$sick/d.ply"
# left_out COUNT OF SENTENCE...: prep of $inputs must leave out COUNT of OF files.
left_out() {
    local count=$1 of=$2
    shift 2
    run "$STIPPLE" prep "${inputs[@]}" -o "$FOLDER/s.stipple" --force --stats "$FOLDER/stats.json" \
        --rejects "$FOLDER/rejects.csv"
    expect_code 1
    expect_text err "$count of $of inputs could not be read, as said above: $FOLDER/s.stipple was written"
    [ "$(grep -c '^not read: ' "$FOLDER/err")" = "$count" ] || fail "$count lines for $count inputs"
    [ "$(grep -c ',,unreadable$' "$FOLDER/rejects.csv")" = "$count" ] || fail "rejects: $count files"
    [ "$(grep -c '"why":' "$FOLDER/stats.json")" = "$count" ] || fail "stats: $count files"
    for sentence in "$@"; do
        grep '^not read: ' "$FOLDER/err" | found -F -- "$sentence" || fail "no sentence: $sentence"
    done
}
# Whether two models have the same points; their metadata name different inputs.
same_model() {
    "$STIPPLE" export "$1" -o "$FOLDER/1.ply" --force --quiet
    "$STIPPLE" export "$2" -o "$FOLDER/2.ply" --force --quiet
    cmp -s "$FOLDER/1.ply" "$FOLDER/2.ply" || fail "$1 and $2 hold different points"
}
"$STIPPLE" prep "${good[@]}" -o "$FOLDER/good.stipple" --quiet
inputs=("$sick")
left_out 5 7 "b late.ply: line" "e cut.ply" "f cut.las" "foreign.ply" "é empty.ply"
expect_text err "70003 points read, 70002 stored, 1 rejected (1 not finite)"
same_model "$FOLDER/s.stipple" "$FOLDER/good.stipple"
grep -q 'c bed.ply",0,not_finite$' "$FOLDER/rejects.csv" || fail "the reject after a file that was left out is missing"
"$STIPPLE" verify "$FOLDER/s.stipple" --quiet || fail "verify"
cp "$FOLDER/s.stipple" "$FOLDER/wide.stipple"
"$STIPPLE" prep "$sick" -o "$FOLDER/narrow.stipple" --quiet --threads 1 2>/dev/null
cmp -s "$FOLDER/narrow.stipple" "$FOLDER/wide.stipple" || fail "threads change what is left out"
# The same holds for files, patterns and lists.
inputs=("$sick/a.ply" "$sick/gone.ply")
left_out 1 2 "gone.ply: cannot be opened: No such file"
inputs=("$sick/[a-c]*")
left_out 1 3 "b late.ply: line"
printf '%s\n' "$sick/a.ply" "$sick/f cut.las" >"$FOLDER/sick.txt"
inputs=("@$FOLDER/sick.txt")
left_out 1 2 "f cut.las"
# Nothing is written if no input is left, if the only file fails, and with --strict.
run "$STIPPLE" prep "$sick/foreign.ply" "$sick/é empty.ply" -o "$FOLDER/new.stipple"
expect_code 1
expect_text err "none of the 2 inputs can be read: nothing is written"
[ ! -e "$FOLDER/new.stipple" ] || fail "a model was written though no input could be read"
expect_text err "not read: $sick/foreign.ply"
refuse "foreign.ply" "$sick/foreign.ply"
refuse "b late.ply: line" "$sick/b late.ply"
refuse "b late.ply: line" "$sick/a.ply" "$sick/b late.ply" --strict
# A file without permission. Root may read everything, so it becomes another user first.
as=()
if [ "$(id -u)" = 0 ]; then
    command -v setpriv >/dev/null && as=(setpriv --reuid=65534 --regid=65534 --clear-groups)
    chmod 755 "$FOLDER"
fi
if [ "$(id -u)" != 0 ] || [ ${#as[@]} -gt 0 ] && "${as[@]}" "$STIPPLE" --version >/dev/null 2>&1; then
    chmod 777 "$FOLDER/open"
    mkdir "$FOLDER/locked"
    cp "$sick/a.ply" "$FOLDER/locked"
    cp "$sick/c bed.ply" "$FOLDER/locked/no.ply"
    mkdir "$FOLDER/locked/shut"
    chmod 000 "$FOLDER/locked/no.ply" "$FOLDER/locked/shut"
    run "${as[@]}" "$STIPPLE" prep "$FOLDER/locked" -o "$FOLDER/open/m.stipple"
    expect_code 1
    expect_text err "not read: $FOLDER/locked/no.ply: cannot be opened: Permission denied"
    expect_text err "not read: $FOLDER/locked/shut: cannot be opened: Permission denied"
    [ -e "$FOLDER/open/m.stipple" ] || fail "no model of the files that can be read"
    chmod 755 "$FOLDER/locked/shut"
fi

# Makes a LAS 1.2 file of four points with $1 as GeoTIFF key 1024: 1 projected, 2 degrees.
degrees_las() {
    local las="$FOLDER/keys.las"
    put() { # offset, bytes
        printf "$2" | dd of="$las" bs=1 seek="$1" conv=notrunc status=none
    }
    head -c $((227 + 54 + 16 + 4 * 20)) /dev/zero >"$las"
    put 0 'LASF'
    put 24 '\x01\x02'
    put 94 '\xe3\x00\x29\x01\x00\x00\x01' # header size, start of the points, one record
    put 105 '\x14\x00\x04'
    for at in 131 139 147; do
        put $at '\xfc\xa9\xf1\xd2\x4d\x62\x50\x3f' # scale 0.001
    done
    put 229 'LASF_Projection'
    put 245 '\xaf\x87\x10'
    put 281 "\\x01\\x00\\x01\\x00\\x00\\x00\\x01\\x00\\x00\\x04\\x00\\x00\\x01\\x00\\x0$1"
    for i in 0 1 2 3; do
        put $((297 + 20 * i)) "\\x0$i\\x00\\x00\\x00\\x0$((i * i))"
    done
}
degrees_las 2
refuse "degrees of longitude and latitude, of a system that it does not name" "$FOLDER/keys.las"
degrees_las 1
prepared 4 4 "$FOLDER/keys.las"
# what intensities were in the scan
printf '\x28' | dd of="$FOLDER/keys.las" bs=1 seek=309 conv=notrunc status=none # the first is 40
prepared 4 4 "$FOLDER/keys.las"
"$STIPPLE" info "$FOLDER/m.stipple" | found '^intensity      0 to 40 as in the scans' ||
    fail "info does not know the scan's intensities"
end_test
