#!/usr/bin/env bash
# Tests stipple render as test_render.sh does, with more combinations of its options.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_render.sh" "$1" every
