#!/usr/bin/env bash
# Tests prep as several ranks: the same bytes as one process, for any number of ranks; one line and no
# file if ranks differ, fail or are killed. Long runs try more ranks and kill more of them.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
mkdir "$FOLDER/models" "$FOLDER/mixed"
model=$FOLDER/models/m.stipple

if [ ! -e "$(dirname "$STIPPLE")/libstipple-mpi.so" ]; then
    run env OMPI_COMM_WORLD_SIZE=2 "$STIPPLE" prep "$FOLDER/none.ply" -o "$model"
    expect_failure "2 processes are to prepare one model, but this stipple has no MPI"
    [ "$failures" = 0 ] || end_test
    skip_test "this build has no MPI (-DSTIPPLE_MPI=ON)"
fi
command -v mpirun >/dev/null || skip_test "there is no mpirun"
export OMPI_MCA_btl_vader_single_copy_mechanism=none # containers forbid it, which would be said on stderr
export HWLOC_COMPONENTS=-gl # else mpirun asks X servers, and dies with one that another test ends
launch=(mpirun --allow-run-as-root --oversubscribe --bind-to none)

"$STIPPLE" gen statue -n 100000 --order random -o "$FOLDER/statue.ply" --quiet || fail "no scan"
"$STIPPLE" gen bumpy -n 60000 --noise 0.1 -o "$FOLDER/mixed/a.las" --quiet || fail "no scan"
"$STIPPLE" gen building -n 60000 -o "$FOLDER/mixed/b.ply" --quiet || fail "no scan"
awk 'BEGIN { for (i = 0; i < 5000; i++) print i % 70 * 0.1, int(i / 70) * 0.1, 20 }' >"$FOLDER/mixed/c.xyz"

# The same positions in another colour: their order is that of the inputs.
awk '{ print $0, 255, 0, NR % 256 }' "$FOLDER/mixed/c.xyz" >"$FOLDER/mixed/d.xyz"
# Two files of the same positions, the second one backwards: each rank reads one of them, and of each
# two points that with the lower record number comes first.
mkdir "$FOLDER/twice"
awk 'BEGIN { srand(2); for (i = 0; i < 5000; i++) print rand(), rand(), rand(), 255, i % 256, 0 }' >"$FOLDER/twice/a.xyz"
tac "$FOLDER/twice/a.xyz" | awk '{ print $1, $2, $3, 0, $5, 255 }' >"$FOLDER/twice/b.xyz"
# Normals that are noisy: they are averaged with those of neighbours, also of other ranks.
# A strip whose points follow each other: ranks that read parts of it have little to send.
awk 'BEGIN { srand(9); print 300000; for (i = 0; i < 300000; i++) print i * 0.01, rand(), rand() / 9, i % 99, 9, 9, 200 }' >"$FOLDER/strip.pts"
awk 'BEGIN { srand(5); for (i = 0; i < 90000; i++) print i % 300 * 0.1, int(i / 300) * 0.1, sin(i % 300 * 0.05),
    rand() / 4 - 0.125, rand() / 4 - 0.125, 1 }' >"$FOLDER/noisy.xyz"
# A pile beside one point far away.
mkdir "$FOLDER/broken"
awk 'BEGIN { srand(1); print 1e9, 0, 0; for (i = 0; i < 140000; i++) print rand(), rand(), i % 2 }' >"$FOLDER/pile.xyz"
awk 'BEGIN {
    print "ply\nformat ascii 1.0\nelement vertex 20000"
    print "property double x\nproperty double y\nproperty double z\nend_header"
    for (i = 0; i < 20000; i++) print i == 19000 ? "x" : rand(), rand(), 5
}' >"$FOLDER/broken/b.ply"
cp "$FOLDER/mixed/a.las" "$FOLDER/mixed/c.xyz" "$FOLDER/broken"
# A plane, points and small groups far from it, and a pile of outliers at one position.
awk 'BEGIN { srand(7)
    for (i = 0; i < 60000; i++) print rand() * 9, rand() * 9, rand() / 500
    for (i = 0; i < 500; i++) print rand() * 9, rand() * 9, rand() * 4
    for (i = 0; i < 300; i++) print int(i / 6) % 7 + i % 6 / 300, int(i / 42), 2 + i % 2 / 300
    for (i = 0; i < 9; i++) print 4, 4, 9 }' | sort -k3 >"$FOLDER/stray.xyz"

