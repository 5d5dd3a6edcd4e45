# shellcheck shell=bash disable=SC2154
# Functions that benchmarks in bash share. A benchmark sources this file and sets a folder $work and its name $program.

# Fails if a program that the benchmark runs is not built.
need_programs() { # build folder, programs
    local build=$1 name
    shift
    for name in "$@"; do
        [ -x "$build/$name" ] || {
            echo "$program: $build/$name is not there: cmake --build $build" >&2
            exit 1
        }
    done
}

# Finds the model of a known surface with some million points in random order. Makes the model if it is missing:
# 16 million points take some minutes and 3 GiB of memory.
make_model() { # build folder, folder of models, shape, millions; sets $model
    model=$2/$3-${4}m.stipple
    [ ! -e "$model" ] || return 0
    echo "$program: making $model" >&2
    "$1/stipple" gen "$3" -n "${4}M" --noise 0.1 -o "$2/scan.ply" --force --quiet
    "$1/stipple" prep "$2/scan.ply" -o "$model" --quiet
    rm "$2/scan.ply"
}

# Prints a figure of the last drawing's statistics, $work/stats.json: the first of this name, so `median` is a frame's.
figure_of() { grep -oE "\"$1\":[^,]*" "$work/stats.json" | grep -oE '[0-9.e+-]+$' | sed -n 1p; }

# For awk: sorts v[1] to v[n] and returns the median; for an even count, the mean of the two in the middle.
median='
    function median(v, n, i, j, t) {
        for (i = 2; i <= n; i++)
            for (j = i; j > 1 && v[j] < v[j - 1]; j--) { t = v[j]; v[j] = v[j - 1]; v[j - 1] = t }
        return (v[int((n + 1) / 2)] + v[int(n / 2) + 1]) / 2
    }
'

# Prints the median of the numbers on stdin, one per line, with %.6g.
median_of() { awk -v format="${1:-%.6g}" "$median"'{ v[NR] = $1 } END { printf format, median(v, NR) }'; }

# ---- rows: one ratio each. Fields, separated by tabs: topic, what, model, points, a, b, ratio, least,
# greatest, unit (of a and b). a, b and the ratio are medians. Each ratio is of two values measured together.

# Prints a row from pairs `a b` on stdin, one per round.
row() { # topic, what, model, points, unit
    awk -v OFS='\t' -v topic="$1" -v what="$2" -v model="$3" -v points="$4" -v unit="$5" "$median"'
        NF != 2 || $2 <= 0 { print "no figures for " what ": " $0 >"/dev/stderr"; bad = 1; exit }
        { a[NR] = $1; b[NR] = $2; ratio[NR] = $1 / $2 }
        END {
            if (bad || NR == 0) exit 1
            middle = median(ratio, NR)
            print topic, what, model, points, sprintf("%.6g", median(a, NR)), sprintf("%.6g", median(b, NR)),
                sprintf("%.6g", middle), sprintf("%.6g", ratio[1]), sprintf("%.6g", ratio[NR]), unit
        }'
}

# Prints the rows on stdin as the table.
print_rows() {
    awk -F'\t' '
        function short(x) { return x >= 99999.5 ? sprintf("%.0f", x) : sprintf("%.5g", x) }
        BEGIN { printf "%-7s %-38s %-20s %10s %11s %11s %8s  %s\n",
            "topic", "what", "model", "points", "a", "b", "a / b", "least to greatest, unit" }
        { printf "%-7s %-38s %-20s %10d %11s %11s %8.3f  %.3f to %.3f, %s\n",
            $1, $2, $3, $4, short($5), short($6), $7, $8, $9, $10 }'
}
