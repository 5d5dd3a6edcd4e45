#!/usr/bin/env bash
# Tests `cmake --install` into a folder with a space in its name: program, module, library, headers,
# pkg-config file, manual page and completion must work there, also staged by DESTDIR and moved. The
# example must build against the installed library and draw.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
BUILD=${STIPPLE%/*}
PREFIX="$FOLDER/in stall"

install_to() { # prefix
    cmake --install "$BUILD" --prefix "$1" >"$FOLDER/log" 2>&1 ||
        fail "cmake --install: $(tail -3 "$FOLDER/log")"
}

test_program() { # prefix
    run "$1/bin/stipple" --version
    expect_code 0
    expect_text out "stipple "
    run "$1/bin/stipple" gen bumpy -n 300 -o "$FOLDER/a.ply" --truth "$FOLDER/truth.png" --force --size 32x32
    expect_code 0 # the picture needs the module, which lies nowhere else
    rm -f "$FOLDER/truth.png"
    { grep -rIF -- "$BUILD" "$1"
      find "$1" -type f \( -name '*.so*' -o -name stipple \) -exec readelf -d {} + 2>/dev/null |
          grep -F -- "$BUILD"; } >"$FOLDER/found"
    [ ! -s "$FOLDER/found" ] || fail "the build folder is named: $(head -3 "$FOLDER/found")"
}

# An incomplete build must install nothing.
test_incomplete() {
    cmake -S "$SOURCE" -B "$FOLDER/bare" -DSTIPPLE_TESTS=OFF >"$FOLDER/log" 2>&1 || fail "no configuration"
    if cmake --install "$FOLDER/bare" --prefix "$FOLDER/half" >"$FOLDER/log" 2>&1; then
        fail "an empty build was installed"
    fi
    grep -q 'is not built yet: run cmake --build' "$FOLDER/log" || fail "no sentence: $(tail -3 "$FOLDER/log")"
    [ ! -e "$FOLDER/half" ] || fail "an incomplete build installed files: $(find "$FOLDER/half" -type f | head -3)"
}

# The manual must have every command and option of the help, and roff must not warn.
test_manual() {
    local page=$PREFIX/share/man/man1/stipple.1 name option
    [ -s "$page" ] || fail "no manual page"
    if command -v groff >/dev/null; then
        run groff -man -Tutf8 -ww "$page"
        expect_empty err
    fi
    local text
    text=$(sed 's/\\-/-/g; s/\\f[BIR]//g' "$page" | tee "$FOLDER/page")
    for name in $commands; do
        grep -qxF ".SS \"stipple $name\"" "$FOLDER/page" || fail "no $name in the manual page"
        "$STIPPLE" "$name" --help | grep -oE '^  (-[a-zA-Z], )?--?[a-z-]+' | sed 's/^ *//' |
            while read -r option; do
                [[ $text == *$'\n'"$option"[$' \n']* ]] || echo "$name $option"
            done >"$FOLDER/missing"
        [ ! -s "$FOLDER/missing" ] || fail "not in the manual page: $(head -3 "$FOLDER/missing")"
    done
}

# complete_words WORDS...: prints what completion offers for the last word, on one line.
complete_words() {
    bash --norc -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _stipple
        echo "${COMPREPLY[@]}"' - "$PREFIX/share/bash-completion/completions/stipple" "$@" \
        2>/dev/null
}

# Reads options of a command and prints those that are not completed; one shell for all.
not_completed() { # command
    bash --norc -c 'source "$1"
        while read -r option; do
            COMPREPLY=() COMP_WORDS=(stipple "$2" "$option") COMP_CWORD=2
            _stipple
            [[ " ${COMPREPLY[*]} " == *" $option "* ]] || echo "$option"
        done' - "$PREFIX/share/bash-completion/completions/stipple" "$1" 2>/dev/null
}

expect_words() { # expected, words...
    local expected=$1 found
    shift
    found=$(complete_words "$@")
    [ "$found" = "$expected" ] || fail "completing '$*': '$found', expected '$expected'"
}

