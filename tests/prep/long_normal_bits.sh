#!/usr/bin/env bash
# Tests prep --normal-bits as test_normal_bits.sh does, with every number of bits in each codec.
exec bash "$(dirname "${BASH_SOURCE[0]}")/test_normal_bits.sh" "$1" every
