#!/usr/bin/env bash
# Tests the rules of style that a program can see: quiet libraries, file sizes, formatting, no paths
# of one machine.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$SOURCE" || exit 1

# Prints the project's files, including new ones that git does not ignore.
files() {
    git ls-files --cached --others --exclude-standard -- "$@" 2>/dev/null | sort -u |
        while read -r file; do [ -f "$file" ] && echo "$file"; done
}

check_quiet() {
    local found
    found=$(files 'base/*.c' 'formats/*.c' 'formats/*.cpp' 'preprocess/*.c' 'preprocess/*.cpp' \
        'runtime/*.c' 'runtime/*.cpp' |
        xargs -r grep -nE '\b(v?printf|puts|putchar|perror|exit|_exit|abort)\(|\b(stdout|stderr|std::cout|std::cerr)\b')
    [ -z "$found" ] || fail "library code prints or exits: $found"
}

check_size() {
    local lines file
    while read -r lines file; do
        [ "$lines" -le 600 ] || fail "$file has $lines lines: part it, its limit is 600"
    done < <(files '*.c' '*.h' '*.cpp' '*.glsl' '*.vert' '*.frag' '*.geom' '*.comp' '*.sh' 'tools/*' |
        xargs wc -l | grep -v ' total$')
}

check_text() {
    local found
    found=$(files '*.c' '*.h' '*.cpp' '*.glsl' '*.cmake' '*CMakeLists.txt' '*.sh' |
        xargs grep -nP '\t| +$' | head -5)
    [ -z "$found" ] || fail "tabs or spaces at a line's end: $found"
    found=$(files | grep -v '^tests/base/test_style\.sh$' | xargs grep -nIE '\.\./shared|/work/|/home/[a-z]|/root/' |
        head -5)
    [ -z "$found" ] || fail "a path of one machine: $found"
    found=$(files '*.c' '*.h' '*.cpp' | xargs awk 'FNR == 1 && !/^\/[*\/]/ { print FILENAME }')
    [ -z "$found" ] || fail "the first line does not say what the file does: $found"
}

# A name that two headers give to two types works only as long as no file includes both.
check_types() {
    local found
    found=$(files '*.h' | grep -v '^tests/' | xargs grep -hoP '^(typedef (struct|enum) (\w+) \3;|\} [a-z]\w*;)' |
        sort | awk '$1 == "}" || $0 != last { print $NF } { last = $0 }' | sort | uniq -d)
    [ -z "$found" ] || fail "two headers define a type of this name: $found"
}

check_format() {
    if ! command -v clang-format >/dev/null; then
        echo "formatting not checked: clang-format is not installed"
        return
    fi
    local found
    found=$(files '*.c' '*.h' '*.cpp' | xargs clang-format --dry-run --Werror 2>&1 |
        sed -n 's/^\([^:]*\):[0-9]*:[0-9]*: error:.*/ \1/p' | sort -u | tr -d '\n')
    [ -z "$found" ] || fail "clang-format -i these:$found"
}

git rev-parse --git-dir >/dev/null 2>&1 || skip_test "not a git checkout: which files are ours is unknown"
check_quiet
check_size
check_text
check_types
check_format
end_test