test_completion() {
    local name option
    expect_words 'prep' stipple pre
    expect_words '--threads' stipple gen --thr
    expect_words 'keep mark drop' stipple prep --outliers ''
    expect_words 'drop' stipple prep --outliers = d
    expect_words 'scan random' stipple gen --order =
    expect_words '' stipple prep -o ''
    expect_words '' stipple prep --neighbours ''
    expect_words 'verify' stipple help ve
    for name in $commands; do
        [ "$(complete_words stipple "$name" | tr ' ' '\n' | head -1)" = "$name" ] ||
            fail "$name is not completed"
        while read -r option; do
            fail "$name $option is not completed"
        done < <("$STIPPLE" "$name" --help | grep -oE '^  (-[a-zA-Z], )?--[a-z-]+' | grep -oE -- '--.*' | not_completed "$name")
    done
}

# The library exports what its headers declare and nothing else; the headers compile as C and C++.
test_library() {
    local header=$PREFIX/include/stipple declared shown lang
    declared=$(cat "$header"/*.h | grep -v '^static inline' | grep -oE '\bstp_[a-z0-9_]+\(' | tr -d '(' | sort -u)
    shown=$("${NM:-nm}" -D --defined-only "$PREFIX/lib/libstipple.so" | sed 's/.* //; s/@.*//' | sort)
    [ "$declared" = "$shown" ] ||
        fail "declared and exported names differ: $(diff <(echo "$declared") <(echo "$shown") | head -3)"
    for lang in c:-std=c11 c++:-std=c++11; do
        echo '#include <stipple/gl_context.h>
#include <stipple/stipple.h>' |
            "${CC:-cc}" -Wall -Wextra -Werror -pedantic -fsyntax-only -x "${lang%%:*}" "${lang#*:}" \
                -I "$PREFIX/include" - 2>"$FOLDER/err" ||
            fail "the headers in ${lang%%:*}: $(head -2 "$FOLDER/err")"
    done
}

test_example() {
    export PKG_CONFIG_PATH=$1/lib/pkgconfig
    "$STIPPLE" gen bumpy -n 20000 -o "$FOLDER/s.ply" --quiet
    "$STIPPLE" prep "$FOLDER/s.ply" -o "$FOLDER/s.stipple" --quiet
    { cmake -S "$SOURCE/examples" -B "$FOLDER/example" && cmake --build "$FOLDER/example"; } \
        >"$FOLDER/log" 2>&1 || fail "the example does not build: $(grep -m 2 -i error "$FOLDER/log")"
    if ldd "$1/lib/libstipple.so" | grep -E 'lib[a-z]+san' >/dev/null; then
        return # a library with a sanitizer can only be linked into a program with the same sanitizer
    fi
    run env LD_LIBRARY_PATH="$1/lib" "$FOLDER/example/embed" "$FOLDER/s.stipple" "$FOLDER/s.ppm"
    if grep -q 'OpenGL' "$FOLDER/err"; then
        echo "the example not run: $(cat "$FOLDER/err")"
        return
    fi
    expect_code 0
    expect_empty err
    [ "$(head -c 15 "$FOLDER/s.ppm" | tr '\n' ' ')" = "P6 800 600 255 " ] || fail "no picture"
    run env LD_LIBRARY_PATH="$1/lib" "$FOLDER/example/embed" "$FOLDER/none" "$FOLDER/s.ppm"
    expect_failure "none"
    [ "$(wc -l <"$SOURCE/examples/embed.c")" -lt 150 ] || fail "the example has 150 lines or more"
}

install_to "$PREFIX"
commands=$("$STIPPLE" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
test_program "$PREFIX"
test_manual
test_completion
test_incomplete
if [ -e "$PREFIX/lib/libstipple.so" ]; then
    test_library
    mv "$PREFIX" "$FOLDER/moved"
    PREFIX=$FOLDER/moved
    test_program "$PREFIX"
    test_example "$PREFIX"
fi
DESTDIR=$FOLDER/stage install_to /usr
[ -x "$FOLDER/stage/usr/bin/stipple" ] || fail "DESTDIR is not obeyed"
end_test
