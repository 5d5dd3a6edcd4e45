#!/usr/bin/env bash
# Tests files of version 2 as test_convert_format.sh does, with more threads.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_convert_format.sh" "$1" every
