#!/usr/bin/env bash
# The large real scans of test_scan_table.c, which take half a minute on quiet cores.
exec ./test_scan_table large