# Files of one station: two scanners in a box; a depth camera's images with noise; a false claim, since
# the points lie behind each other.
mkdir "$FOLDER/scans" "$FOLDER/depths" "$FOLDER/stations"
scanner() { # x of the scanner
    awk -v x="$1" 'BEGIN { pi = 3.14159265; srand(x)
        print 240 "\n" 100 "\n" x, "2 1\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0"; print x, "2 1 1"
        for (c = 0; c < 240; c++) for (r = 0; r < 100; r++) {
            p = 2 * pi * (c + 0.5) / 240; q = (r - 49.5) * pi / 120
            u = cos(q) * cos(p); v = cos(q) * sin(p); w = sin(q)
            t = u > 0 ? (8 - x) / u : -x / u
            s = v > 0 ? 2 / v : -2 / v; t = s < t ? s : t
            s = w > 0 ? 1.5 / w : -1 / w; t = s < t ? s : t
            t += rand() / 500
            if (c % 17) print u * t, v * t, w * t, 0.5; else print "0 0 0 0.5" } }'
}
image() { # seed, wrong: the points are no image from the viewpoint
    awk -v seed="$1" -v wrong="$2" 'BEGIN { srand(seed)
        print "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 160\nHEIGHT 120"
        print "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 19200\nDATA ascii"
        for (r = 0; r < 120; r++) for (c = 0; c < 160; c++) {
            z = 1 / int(400 / (2 + c / 160 + (r > 60)) + rand()) * 400
            if (wrong) print rand(), rand(), 1 + rand(); else print (c - 80) * z / 140, (r - 60) * z / 140, z } }'
}
scanner 2 >"$FOLDER/scans/a.ptx"
scanner 6 >"$FOLDER/scans/b.ptx"
image 3 0 >"$FOLDER/depths/a.pcd"
image 4 0 >"$FOLDER/depths/b.pcd"
image 5 1 >"$FOLDER/stations/c.pcd"
cp "$FOLDER/depths/b.pcd" "$FOLDER/scans/a.ptx" "$FOLDER/stations"

"$(dirname "$STIPPLE")/tests/test_scan_images" "$FOLDER/images.e57" "$FOLDER/images.ptx" "$FOLDER/scan.pcd" || fail "no files of several scans"

# Heights: a grid with holes, a tile without samples, and noise; the same in four files that overlap, and
# in four beside each other. Tiles have 256 x 256 samples.
mkdir "$FOLDER/tiles" "$FOLDER/beside"
heights() { # first column, first row, columns, rows
    awk -v x="$1" -v y="$2" -v n="$3" -v m="$4" 'BEGIN {
        print "ncols", n, "\nnrows", m, "\nxllcorner", x, "\nyllcorner", 700 - y - m, "\ncellsize 1\nNODATA_value -9"
        for (r = y; r < y + m; r++) for (c = x; c < x + n; c++)
            print (c > 255 && c < 513 && r < 257) || (c * 7 + r * 3) % 97 == 0 ? -9 : 9 * sin(c / 40) * cos(r / 31) + (c * 31 + r * 17) % 13 / 99
    }'
}
heights 0 0 800 700 >"$FOLDER/heights.asc"
for i in 0 1; do
    for k in 0 1; do
        heights $((i * 390)) $((k * 340)) 410 360 >"$FOLDER/tiles/$i$k.asc"
        heights $((i * 400)) $((k * 350)) 400 350 >"$FOLDER/beside/$i$k.asc"
    done
