#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures the mapper: every figure of README.md, docs/accuracy.md (by accuracy_page.py) and docs/algorithms/smoothing.md.
#   scripts/measure.sh --help
# The visual-inertial filter, for docs/algorithms/vio.md:
#   scripts/measure.sh --only vio [--help]
# Synthetic streets, for docs/algorithms/outdoors.md:
#   scripts/measure.sh --only streets [--help]
here=$(dirname "${BASH_SOURCE[0]}")
if [[ "$1" == --only && "$2" == vio ]]; then
  exec python3 "$here/measure_vio.py" "${@:3}"
fi
if [[ "$1" == --only && "$2" == streets ]]; then
  exec python3 "$here/measure_streets.py" "${@:3}"
fi
exec python3 "$here/measure.py" "$@"
