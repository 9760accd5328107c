#!/usr/bin/env bash
# Usage: tests/mesh_check.sh PROGRAM SAMPLE-FOLDER
#
# Meshes of the bundled sample, judged by another library: tests/mesh_check.py.

set -eu
program=$1
sample=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

/usr/bin/python3 -c 'import open3d' 2>/dev/null || {
  echo "skipped: no Open3D (package python3-open3d)"
  exit 77
}
"$program" run --data "$sample" --seeds 8000 -o "$work/cloud.ply"
mesh() { "$program" mesh "$work/cloud.ply" --data "$sample" --resolution 0.004 "$@"; }
mesh -o "$work/open.ply"
/usr/bin/python3 "$here/mesh_check.py" "$work/open.ply"
mesh --whole -o "$work/closed.ply"
/usr/bin/python3 "$here/mesh_check.py" "$work/closed.ply" --closed
mesh --faces 3000 -o "$work/few.ply"
/usr/bin/python3 "$here/mesh_check.py" "$work/few.ply"
