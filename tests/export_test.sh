#!/usr/bin/env bash
# Usage: tests/export_test.sh PROGRAM SAMPLE-FOLDER
#
# `livemvs export`, and what `livemvs mesh` writes, on good input and bad: exit codes, messages, files, and what COLMAP and
# assimp read of it.

set -u
# shellcheck source=support/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/support/expect.sh"

export_() { "$program" export "$@"; }
cloud="$work/cloud.ply"
expect 0 "points from 40 frames" "$program" run --data "$sample" --seeds 12000 --last-frame 39 -o "$cloud"

# --- Good input -------------------------------------------------------------------------------------
for ending in glb las ply; do
  expect 0 "out.$ending" export_ "$cloud" -o "$work/out.$ending"
  check "out.$ending is empty" test -s "$work/out.$ending"
done
expect 0 "out.obj" export_ "$sample/mesh.ply.gz" -o "$work/out.obj"
check "there is no material" grep -q newmtl "$work/out.mtl"

for form in colmap nerfstudio; do
  expect 0 "40 pictures" export_ "$cloud" --data "$sample" --last-frame 39 --format "$form" --points 300 -o "$work/$form"
  expect 0 "points from 40 frames" "$program" run --data "$work/$form" --seeds 12000 -o "$work/$form.ply"
  expect 0 "40" "$program" info "$work/$form" --quick
done
check "the pictures are not all there" test "$(find "$work/colmap/images" -name '*.png' | wc -l)" -eq 40
check "the cloud was not thinned" test "$(grep -vc '^#' "$work/colmap/sparse/0/points3D.txt")" -eq 300
check "the cloud is not named" grep -q '"ply_file_path": "points.ply"' "$work/nerfstudio/transforms.json"
# The same pictures and poses give the same cloud, but for the last digit of the poses.
before=$(head -c 2000 "$cloud" | grep -a '^element vertex' | cut -d' ' -f3)
after=$(head -c 2000 "$work/colmap.ply" | grep -a '^element vertex' | cut -d' ' -f3)
check "$after points of the workspace, $before of its source" test $((after * 10)) -gt $((before * 9))

# The folder of a scan: its own poses, or those of it with the film it was made from.
mkdir "$work/scan"
cp "$cloud" "$work/scan/cloud.ply"
cat >"$work/scan/camera.yaml" <<'END'
%YAML:1.0
image_width: 960
image_height: 720
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 900., 0., 479.5, 0., 900., 359.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 4
   dt: d
   data: [ 0., 0., 0., 0. ]
END
printf '%s 0 0 0 0 0 0 1\n' 0.0 0.0333333 0.0666667 >"$work/scan/poses.txt"
expect 0 "scan.glb" export_ "$work/scan" -o "$work/scan.glb"
expect 0 "3 pictures" export_ "$work/scan" --format nerfstudio --no-pictures -o "$work/scan-poses"
# The middle of the top-left pixel is (0.5, 0.5) there.
check "the principal point is not where nerfstudio has it" grep -q '"cx": 480.0' "$work/scan-poses/transforms.json"
video=$(find "$sample" -name '*.mp4')
expect 0 "3 pictures" export_ "$work/scan" --data "$video" --format colmap -o "$work/scan-film"
check "the film's frames are not there" test -s "$work/scan-film/images/000002.png"

if command -v colmap >/dev/null; then
  export QT_QPA_PLATFORM=offscreen
  expect 0 "Registered images: 40" colmap model_analyzer --path "$work/colmap/sparse/0"
  expect 0 "Points: 300" colmap model_analyzer --path "$work/colmap/sparse/0"
  mkdir "$work/binary"
  check "COLMAP cannot convert the model" colmap model_converter --input_path "$work/colmap/sparse/0" \
    --output_path "$work/binary" --output_type BIN
  check "COLMAP wrote no binary model" test -s "$work/binary/images.bin"
else
  echo "skipped: what COLMAP reads; it is not installed"
fi

