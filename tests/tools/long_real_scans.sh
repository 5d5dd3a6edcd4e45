#!/usr/bin/env bash
# Prepares, verifies and draws every real scan as test_real_scans.sh does, large scans too, from
# more sides and in larger pictures. Skips unless STIPPLE_SCANS names a folder.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../support/shell.sh"
source "$(dirname "${BASH_SOURCE[0]}")/../support/real_scans.sh"

check_folder +0c 26 1024
end_test
