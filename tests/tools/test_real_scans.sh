#!/usr/bin/env bash
# Prepares, verifies and draws every real scan except the large ones. Skips unless STIPPLE_SCANS
# names a folder: the project may not distribute the scans.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/real_scans.sh"

check_folder -100000000c 6 192
end_test
