#!/usr/bin/env bash
# Tests that README and docs/ name the commands and options that the programs' help names.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
# docs/plan.md describes things that do not exist yet.
mapfile -t pages < <(ls "$SOURCE"/README.md "$SOURCE"/docs/*.md "$SOURCE"/benchmarks/README.md |
    grep -v '/docs/plan\.md$')
text=$(cat "${pages[@]}" | tr '\n' ' ' | tr -s ' ')
commands=$("$STIPPLE" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')

# Collects the help of every program and script.
for name in $commands; do
    "$STIPPLE" "$name" --help >"$FOLDER/help-$name"
done
cat "$FOLDER"/help-* >"$FOLDER/help"
"${STIPPLE%/*}/stipple-bench" --help >>"$FOLDER/help" || fail "stipple-bench has no help"
for script in install-deps demo check gallery fetch-datasets bench/first-light bench/first-picture bench/scale \
    bench/table bench/gpu bench/gpu-run site; do
    bash "$SOURCE/tools/$script" --help
done >>"$FOLDER/help"

# The table must list the program's commands in the program's order, with the usage of their help.
listed=$(sed -n 's/^| `stipple \([a-z]*\) .*/\1/p' "$SOURCE/README.md")
[ "$listed" = "$commands" ] || fail "the table has $listed, the program $commands"
while read -r usage; do
    grep -qxF -e "usage: $usage" -e "usage: $usage [options]" "$FOLDER/help" ||
        fail "'$usage' is not the usage that its help gives"
done < <(sed -n 's/^| `\(stipple [^`]*\)`.*/\1/p' "$SOURCE/README.md")

# Every option must be in a help. The options of cmake and ctest are left out.
while read -r option; do
    grep -qE -- "(^|[^a-z-])$option([^a-z-]|$)" "$FOLDER/help" || fail "$option is in no help"
done < <(sed 's/`c\(make\|test\) [^`]*`//g' <<<"$text" | grep -oE -- '--[a-z][a-z-]*' | sort -u)

# If a page lists an option's choices, the help must list the same.
while read -r choice; do
    grep -qE -- "$choice( |$)" "$FOLDER/help" || fail "$choice is in no help"
done < <(grep -oE -- '--[a-z-]+ [a-z0-9]+(\|[a-z0-9]+)+' <<<"$text" | sed 's/|/[|]/g' | sort -u)

# A line to type must be a command with options of its own.
while read -r line; do
    name=$(sed -E 's/^(build\/release\/)?stipple ([a-z]+).*/\2/' <<<"$line")
    grep -qxF "$name" <<<"$commands" || fail "'$line': no command $name"
    while read -r option; do
        grep -qE -- "(^|[^a-z-])$option([^a-z-]|$)" "$FOLDER/help-$name" || fail "'$line': $name has no $option"
    done < <(grep -oE -- '--[a-z][a-z-]*' <<<"$line")
done < <(grep -hoP '^    \Kstipple [a-z].*' "${pages[@]}")

# Every shape of the table must be known to gen: it then asks for the number of points. (test_docs.sh tests the links.)
shapes=$(sed -n 's/.*known surface: `\([a-z ]*\)`.*/\1/p' "$SOURCE/README.md")
[ -n "$shapes" ] || fail "no shapes in the table"
for shape in $shapes; do
    run "$STIPPLE" gen "$shape" -o "$FOLDER/shape.ply"
    expect_usage 'no number of points'
done
end_test
