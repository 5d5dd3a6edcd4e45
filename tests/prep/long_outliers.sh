#!/usr/bin/env bash
# Tests prep --outliers as test_outliers.sh does, with more threads and memory.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_outliers.sh" "$1" every
