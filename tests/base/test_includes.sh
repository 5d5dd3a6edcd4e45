#!/usr/bin/env bash
# Tests who may include whom, and that each shim's header compiles as C17 by itself.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$SOURCE" || exit 1

folders=(base formats preprocess runtime shaders tools tests)
declare -A allowed=(
    [base]="base"
    [formats]="base formats"
    [preprocess]="base formats preprocess"
    [runtime]="base formats runtime shaders"
    [tools]="base formats preprocess runtime tools"
    [tests]="base formats preprocess runtime tools tests"
)

sources() { # folder
    git ls-files --cached --others --exclude-standard -- "$1/*.c" "$1/*.h" "$1/*.cpp" 2>/dev/null ||
        find "$1" -name '*.c' -o -name '*.h' -o -name '*.cpp'
}

# A quoted include names a file by its path from the root, or a file in the same folder.
check_includes() {
    local folder=$1 file name target
    while IFS=: read -r file name; do
        if [ -e "$name" ]; then
            target=${name%%/*}
        elif [ -e "$(dirname "$file")/$name" ] || [[ $name != */* ]]; then
            continue
        else
            fail "$file includes $name, which is neither ours nor in <>"
            continue
        fi
        [[ " ${allowed[$folder]} " == *" $target "* ]] ||
            fail "$file includes $name: $folder may include only ${allowed[$folder]}"
    done < <(sources "$folder" | xargs -r grep -HoP '^\s*#\s*include\s*"\K[^"]+')
}

# The code that handles chunk files must not need the libraries for scans and images.
check_chunk() {
    local found
    found=$({ sources formats/chunk; sources runtime; } |
        xargs -r grep -HnE '"formats/(scan|image)/')
    [ -z "$found" ] || fail "the chunk file or the runtime includes scans or images: $found"
}

check_cpp() {
    local file header
    while read -r file; do
        [[ $file == *_shim.cpp || $file == tests/* ]] || fail "$file is C++ but no shim"
        header=${file%.cpp}.h
        [[ $file == tests/* || -e $header ]] || fail "$file has no header $header"
        [[ $file == tests/inject/* ]] || grep -q 'catch (\.\.\.)' "$file" || fail "$file lets exceptions through: no catch (...)"
    done < <(for f in "${folders[@]}"; do sources "$f"; done | grep '\.cpp$')
}

# Headers that no file of C includes before all others: the build does not compile these by themselves.
second_headers() {
    local f
    comm -23 <(for f in base formats preprocess runtime; do sources "$f"; done | grep '\.h$' | sort) \
        <(for f in base formats preprocess runtime; do sources "$f"; done | grep '\.c$' |
            xargs grep -m1 -hP '^\s*#\s*include' | sed -n 's/.*"\(.*\)".*/\1/p' | sort -u)
}

check_headers() {
    local header
    second_headers | xargs "${CC:-cc}" -std=c17 -Wall -Wextra -Werror -D_GNU_SOURCE -I. -fsyntax-only -x c \
            2>"$FOLDER/err" || fail "a header does not compile by itself: $(head -3 "$FOLDER/err")"
    while read -r header; do
        grep -nE '\b(class|template|namespace|std::|public:)' "$header" |
            grep -v '^[0-9]*: *\*\|/\*' && fail "$header has C++ in it"
    done < <(for f in "${folders[@]}"; do sources "$f"; done | grep '_shim\.h$')
    return 0
}

for folder in "${!allowed[@]}"; do
    check_includes "$folder"
done
check_chunk
check_cpp
check_headers
end_test
