#!/usr/bin/env bash
# Tests models on a real web server, nginx: all commands, no ranges, compression, https, a slow
# line, the cache, and a file that is replaced.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/nginx.sh"

root=$FOLDER/www
mkdir -p "$root/a b"
"$STIPPLE" gen bumpy -n 200000 -o "$FOLDER/a.ply" --quiet || fail "no scan"
"$STIPPLE" prep "$FOLDER/a.ply" -o "$root/a b/é.stipple" --quiet || fail "no model"
model=$root/a\ b/é.stipple
ln "$model" "$root/m.stipple"
bytes=$(stat -c %s "$model")

# ---- the server: on a free port, as the current user ----

secure=
if openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost \
    -addext subjectAltName=IP:127.0.0.1 -keyout "$FOLDER/key.pem" -out "$FOLDER/cert.pem" \
    2>/dev/null; then
    secure=yes
fi

server_body() { # port, port of https
    cat <<BODY
        ${secure:+listen 127.0.0.1:$2 ssl; ssl_certificate $FOLDER/cert.pem; ssl_certificate_key $FOLDER/key.pem;}
        location /slow/ { alias $root/; limit_rate 200k; }
        location /few/ { alias $root/; limit_rate 100k; limit_conn crowd 1; }
        location /whole/ { alias $root/; max_ranges 0; }
        location /single/ { alias $root/; max_ranges 1; }
        location /moved/ { return 302 /m.stipple; }
        location /secret/ { return 403; }
        location /busy/ { return 503; }
BODY
}

start_nginx "$root"

# Count requests and body bytes since log_begin.
log_begin() { : >"$FOLDER/access.log"; }
log_bytes() { awk '{ n += $10 } END { print n + 0 }' "$FOLDER/access.log"; }
expect_requests() { # nginx writes its log a moment after its answer
    local requests
    for _ in $(seq 40); do
        requests=$(wc -l <"$FOLDER/access.log")
        [ "$requests" -ge "$1" ] && break
        sleep 0.05
    done
    [ "$requests" = "$1" ] || fail "$command: $requests requests, expected $1"
}

# ---- opening ----

log_begin
run "$STIPPLE" info "$web/a b/é.stipple" --json
expect_code 0
expect_empty err
expect_requests 2
[ "$(log_bytes)" -lt $((bytes / 2)) ] || fail "info took $(log_bytes) of $bytes bytes"
sed 's/"file":.*//' "$FOLDER/out" >"$FOLDER/far"
"$STIPPLE" info "$model" --json | sed 's/"file":.*//' | cmp -s - "$FOLDER/far" ||
    fail "info says other things of the far model"

run "$STIPPLE" verify "$web/m.stipple" --quiet
expect_code 0
run "$STIPPLE" export "$web/moved/x" -o "$FOLDER/far.ply" --quiet
expect_code 0
"$STIPPLE" export "$model" -o "$FOLDER/near.ply" --quiet
cmp -s "$FOLDER/far.ply" "$FOLDER/near.ply" || fail "export of the far model differs"

run "$STIPPLE" convert "$web/a b/é.stipple" -o "$FOLDER/far.stipple" --codec zstd --threshold 2 --quiet
expect_code 0
"$STIPPLE" convert "$model" -o "$FOLDER/near.stipple" --codec zstd --threshold 2 --quiet
cmp -s "$FOLDER/far.stipple" "$FOLDER/near.stipple" || fail "convert of the far model differs"
run "$STIPPLE" convert "$web/nowhere.stipple" -o "$FOLDER/none.stipple"
expect_failure "check the address"
[ ! -e "$FOLDER/none.stipple" ] || fail "convert of a model that is not there left a file"

# ---- failures: each in one sentence ----

truncate -s 256M "$root/large.stipple"
log_begin
run "$STIPPLE" info "$web/whole/large.stipple"
expect_failure "no byte ranges"
expect_requests 1
[ "$(log_bytes)" -lt 100000000 ] || fail "a server without ranges sent $(log_bytes) bytes"
run "$STIPPLE" info "$web/nowhere.stipple"
expect_failure "check the address"
run "$STIPPLE" info "http://me:sesame@${web#http://}/secret/m.stipple?key=opens"
expect_failure "refuses access (403)"
! grep -q -e sesame -e opens "$FOLDER/err" || fail "a password is printed"
run "$STIPPLE" info "$web/busy/m.stipple"
expect_failure "answers 503"
: >"$root/empty.stipple"
run "$STIPPLE" info "$web/empty.stipple"
expect_failure "not a stipple chunk file"
head -c 1000 "$model" >"$root/cut.stipple"
run "$STIPPLE" info "$web/cut.stipple"
expect_failure "cut"
cp "$FOLDER/a.ply" "$root/a.ply"
run "$STIPPLE" info "$web/a.ply"
expect_failure "not a stipple chunk file"
run "$STIPPLE" verify --repair "$web/m.stipple" -o "$FOLDER/r.stipple"
expect_usage "copy the file here"

