#!/usr/bin/env bash
# Every real scan, large ones too, is prepared, verified and drawn as by test_real_scans.sh, from more sides and larger.
# Skipped where STIPPLE_SCANS names no folder.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/real_scans.sh"

check_folder +0c 26 1024
end_test