done
awk 'BEGIN { print "P3\n800 700\n255"; for (i = 0; i < 560000; i++) print i % 256, int(i / 800) % 256, i % 7 * 30 }' >"$FOLDER/heights.ppm"

facts() { sed '/"seconds"/,$d' "$FOLDER/$1"; } # of --stats, without times and memory

# Any number of ranks must give the bytes of one process, and say the same of them.
wanted=0 # exit code
check_bytes() { # numbers of ranks, words of prep
    local ranks n
    read -ra ranks <<<"$1"
    shift
    run "$STIPPLE" prep "$@" -o "$FOLDER/one.stipple" --threads 2 --force --stats "$FOLDER/one.json"
    expect_code $wanted
    for n in "${ranks[@]}"; do
        run "${launch[@]}" -n "$n" "$STIPPLE" prep "$@" -o "$model" --threads 1 --quiet --force \
            --stats "$FOLDER/stats.json"
        expect_code $wanted
        expect_empty out
        [ $wanted != 0 ] || expect_empty err
        cmp -s "$model" "$FOLDER/one.stipple" || fail "$n ranks, $*: other bytes"
        [ "$(facts stats.json)" = "$(facts one.json)" ] || fail "$n ranks, $*: other --stats"
        [ "$(ls -A "$FOLDER/models")" = m.stipple ] || fail "$n ranks: left $(ls -A "$FOLDER/models")"
    done
}

# The last run's ranks must have sorted parts, and kept them. A point has 56 bytes: all points for the
# other ranks would be more.
expect_shared() { # points, ranks
    local sorted
    sorted=$(sed -n '/stage_sent_bytes/,/}/s/.*"sort":[^0-9]*\([0-9]*\).*/\1/p' "$FOLDER/stats.json")
    [ "${sorted:-0}" -gt "$1" ] || fail "$command: ranks did not sort parts: sent ${sorted:-nothing}"
    [ "${sorted:-0}" -lt $((56 * $1 * ($2 - 1))) ] || fail "$command: ranks do not share the points: sent $sorted bytes"
}

# The last run's ranks must have shared a grid: at most 12 bytes a sample for another rank, 6 more with
# colours, and none if it was read as a whole.
expect_shared_grid() { # samples, bytes
    local sent
    sent=$(sed -n '/stage_sent_bytes/,/}/s/.*"surface":[^0-9]*\([0-9]*\).*/\1/p' "$FOLDER/stats.json")
    [ "${sent:-0}" -gt 10000 ] || fail "$command: ranks did not share the grid: sent ${sent:-nothing}"
    [ "${sent:-0}" -lt $(($2 * $1 + 100000)) ] || fail "$command: ranks sent $sent bytes"
}

