#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tables of the paper, ours beside theirs, for what is under ROOT of VISMA and SceneNN (docs/data_sets.md).
#   scripts/reproduce_paper.sh ROOT [--help]
exec python3 "$(dirname "${BASH_SOURCE[0]}")/reproduce_paper.py" "$@"
