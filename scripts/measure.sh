#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures the mapper: every figure of README.md, docs/algorithms/semantic_filter.md and smoothing.md.
#   scripts/measure.sh --help
exec python3 "$(dirname "${BASH_SOURCE[0]}")/measure.py" "$@"
