#!/usr/bin/env bash
# Tests tools/bench/gpu as test_bench_gpu.sh does, with every program that draws.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_bench_gpu.sh" "$1" every
