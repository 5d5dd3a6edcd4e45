# shellcheck shell=bash disable=SC2154
# What benchmarks in bash share: they source it, and have a folder $work.

# A figure of the last drawing's statistics, $work/stats.json: the first of that name, so that `median` is a frame's.
figure_of() { grep -oE "\"$1\":[^,]*" "$work/stats.json" | grep -oE '[0-9.e+-]+$'; }

# For awk: the median of v[1] to v[n], which it sorts.
# shellcheck disable=SC2034
median='
    function median(v, n, i, j, t) {
        for (i = 2; i <= n; i++)
            for (j = i; j > 1 && v[j] < v[j - 1]; j--) { t = v[j]; v[j] = v[j - 1]; v[j - 1] = t }
        return v[int((n + 1) / 2)]
    }
'