all=2
if is_long; then all="1 2 3 4 8"; fi
check_bytes "$all 3" "$FOLDER/statue.ply"
expect_shared 100000 3
check_bytes "$all 3" "$FOLDER/mixed" --orient none
check_bytes "$all" "$FOLDER/pile.xyz"
check_bytes "$all" "$FOLDER/twice"
check_bytes "$all" "$FOLDER/noisy.xyz" --columns x,y,z,nx,ny,nz
wanted=1
check_bytes "$all" "$FOLDER/broken" # its file breaks off in the middle: it is left out, on all ranks
wanted=0
check_bytes "$all 3" "$FOLDER/mixed" --attributes all --memory 150M --outliers mark
expect_shared 125000 3
check_bytes "$all" "$FOLDER/stray.xyz" --outliers mark
grep -Eq '"outliers_marked":[[:space:]]*[1-9]' "$FOLDER/one.json" || fail "no outliers were found"
check_bytes "$all 3" "$FOLDER/stray.xyz" "$FOLDER/scans" --outliers drop
expect_shared 105000 3
check_rejects() { # further options
    local input=("$FOLDER/stray.xyz" "$FOLDER/scans" --outliers drop --force --quiet "$@")
    "$STIPPLE" prep "${input[@]}" --rejects "$FOLDER/one.csv" -o "$FOLDER/one.stipple" || fail "no list of rejects"
    run "${launch[@]}" -n 3 "$STIPPLE" prep "${input[@]}" --rejects "$FOLDER/m.csv" -o "$model" --threads 1 \
        --stats "$FOLDER/stats.json"
    [ "$(wc -l <"$FOLDER/one.csv")" -gt 1 ] || fail "no rejects: $*"
    cmp -s "$FOLDER/m.csv" "$FOLDER/one.csv" || fail "3 ranks: another list of rejects: $*"
}
check_rejects --layers joined
check_rejects
expect_shared 105000 3
check_bytes "$all 3" "$FOLDER/scans"
expect_shared 45000 3
check_bytes "$all 3" "$FOLDER/depths"
expect_shared 38400 3
grep -Eq '"normals_seen":[[:space:]]*[1-9]' "$FOLDER/one.json" || fail "no normals from images"
for file in images.e57 images.ptx; do # of several scans each
    check_bytes "$all 3" "$FOLDER/$file" --grid
    expect_shared 36000 3
    "$STIPPLE" prep "$FOLDER/$file" -o "$FOLDER/points.stipple" --quiet --force || fail "$file: no model"
    ! cmp -s "$FOLDER/points.stipple" "$FOLDER/one.stipple" || fail "$file: images became points"
done
check_bytes 3 "$FOLDER/images.e57" --grid --holes grow
printf '90 0 0\n-70 3 1\n' >"$FOLDER/far.xyz"
check_bytes "$all 3" "$FOLDER/images.e57" "$FOLDER/far.xyz" --grid --layers joined --outliers drop --memory 150M
check_bytes "$all 3" "$FOLDER/strip.pts" --neighbours 6
sorted=$(sed -n '/stage_sent_bytes/,/}/s/.*"sort":[^0-9]*\([0-9]*\).*/\1/p' "$FOLDER/stats.json")
[ "$sorted" -lt $((20 * 300000)) ] || fail "strip.pts: one rank read all points: ranks sent $sorted bytes"
# Files of one station that several ranks read: true, and false, since the points lie behind each other.
check_bytes "$all 3" "$FOLDER/images.e57" "$FOLDER/scan.pcd"
LC_ALL=C sed 's/^VIEWPOINT 4 4 4/VIEWPOINT 9 9 9/' "$FOLDER/scan.pcd" >"$FOLDER/false.pcd"
for file in scan.pcd false.pcd; do
    check_bytes "$all 3" "$FOLDER/$file" --quiet
    run "${launch[@]}" -n 3 "$STIPPLE" prep "$FOLDER/$file" -o "$model" --threads 1 --force
    [ $file = false.pcd ] && expect_text err "scanner positions of 1 file are not used"
    [ $file = false.pcd ] || expect_text err "orientation from the scanner's position"