# ---- https: certificates are checked ----

if [ -n "$secure" ]; then
    run "$STIPPLE" info "https://127.0.0.1:$((port + 1))/m.stipple"
    expect_failure "certificate is not trusted"
    run env CURL_CA_BUNDLE="$FOLDER/cert.pem" "$STIPPLE" info \
        "https://127.0.0.1:$((port + 1))/m.stipple"
    expect_code 0
fi

# ---- pictures ----

"$STIPPLE" --help | found '^  render ' || end_test
render() { # model, picture, options...
    run "$STIPPLE" render "$1" -o "$FOLDER/$2" --size 128x128 --force \
        --stats "$FOLDER/stats.json" "${@:3}"
    expect_code 0
}
same() { cmp -s "$FOLDER/$1" "$FOLDER/$2" || fail "$1 and $2 differ"; }

render "$model" near.png
render "$web/m.stipple" far.png
expect_empty err
same near.png far.png
[ "$(field retries)" = 0 ] && [ "$(field requests)" -gt 2 ] || fail "the stats are not those of a server"
render "$web/slow/m.stipple" slow.png
same near.png slow.png

# Many ranges in a request bring the same picture as one in each.
render "$model" all.png --threshold 0
render "$web/m.stipple" ranges.png --threshold 0
same all.png ranges.png
render "$web/single/m.stipple" single.png --threshold 0
same all.png single.png
[ "$(field retries)" = 0 ] || fail "$(field retries) retries"

# A server that takes one request at a time, and refuses others by 503, soon gets them one by one.
log_begin
render "$web/few/m.stipple" few.png --threshold 0
same all.png few.png
refused=$(grep -c '" 503 ' "$FOLDER/access.log")
[ "$refused" -gt 0 ] && [ "$refused" -le 20 ] || fail "the server refused $refused requests"

# The cache: the second picture costs one request, and a damaged range is fetched again.
cache=$FOLDER/cache\ folder
render "$web/m.stipple" first.png --cache "$cache" --cache-size 1M
log_begin
render "$web/m.stipple" second.png --cache "$cache" --cache-size 1M
same near.png second.png
expect_requests 1
victim=$(ls "$cache"/*.range | head -1)
printf 'damage' | dd of="$victim" bs=1 seek=100 conv=notrunc status=none
render "$web/m.stipple" third.png --cache "$cache" --cache-size 1M
same near.png third.png
[ "$(field cache_damaged)" = 1 ] || fail "the damage was not counted"
render "$web/m.stipple" fourth.png --cache "$cache" --cache-size 100K
same near.png fourth.png
total=$(cat "$cache"/*.range 2>/dev/null | wc -c)
[ "$total" -le $((100 * 1024)) ] || fail "the cache has $total bytes, its budget is 102400"

# If the cache folder is unusable, one warning says so, and the picture is right.
render "$web/m.stipple" fifth.png --cache "$FOLDER/a.ply"
same near.png fifth.png
expect_lines err 1
expect_text err "warning: $FOLDER/a.ply: nothing can be kept there"

# Another file replaces the model under the same name: nothing of the old file may be used.
"$STIPPLE" gen torus -n 100000 -o "$FOLDER/b.ply" --quiet
"$STIPPLE" prep "$FOLDER/b.ply" -o "$FOLDER/b.stipple" --quiet
render "$FOLDER/b.stipple" torus.png
cp "$FOLDER/b.stipple" "$root/new" && mv -f "$root/new" "$root/m.stipple"
render "$web/m.stipple" far_torus.png --cache "$cache"
same torus.png far_torus.png

# If a chunk is damaged on the server, only that chunk is lost. `--cull none` draws all, so it reads the damaged byte.
chunks=$("$STIPPLE" info "$model" | sed -n 's/^chunks *\([0-9]*\) .*/\1/p')
cp "$model" "$root/bad.stipple"
printf 'damage' | dd of="$root/bad.stipple" bs=1 seek=10000 conv=notrunc status=none
run "$STIPPLE" render "$web/bad.stipple" -o "$FOLDER/bad.png" --size 128x128 --threshold 0 --cull none
if [ "$chunks" -gt 1 ]; then
    expect_failure "--allow-damage"
    [ ! -e "$FOLDER/bad.png" ] || fail "a picture that lacks a chunk"
    run "$STIPPLE" render "$web/bad.stipple" -o "$FOLDER/bad.png" --size 128x128 --threshold 0 \
        --cull none --allow-damage --quiet
    expect_code 0
    expect_text err "its parent is drawn instead"
fi
end_test
