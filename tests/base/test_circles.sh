#!/usr/bin/env bash
# Tests that calls between files form no circle: if file A needs B, B must not need A, directly or
# through other files.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

# Prints a line "user definer" for each call between two objects of the program and its libraries.
calls() { # folder of the build
    find "$1"/{base,formats,preprocess,runtime,tools} -name '*.o' 2>/dev/null | while read -r object; do
        source=${object#"$1"/}
        source=${source%%/CMakeFiles/*}/${source##*.dir/}
        # an object without a source is left from an earlier build
        [ -e "$SOURCE/${source%.o}" ] && printf '%s\0' "$object"
    done | xargs -0 "${NM:-nm}" -A 2>/dev/null | awk '
        {
            file = $1
            sub(/:.*/, "", file)
            sub(/.*\.dir\//, "", file)
        }
        $(NF - 1) == "U" { used[file, $NF] = 1; next }
        $(NF - 1) ~ /^[TDBRVW]$/ { definer[$NF] = file }
        END {
            for (pair in used) {
                split(pair, part, SUBSEP)
                if (part[2] in definer && definer[part[2]] != part[1]) print part[1], definer[part[2]]
            }
        }' | sort -u
}

circles() { tsort 2>&1 >/dev/null | sed 's/^tsort: //'; }

# Self-check: the test must find a circle if there is one.
[ -n "$(printf 'a b\nb c\nc a\n' | circles)" ] || fail "a circle of three is not seen"
found=$(calls "$(dirname "$STIPPLE")")
[ "$(wc -l <<<"$found")" -gt 500 ] || fail "only $(wc -l <<<"$found") calls between files are seen"
grep -q 'file/info.c.o cli/cli.c.o' <<<"$found" || fail "the call of the options by info is not seen"
circle=$(circles <<<"$found")
[ -z "$circle" ] || fail "files that need each other: $circle"
end_test