done
check_bytes "$all 3" "$FOLDER/stations" --outliers drop
run "${launch[@]}" -n 3 "$STIPPLE" prep "$FOLDER/stations" -o "$model" --threads 1 --force
expect_text err "19200 points name no scanner"
check_bytes "$all 3" "$FOLDER/heights.asc"
expect_shared_grid 560000 12
check_bytes 3 "$FOLDER/heights.asc" --holes grow
check_bytes "$all 3" "$FOLDER/heights.asc" --colour "$FOLDER/heights.ppm" --memory 150M
expect_shared_grid 560000 18
check_bytes "$all 3" "$FOLDER"/tiles/*.asc
grep -Eq '"twice":[[:space:]]*[1-9]' "$FOLDER/one.json" || fail "no file overlaps another"
expect_shared_grid 590400 12
check_bytes "$all 3" "$FOLDER"/beside/*.asc
sed '400,$d' "$FOLDER/tiles/10.asc" >"$FOLDER/tiles/11.asc" # it breaks off: ranks read everything
wanted=1
check_bytes "$all" "$FOLDER"/tiles/*.asc
wanted=0
check_bytes "$all" "$FOLDER/statue.ply" --layers joined --codec zstd --precision 0.001
check_bytes "$all 3" "$FOLDER/mixed" --layers joined --memory 150M
expect_shared 125000 3
check_bytes "$all 3" "$FOLDER/mixed/b.ply" --maps
expect_shared 60000 3
# Ranks tell each other parts as cells merged them: 11.4 MB in all; 15.5 if as they were cut.
sent=$(sed -n '/stage_sent_bytes/,/}/s/.*"maps":[^0-9]*\([0-9]*\).*/\1/p' "$FOLDER/stats.json")
[ "${sent:-0}" -gt 1000000 ] && [ "$sent" -lt 13500000 ] || fail "$command: ranks sent $sent bytes for maps"
check_bytes "$all 3" "$FOLDER/stray.xyz" --maps --outliers mark --cone 75
check_bytes "$all 3" "$FOLDER/mixed/a.las" "$FOLDER/mixed/b.ply" --maps --gaps fill --memory 200M
expect_shared 120000 3
expect_held() { # why, or nothing if ranks share the points; words of prep
    run "${launch[@]}" -n 2 "$STIPPLE" prep "${@:2}" -o "$model" --threads 1 --force
    [ "$(sed -n 's/^each of the 2 ranks held all points: //p' "$FOLDER/err")" = "$1" ] || fail "$command: $(cat "$FOLDER/err")"
}
expect_held "" "$FOLDER/mixed/b.ply" --maps
expect_held "" "$FOLDER/depths"
expect_held "some part of the inputs could not be read by itself" "$FOLDER/broken"
expect_held "" "$FOLDER/mixed/b.ply"
expect_held "" "$FOLDER/heights.asc"
# What could not be read is said by rank 0, and the end after it.
run "${launch[@]}" -n 3 "$STIPPLE" prep "$FOLDER/broken" -o "$model" --threads 1 --quiet --force
[ "$(sed -n 's/^stipple prep: \(.*\), as said above.*/\1/p; s/^not read: .*/left out/p' "$FOLDER/err")" = \
    "left out"$'\n'"1 of 3 inputs could not be read" ] || fail "$command: $(cat "$FOLDER/err")"
rm -f "$model"
# A rank with less memory must find the same closed surfaces.
both=("$STIPPLE" prep "$FOLDER/mixed/a.las" "$FOLDER/mixed/b.ply" --threads 1 --quiet --force)
"${both[@]}" -o "$FOLDER/one.stipple" || fail "no model"
run "${launch[@]}" -n 1 "${both[@]}" -o "$model" : -n 1 "${both[@]}" --memory 100M -o "$model"
expect_code 0
cmp -s "$model" "$FOLDER/one.stipple" || fail "ranks of different memory: other bytes"
rm -f "$model"

# One line of ours, whatever mpirun says beside, and nothing left.
expect_end() { # text
    [ "$code" != 0 ] || fail "$command: exit 0"
    [ "$(grep -c '^stipple prep: ' "$FOLDER/err")" = 1 ] || fail "$1: $(grep '^stipple' "$FOLDER/err")"
    expect_text err "$1"
    [ ! -e "$model" ] || fail "$1: there is a model"
}
one=("$STIPPLE" prep "$FOLDER/statue.ply" -o "$model" --threads 1 --quiet)
run "${launch[@]}" -n 1 "${one[@]}" : -n 2 "$STIPPLE" prep "$FOLDER/mixed/b.ply" -o "$model" --threads 1 --quiet
expect_end "has another $FOLDER/statue.ply than rank 0"
run "${launch[@]}" -n 2 "${one[@]}" : -n 1 "${one[@]}" --memory 90M --temp "$FOLDER/none"
expect_end "rank 2 on "
run "${launch[@]}" -n 2 "${one[@]}" : -n 1 "${one[@]}" --neighbours 20
expect_end "rank 2 on $(hostname) has other options than rank 0"
run "${launch[@]}" -n 3 "${one[@]}" --neighbours 1
expect_end "--neighbours: give 3 to 64"
run "${launch[@]}" -n 3 "$STIPPLE" prep "$FOLDER/none.ply" -o "$model"
expect_end "none.ply"
run "${launch[@]}" -n 2 "$STIPPLE" prep "$FOLDER/statue.ply" -o "$FOLDER/none/m.stipple"
expect_end "none/m.stipple"
[ -z "$(ls -A "$FOLDER/models")" ] || fail "failures left $(ls -A "$FOLDER/models")"

