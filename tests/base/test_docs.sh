#!/usr/bin/env bash
# Tests the pages: every link has a target, README is short, no page or comment cites a file outside
# the repository, and the site that tools/site builds has no dead link. Without pandoc the test
# skips the site, after the other checks.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
cd "$SOURCE" || exit 1

# Prints the anchors of a page's headings, as GitHub makes them.
anchors() { # page
    sed -n '/^```/,/^```/d; s/^#\{1,6\} //p' "$1" | tr '[:upper:]' '[:lower:]' | sed -E 's/[^a-z0-9 _-]//g; s/ /-/g'
}

# Whether a page has a heading with this anchor. A program that is started costs a hundredth of a second, so that each
# page is searched once.
declare -A headings
has_heading() { # page, anchor
    [ -n "${headings[$1]:-}" ] || headings[$1]=$'\n'$(anchors "$1")$'\n'
    [[ ${headings[$1]} == *$'\n'"$2"$'\n'* ]]
}

check_links() { # page
    local page=$1 folder=. link file part
    [[ $page != */* ]] || folder=${page%/*}
    while read -r link; do
        file=${link%%#*}
        part=
        case $link in
            *://* | mailto:*) continue ;;
            *'#'*) part=${link#*#} ;;
        esac
        [ -n "$file" ] && file=$folder/$file || file=$page
        if [ ! -e "$file" ]; then
            fail "$page links to $link, which is not there"
        elif [ -n "$part" ] && ! has_heading "$file" "$part"; then
            fail "$page links to $link: $file has no such heading"
        fi
    done < <(grep -oP '\]\(\K[^) ]+' "$page")
}

for page in *.md docs/*.md benchmarks/*.md shaders/*.md formats/*.md; do
    check_links "$page"
done

# Every file that the map or the glossary names in full must exist.
while read -r file; do
    [ -e "$file" ] || fail "$file is named, but not there"
done < <(grep -ohP '`\K(base|formats|preprocess|runtime|shaders|tools|tests|cmake)/[a-z0-9_/]+\.(h|c|cpp|glsl|frag|geom|comp|sh|md|txt|cmake)(?=`)' \
    ARCHITECTURE.md docs/glossary.md docs/algorithms.md | sort -u)

# So must every name of the code.
git grep -hoE '\b(stp|STP)_[A-Za-z0-9_]+' -- '*.c' '*.h' '*.cpp' shaders 2>/dev/null | sort -u >"$FOLDER/names"
[ ! -s "$FOLDER/names" ] || while read -r name; do
    fail "$name is named by a page, but not in the code"
done < <(grep -ohE '`(stp|STP)_[A-Za-z0-9_]+`' ARCHITECTURE.md docs/*.md | tr -d '`' | sort -u | comm -23 - "$FOLDER/names")

[ "$(wc -l <README.md)" -le 150 ] || fail "README.md has $(wc -l <README.md) lines, more than 150"
[ "$(wc -w <README.md)" -le 1500 ] || fail "README.md has $(wc -w <README.md) words, more than 1,500"
[ "$(wc -l <ARCHITECTURE.md)" -le 120 ] || fail "ARCHITECTURE.md has $(wc -l <ARCHITECTURE.md) lines, more than 120"

# Readers of the code cannot open documents from elsewhere. Each name is split in two here, so that
# this file does not match.
foreign="DESIGN\.m""d|ALGOR""ITHMS|CG""08|PBG""07|TUT""08"
found=$(git grep -nE "$foreign" 2>/dev/null | head -5)
[ -z "$found" ] || fail "a document that is not in the repository is cited: $found"

[ "$failures" = 0 ] || end_test
command -v pandoc >/dev/null || skip_test "pandoc is not installed: no site built"

run bash tools/site -o "$FOLDER/site"
expect_code 0
expect_text out "$FOLDER/site/index.html"
declare -A parts
has_part() { # page of the site, id
    [ -n "${parts[$1]:-}" ] || parts[$1]=$'\n'$(grep -oP 'id="\K[^"]*' "$1")$'\n'
    [[ ${parts[$1]} == *$'\n'"$2"$'\n'* ]]
}
while read -r page; do
    folder=${page%/*}
    while read -r link; do
        file=${link%%#*}
        part=
        [[ $link != *'#'* ]] || part=${link#*#}
        [ -n "$file" ] && file=$folder/$file || file=$page
        if [ ! -e "$file" ]; then
            fail "${page#"$FOLDER"/}: dead link $link"
        elif [[ -n $part && $file == *.html ]] && ! has_part "$file" "$part"; then
            fail "${page#"$FOLDER"/}: $link leads to no part of the page"
        fi
    done < <(grep -oP '(href|src)="\K[^"]+' "$page" | grep -v '^[a-z]*:' | sort -u)
done < <(find "$FOLDER/site" -name '*.html')

# tools/site must not touch a folder that it did not make.
mkdir "$FOLDER/mine"
touch "$FOLDER/mine/thesis"
run bash tools/site -o "$FOLDER/mine"
expect_code 1
[ -e "$FOLDER/mine/thesis" ] || fail "tools/site removed a folder that is not its own"
end_test
