#!/usr/bin/env bash
# Tests the large real scans of test_scan_table.c, which takes half a minute on idle cores.
exec ./test_scan_table large
