#!/usr/bin/env bash
# Every real scan but the large ones is prepared, verified and drawn. Skipped where STIPPLE_SCANS names no folder: the
# scans are not the project's.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/real_scans.sh"

check_folder -100000000c 6 192
end_test
