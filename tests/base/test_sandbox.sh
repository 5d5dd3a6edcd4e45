#!/usr/bin/env bash
# Tests the sandbox: a command that reads hostile files keeps only the rights that it needs. Tests
# also that the programs are built with the protections of compiler and linker.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

if command -v readelf >/dev/null && [ -z "${STIPPLE_SANITIZE:-}" ]; then
    readelf -hW "$STIPPLE" | grep 'DYN' >/dev/null || fail "the program lies at a fixed address"
    readelf -dW "$STIPPLE" | grep NOW >/dev/null || fail "the program binds its calls late"
    readelf -lW "$STIPPLE" | grep GNU_RELRO >/dev/null || fail "the program's tables can be written to"
    readelf -sW "$STIPPLE" | grep __stack_chk_fail >/dev/null || fail "the stack is not watched"
fi

[ -n "${STIPPLE_SANDBOX_SHIM:-}" ] || skip_test "the sandbox is not tried: no module to preload"
model="$FOLDER/m.stipple"
"$STIPPLE" gen sphere -n 30000 -o "$FOLDER/s.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/s.ply" -o "$model" --quiet || fail "no model"
cp "$model" "$FOLDER/hurt.stipple"
printf 'x' | dd of="$FOLDER/hurt.stipple" bs=1 seek=20 conv=notrunc status=none

tried() { # $1: the rights that the command must have at its end
    run env LD_PRELOAD="$STIPPLE_SANDBOX_SHIM" "$STIPPLE" "${@:2}"
    expect_code 0
    expect_text err "$1"
}
tried "reads 1 writes 1 connects 1" info "$model" --no-sandbox
run env LD_PRELOAD="$STIPPLE_SANDBOX_SHIM" "$STIPPLE" info "$model"
grep -q 'reads 0' "$FOLDER/err" || skip_test "this kernel has no Landlock"
all="reads 0 writes 0"
grep -q 'connects 0' "$FOLDER/err" && all="$all connects 0"
tried "$all" info "$model"
tried "$all" verify "$model"
tried "$all" export "$model" -o "$FOLDER/e.ply"
tried "$all" profile "$model" --line=-9,0,9,0 -o "$FOLDER/p.csv"
tried "$all" convert "$model" -o "$FOLDER/c.stipple" --codec zstd
tried "$all" convert "$model" -o "$FOLDER/c.stipple" --codec draco --force
tried "$all" verify "$FOLDER/hurt.stipple" --repair -o "$FOLDER/r.stipple"
cd "$FOLDER" || exit 1
tried "$all" export m.stipple -o here.ply
[ -s here.ply ] && [ -s e.ply ] && [ -s c.stipple ] && [ -s r.stipple ] || fail "no output"
run "$STIPPLE" info none.stipple
expect_failure "none.stipple: cannot be opened: No such file"
end_test
