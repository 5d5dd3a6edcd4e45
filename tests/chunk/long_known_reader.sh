#!/usr/bin/env bash
# Tests tests/known/read.py as test_known_reader.sh does, with every codec of every model.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_known_reader.sh" "$1" every
