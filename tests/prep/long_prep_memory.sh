#!/usr/bin/env bash
# Tests prep within given memory as test_prep_memory.sh does, with more threads and amounts.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_prep_memory.sh" "$1" every