# Kills one of three ranks after a while.
kill_one() { # milliseconds, which
    local launcher children
    timeout 100 "${launch[@]}" -n 3 "${one[@]}" >"$FOLDER/out" 2>"$FOLDER/err" & # mpirun itself may hang
    launcher=$!
    command="kill of rank $2 after $1 ms"
    sleep "$(($1 / 1000)).$(printf %03d $(($1 % 1000)))"
    mapfile -t children < <(pgrep -P "$(pgrep -P $launcher || echo 0)" -x stipple)
    kill -0 $launcher 2>/dev/null || took=$((took * 4 / 5)) # it ended before: the machine is less busy now
    [ ${#children[@]} = 3 ] && kill -KILL "${children[$2]}" 2>/dev/null && killed=$((killed + 1))
    code=0
    wait $launcher || code=$?
    if [ "$code" = 0 ] || [ -e "$model" ]; then # the kill came after the end
        cmp -s "$model" "$FOLDER/whole.stipple" || fail "$command: no whole model"
        rm -f "$model"
    else
        # as long as MPI starts, no rank can say anything
        if found '^stipple prep: ' "$FOLDER/err"; then
            expect_end "nothing was written"
            spoken=$((spoken + 1))
        fi
    fi
}
# Kills some runs of an input at all times, and looks for whole models and what is left.
check_kills() { # kills, words of prep
    local began took kills=$1
    shift
    one=("$STIPPLE" prep "$@" -o "$model" --threads 1 --quiet)
    "$STIPPLE" prep "$@" -o "$FOLDER/whole.stipple" --threads 2 --quiet --force || fail "no model"
    began=$(date +%s%N)
    "${launch[@]}" -n 3 "${one[@]}" || fail "no run of three ranks"
    took=$((($(date +%s%N) - began) / 1000000))
    rm -f "$model"
    killed=0 spoken=0
    for i in $(seq "$kills"); do
        kill_one $((took * (2 * i - 1) / 2 / kills)) $((i % 3))
    done
    for i in $(seq $((10 + kills))); do # on a busy machine those may all have come while MPI started, or after the end
        [ $spoken -ge $((killed / 2)) ] && [ $killed -ge $((kills / 2)) ] && break
        kill_one $((took * (4 + i % 5) / 10)) $((i % 3))
    done
    [ $killed -ge $((kills / 2)) ] || fail "only $killed of $kills runs were killed"
    [ $spoken -ge $((killed / 2)) ] || fail "only $spoken of $killed killed runs said so"
    "${launch[@]}" -n 2 "${one[@]}" || fail "the run after the kills failed"
    [ "$(ls -A "$FOLDER/models")" = m.stipple ] || fail "after kills: $(ls -A "$FOLDER/models")"
    rm -f "$model"
}
if is_long; then
    check_kills 30 "$FOLDER/statue.ply"
    check_kills 30 "$FOLDER/mixed/b.ply" --maps
    heights 0 0 1500 1500 >"$FOLDER/heights.asc"
    check_kills 10 "$FOLDER/heights.asc"
else
    check_kills 2 "$FOLDER/statue.ply"
fi
end_test
