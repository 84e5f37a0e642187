#!/usr/bin/env bash
# Checks an extension with Blender's own program: scripts/validate_extension.sh ZIP
# The program is blender_ext.py of $ISIMP_BLENDER_EXT, of a Python package bpy, or of the Blender on the PATH. If there
# is none, the script reports that, and the zip counts as not validated.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

zip=${1:?a zip}
program=${ISIMP_BLENDER_EXT:-}
if [ -z "$program" ]; then
  program=$(find "$root"/.venv-bpy-* -path '*bl_pkg/cli/blender_ext.py' 2>/dev/null | sort | tail -n 1 || true) # none: no such folder
fi
if [ -n "$program" ]; then
  "$python" "$program" validate "$zip"
elif has_extensions; then
  blender --command extension validate "$zip"
else
  echo "$(basename "$zip"): not validated, since no Blender from 4.2 on is here" >&2
fi
