#!/usr/bin/env bash
# Tests the help, the exit codes and both streams, of the program and of every command that it
# lists.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

test_program() {
    run "$STIPPLE"
    expect_code 2
    expect_empty out
    expect_text err "usage: stipple"
    for words in --help -h help; do
        run "$STIPPLE" $words
        expect_code 0
        expect_empty err
        expect_text out "usage: stipple"
    done
    run "$STIPPLE" --version
    expect_code 0
    expect_empty err
    expect_lines out 1
    grep -qE '^stipple [0-9]+\.[0-9]+\.[0-9]+$' "$FOLDER/out" || fail "version: $(cat "$FOLDER/out")"
    run "$STIPPLE" prpe
    expect_usage "'prpe' is not a command"
    run "$STIPPLE" expotr
    expect_usage "did you mean export?"
    run "$STIPPLE" zzzzzzzz
    expect_usage "try stipple --help"
    run "$STIPPLE" help zzzzzzzz
    expect_usage "'zzzzzzzz' is not a command"
    run "$STIPPLE" --bogus
    expect_usage "--bogus"
    run "$STIPPLE" ''
    expect_usage "'' is not a command"
}

test_command() {
    local name=$1
    for words in "$name --help" "$name -h" "help $name" "$name --quiet --help" "$name x --help"; do
        # shellcheck disable=SC2086
        run "$STIPPLE" $words
        expect_code 0
        expect_empty err
        expect_text out "usage: stipple $name"
        expect_text out "--threads"
    done
    if awk 'length($0) > 100' "$FOLDER/out" | found .; then
        fail "$name --help has lines over 100 columns"
    fi
    run "$STIPPLE" "$name" --version
    expect_code 0
    expect_empty err
    expect_text out "stipple "
    run "$STIPPLE" "$name" --no-such-option
    expect_usage "--no-such-option is not an option"
    run "$STIPPLE" "$name" -Z
    expect_usage "-Z is not an option"
    run "$STIPPLE" "$name" --thraeds 2
    expect_usage "did you mean --threads?"
    run "$STIPPLE" "$name" --threads
    expect_usage "--threads needs a value"
    run "$STIPPLE" "$name" --threads many
    expect_usage "'many'"
    run "$STIPPLE" "$name" --threads 257
    expect_usage "256"
    run "$STIPPLE" "$name" --threads=-1
    expect_usage "'-1'"
    run "$STIPPLE" "$name" --quiet=1
    expect_usage "--quiet takes no value"
    run "$STIPPLE" "$name"
    expect_usage "try stipple $name --help"
}

# If a command cannot read its chunk file, it must say why.
test_reader() {
    local name=$1
    shift
    run "$STIPPLE" "$name" "$FOLDER/no such file" "$@"
    expect_failure "no such file"
    run "$STIPPLE" "$name" "$FOLDER" "$@"
    expect_failure "$FOLDER"
    : >"$FOLDER/empty.stipple"
    run "$STIPPLE" "$name" "$FOLDER/empty.stipple" "$@"
    expect_failure "empty.stipple"
    head -c 4096 /dev/zero >"$FOLDER/zero.stipple"
    run "$STIPPLE" "$name" "$FOLDER/zero.stipple" "$@"
    expect_failure "zero.stipple"
    run "$STIPPLE" "$name" "$FOLDER/line
break" "$@"
    expect_failure "line?break"
    run "$STIPPLE" "$name" "$FOLDER/line"$'\xc2\x9b'"break" "$@" # U+009B begins a command
    expect_failure "line?break"
}

[ -x "$STIPPLE" ] || { echo "no program: $STIPPLE" >&2; exit 1; }
test_program
commands=$("$STIPPLE" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
for name in gen prep info verify export compare; do
    grep -qx "$name" <<<"$commands" || fail "stipple --help lists no $name"
done
for name in $commands; do
    test_command "$name"
done
test_reader info
test_reader verify
test_reader export -o "$FOLDER/out.ply"
[ ! -e "$FOLDER/out.ply" ] || fail "a failed export left a file"
test_reader profile --line 0,0,1,1 -o "$FOLDER/out.csv"
[ ! -e "$FOLDER/out.csv" ] || fail "a failed profile left a file"
if grep -qx render <<<"$commands"; then
    test_reader render -o "$FOLDER/out.png"
else
    run "$STIPPLE" render M.stipple -o x.png
    expect_failure "STIPPLE_RUNTIME"
fi
run "$STIPPLE" info "$FOLDER/empty.stipple" --timeout 86401
expect_usage "--timeout takes seconds from 0 to 86400"
run "$STIPPLE" info "$FOLDER/empty.stipple" --timeout=-1
expect_usage "--timeout takes seconds from 0 to 86400"

# A file's name stands in the model's metadata. No control character of it reaches the terminal.
scan="$FOLDER/one"$'\xc2\x9b'"two.ply"
"$STIPPLE" gen plane -n 2000 -o "$scan" -q || fail "gen failed"
run "$STIPPLE" prep "$scan" -o "$FOLDER/control.stipple" -q
expect_code 0
run "$STIPPLE" info "$FOLDER/control.stipple"
expect_text out "one two.ply"
expect_text out "in 1 level"
LC_ALL=C grep -q $'\xc2\x9b' "$FOLDER/out" && fail "info passes U+009B to the terminal"
run bash -c "'$STIPPLE' --help >/dev/full"
expect_failure "standard output could not be written"
end_test
