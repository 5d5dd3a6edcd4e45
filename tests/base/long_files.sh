#!/usr/bin/env bash
# Tests that files appear whole or not at all as test_files.sh does, with each film on each disk.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_files.sh" "$1" every
