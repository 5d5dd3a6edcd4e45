# shellcheck shell=bash disable=SC2034
# A real web server for tests, to be sourced after shell.sh. Skips the test if nginx is missing.
nginx=$(command -v nginx || ls /usr/sbin/nginx 2>/dev/null) || skip_test "nginx is not installed"
unset http_proxy https_proxy all_proxy ALL_PROXY HTTPS_PROXY

# start_nginx FOLDER: serves a folder on a free port as the current user, until the test ends; sets
# `port` and `web`. The test's function `server_body PORT SECOND_PORT` prints what else the server
# block has. Requests are logged in $FOLDER/access.log.
start_nginx() {
    local try
    for try in 1 2 3 4 5 6 7 8; do
        port=$((20000 + (RANDOM * 32768 + RANDOM) % 12000 * 2))
        web=http://127.0.0.1:$port
        cat >"$FOLDER/nginx.conf" <<CONF
worker_processes 1;
daemon off;
pid $FOLDER/nginx.pid;
error_log $FOLDER/nginx.log;
$([ "$(id -u)" = 0 ] && echo "user root;")
events { worker_connections 64; }
http {
    access_log $FOLDER/access.log;
    limit_conn_zone \$server_port zone=crowd:64k;
    client_body_temp_path $FOLDER/t1; proxy_temp_path $FOLDER/t2; fastcgi_temp_path $FOLDER/t3;
    uwsgi_temp_path $FOLDER/t4; scgi_temp_path $FOLDER/t5;
    server {
        listen 127.0.0.1:$port;
        root $1;
$(server_body $port $((port + 1)))
    }
}
CONF
        "$nginx" -p "$FOLDER" -c "$FOLDER/nginx.conf" -e "$FOLDER/nginx.log" 2>"$FOLDER/started" &
        server=$!
        for _ in $(seq 100); do
            if [ -s "$FOLDER/nginx.pid" ]; then
                trap 'kill "$server" 2>/dev/null; wait "$server" 2>/dev/null; rm -rf "$FOLDER"' EXIT
                return
            fi
            kill -0 "$server" 2>/dev/null || break
            sleep 0.05
        done
        kill "$server" 2>/dev/null
        wait "$server"
    done
    skip_test "nginx does not start: $(head -1 "$FOLDER/started")"
}
