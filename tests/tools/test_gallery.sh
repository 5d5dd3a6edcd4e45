#!/usr/bin/env bash
# Tests tools/gallery: counts, pictures, command lines and sentences for good, damaged and
# unreadable scans, and folders and files with spaces, quotes and accents.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"

"$STIPPLE" --help | found '^  render ' || skip_test "built without the renderer"
scans="$FOLDER/Gänge & <Säle>"
out="$FOLDER/Bilder im Haus"
page="$out/index.html"
model="$out/models/l'été/ball [1].PLY.stipple"

gallery() {
    run bash "$SOURCE/tools/gallery" --build "${STIPPLE%/*}" "$@"
}

expect_page() { # a fixed text in the page
    grep -qF -- "$1" "$page" || fail "no '$1' in the page"
}

make_scans() {
    mkdir -p "$scans/l'été"
    "$STIPPLE" gen sphere -n 3000 -o "$scans/l'été/ball [1].PLY" --quiet || { fail "no scan"; end_test; }
    printf '%s\n' '1 2 3' '4 5 7' '2 4 1' 'nan 1 1' '3 3 2' '5 1 2' >"$scans/six.xyz"
    echo 'no scan' >"$scans/broken.ply"
    echo 'no scan' >"$scans/notes.md"
    echo 'no scan' >"$scans/.hidden.ply"
}

test_usage() {
    gallery --help
    expect_code 0
    expect_text out "tools/gallery"
    gallery
    expect_usage "name a folder"
    gallery --no-such "$scans"
    expect_usage "--no-such is not an option"
    gallery "$scans" "$scans"
    expect_usage "one folder"
    gallery -o
    expect_usage "-o needs a value"
    gallery "$FOLDER/none" -o "$out"
    expect_failure "is no folder"
    mkdir "$FOLDER/empty"
    gallery "$FOLDER/empty" -o "$out"
    expect_failure "no file with the name of a scan"
    gallery "$scans" -o "$scans"
    expect_failure "is there and is no gallery"
}

test_page() {
    local picture size
    gallery "$scans" -o "$out" --size 96x64
    expect_code 0
    [ "$(cat "$FOLDER/out")" = "$page" ] || fail "stdout is not the page: $(cat "$FOLDER/out")"
    [ "$(grep -c '<section' "$page")" = 3 ] || fail "$(grep -c '<section' "$page") scans, expected 3"
    expect_page "<h1>$(sed 's/&/\&amp;/; s/</\&lt;/; s/>/\&gt;/' <<<"$scans")</h1>"
    expect_page "<td>3,000</td><td>3,000</td><td>0</td>"
    expect_page "<td>6</td><td>5</td><td>1 not_finite</td>"
    expect_page "broken.ply: PLY header line 1"
    expect_page "ball [1].PLY.stipple: sound: 3000 points"
    [ "$(grep -c '<td>sound</td>' "$page")" = 2 ] || fail "two models are sound, the page says otherwise"
    [ "$(grep -c '<td>refused</td>' "$page")" = 1 ] || fail "one scan is refused, the page says otherwise"
    [ "$(grep -c '<img' "$page")" = 10 ] || fail "$(grep -c '<img' "$page") pictures, expected 10"
    while read -r picture; do
        size=$(od -An -tu4 --endian=big -j16 -N8 "$out/$picture" | tr -s ' ')
        [ "$size" = " 96 64" ] || fail "$picture is$size, expected 96 64"
    done < <(grep -oP 'src="\K[^"]*' "$page")
    if command -v ffmpeg >/dev/null; then
        size=$(od -An -tu4 --endian=big -j16 -N8 "$out/contact-1.png" | tr -s ' ')
        [ "$size" = " 1300 2080" ] || fail "the contact sheet is$size, expected 1300 2080"
    fi
}

# The command lines on the page must make the pictures on the page.
test_commands() {
    local line picture="$out/pictures/2/first.png"
    stipple() { "$STIPPLE" "$@" --quiet; }
    line=$(grep -F ' render ' "$page" | sed -n 's/&amp;/\&/g; s/&lt;/</g; s/&gt;/>/g; s/&quot;/"/g; 1p')
    [ -n "$line" ] || fail "no render on the page"
    mv "$picture" "$FOLDER/kept.png"
    eval "$line --force" || fail "not a command: $line"
    cmp -s "$picture" "$FOLDER/kept.png" || fail "not the page's picture: $line"
}

# A model is used again unless its scan is newer. A damaged model must be found.
test_again() {
    local again="$out/models/six.xyz.stipple" before
    printf '\x55\xaa\x55' | dd of="$model" bs=1 seek=3000 conv=notrunc status=none
    before=$(stat -c %y "$model" "$again")
    touch -d 'next minute' "$scans/six.xyz"
    gallery "$scans/" -o "$out" --size 64x64
    expect_code 1
    [ "$(stat -c %y "$model")" = "$(head -1 <<<"$before")" ] || fail "a model was made again"
    [ "$(stat -c %y "$again")" != "$(tail -1 <<<"$before")" ] || fail "the model of a newer scan was not made again"
    expect_text err "ball [1].PLY: stipple verify: "
    [ "$(grep -c '<td>damaged</td>' "$page")" = 1 ] || fail "the page does not say that a model is damaged"
}

# If prep crashes, the gallery may not count it as a refusal. Another program stands in for the
# crashing prep.
test_crash() {
    mkdir -p "$FOLDER/stand-in" "$FOLDER/one"
    printf '%s\n' '#!/bin/sh' '[ "$1" != prep ] || kill -SEGV $$' >"$FOLDER/stand-in/stipple"
    chmod +x "$FOLDER/stand-in/stipple"
    cp "$scans/six.xyz" "$FOLDER/one"
    run bash "$SOURCE/tools/gallery" --build "$FOLDER/stand-in" "$FOLDER/one" -o "$FOLDER/crashed"
    expect_code 1
    expect_text err "six.xyz: stipple prep ended with exit code 139"
    grep -qF '<td>not prepared</td>' "$FOLDER/crashed/index.html" || fail "the page does not say that prep crashed"
}

# The gallery must take the same files of a folder as prep.
test_endings() {
    local ending count=0
    while read -r ending; do
        count=$((count + 1))
        grep -qE "[(|]${ending}[\\\\|]" "$SOURCE/tools/gallery" || fail "prep takes .$ending, the gallery does not"
    done < <(sed -n '/endings\[\] = /,/;/p' "$SOURCE/tools/prep/prep_paths.c" | grep -oP '"\.\K[a-z0-9]+')
    [ $count -ge 14 ] || fail "prep's endings were not found"
}

make_scans
test_usage
test_page
test_commands
test_again
test_crash
test_endings
end_test