# --- Meshes: their form by their name ----------------------------------------------------------------
mesh_() { "$program" mesh "$cloud" --resolution 0.012 "$@"; }
for ending in glb obj ply; do
  expect 0 "mesh.$ending" mesh_ -o "$work/mesh.$ending"
  read -r faces vertices < <(sed -n 's/^\([0-9]*\) faces, \([0-9]*\) vertices from .*/\1 \2/p' "$work/log")
  check "the mesh is empty" test "${faces:-0}" -gt 500
  if command -v assimp >/dev/null; then
    # As they are in the file: without what assimp otherwise does to what it reads.
    expect 0 "Faces:" assimp info "$work/mesh.$ending" -r
    check "assimp does not see $faces faces in mesh.$ending" grep -qE "^Faces: +$faces\$" "$work/log"
    check "assimp does not see triangles alone" grep -qE "^Primitive Types: +triangles\$" "$work/log"
    [[ $ending == obj ]] || check "assimp does not see $vertices vertices" grep -qE "^Vertices: +$vertices\$" "$work/log"
    expect 0 "" assimp export "$work/mesh.$ending" "$work/assimp-$ending.stl" -r
    check "assimp does not write mesh.$ending on" test -s "$work/assimp-$ending.stl"
  else
    echo "skipped: what assimp reads of mesh.$ending; it is not installed (assimp-utils)"
  fi
done
check "the mesh has no material" grep -q newmtl "$work/mesh.mtl"
# GLB gives the mesh back to the last bit, in the world's coordinates.
expect 0 "back.ply" export_ "$work/mesh.glb" -o "$work/back.ply"
check "the mesh does not come back from GLB as it was" cmp "$work/back.ply" "$work/mesh.ply"
for ending in glb ply; do
  expect 0 "mm" "$program" eval "$work/mesh.$ending" "$sample/mesh.ply.gz" --json "$work/eval-$ending.json"
  expect 0 "mesh.png" "$program" render "$work/mesh.$ending" -o "$work/mesh.png" --size 160x120
done
check "a mesh as GLB is not worth the same" cmp "$work/eval-glb.json" "$work/eval-ply.json"
# Told before any work: the cloud is not even looked for.
expect 2 "must end with .glb, .obj or .ply" "$program" mesh "$work/missing.ply" -o "$work/bad.stl"
expect 2 "must end with .glb, .obj or .ply" "$program" mesh "$work/missing.ply" -o "$work/bad"
cp "$cloud" "$work/cloud-named.glb"
expect 3 "exists and is not a GLB file" mesh_ -o "$work/cloud-named.glb"
expect 3 "not a GLB file" "$program" render "$work/cloud-named.glb" -o "$work/bad.png"
expect 0 "draco.glb" export_ "$work/mesh.glb" -o "$work/draco.glb" --draco
expect 3 "Draco" export_ "$work/draco.glb" -o "$work/bad.ply"

# --- Bad input --------------------------------------------------------------------------------------
printf 'ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n' >"$work/empty.ply"
printf 'ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\nnan 0 0\n1 inf 0\n' >"$work/nan.ply"
mkdir "$work/full"
touch "$work/full/something"
expect 3 "holds no point" export_ "$work/empty.ply" -o "$work/bad.glb"
expect 3 "with a finite position" export_ "$work/nan.ply" -o "$work/bad.glb"
expect 3 "missing.ply" export_ "$work/missing.ply" -o "$work/bad.glb"
expect 2 "OBJ carries meshes" export_ "$cloud" -o "$work/bad.obj"
expect 2 "LAS carries points" export_ "$sample/mesh.ply.gz" -o "$work/bad.las"
expect 2 "compresses meshes only" export_ "$cloud" -o "$work/bad.glb" --draco
expect 2 "must end with" export_ "$cloud" -o "$work/bad.stl"
expect 2 "--crs" export_ "$cloud" -o "$work/bad.glb" --crs "$cloud"
expect 3 "no coordinate system" export_ "$cloud" -o "$work/bad.las" --crs "$work/empty.ply"
expect 3 "is an input" export_ "$cloud" -o "$cloud"
expect 3 "does not exist; create it" export_ "$cloud" -o "$work/no/such/bad.glb"
expect 3 "no point has 60000 views" export_ "$cloud" -o "$work/bad.glb" --min-views 60000
expect 3 "name the recording with --data" export_ "$cloud" --format colmap -o "$work/bad"
expect 3 "missing" export_ "$cloud" --data "$work/missing" --format colmap -o "$work/bad"
expect 3 "--no-pictures" export_ "$work/scan" --format colmap -o "$work/bad"
expect 3 "not an empty folder" export_ "$cloud" --data "$sample" --format colmap -o "$work/full"
check "a failed export left something" test -z "$(find "$work" -name 'bad*' -o -name '*.tmp-*')"

printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
