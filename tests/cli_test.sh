#!/usr/bin/env bash
# Usage: tests/cli_test.sh PROGRAM SAMPLE-FOLDER
#
# Runs the program the way people do, on good input and bad, and checks exit codes, messages and files.

set -u
# shellcheck source=support/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/support/expect.sh"

copy_sample() {
  rm -rf "$work/data"
  cp -r "$sample" "$work/data"
}

run() { "$program" run --seeds 4000 -o "$work/out.ply" "$@"; }
in_cloud() { od -An -v -t u1 -w28 -j24 "$1" | awk '$27 == 1' | wc -l; }  # seeds of a trace
vertices() { head -c 2000 "$1" | grep -a '^element vertex' | cut -d' ' -f3; }

# --- Good input -------------------------------------------------------------------------------------
expect 0 "points from 40 frames" run --data "$sample" --last-frame 39 --stats "$work/out.json"
check "no points converged" test "$(vertices "$work/out.ply")" -gt 100
check "statistics were not written" grep -q '"per_second"' "$work/out.json"
expect 0 '"stage":"reconstruct"' run --data "$sample" --last-frame 9 --progress json
expect 0 "livemvs run --data" "$program" run --help
expect 0 "mm" "$program" eval "$work/out.ply" "$sample/mesh.ply.gz" --json "$work/eval.json"
expect 0 "cloud.png" "$program" render "$work/out.ply" -o "$work/cloud.png" --size 320x240
expect 0 "180" "$program" info "$sample" --quick

# Seeds, judged where the scene is hard.
scene=(--scene hazards --frames 30 --arc 25 --size 320x240 --spp 1 --noise 2)
expect 0 "labels" "$program" synth "${scene[@]}" --labels-every 10 -o "$work/hazards" --progress none
expect 0 "scene.trace" run --data "$work/hazards" --trace "$work/scene.trace"
seeds=(--trace "$work/scene.trace" --labels "$work/hazards")
expect 0 "textureless" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" "${seeds[@]}" --json "$work/eval.json"
expect 0 "more than 5 %" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" "${seeds[@]}" --false-beyond 5
check "false convergence is not in the JSON" grep -q '"false_of_planted"' "$work/eval.json"
check "false points are not in the JSON" grep -q '"false_points"' "$work/eval.json"
check "the trace does not say which points are in the cloud" \
  test "$(in_cloud "$work/scene.trace")" = "$(vertices "$work/out.ply")"
expect 2 "--labels" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" --trace "$work/scene.trace"
expect 2 "tolerance" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" "${seeds[@]}" --false-beyond 0
expect 3 "needs a mesh" "$program" eval "$work/out.ply" "$work/out.ply" "${seeds[@]}"
expect 3 "not a seed trace" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" \
  --trace "$work/out.ply" --labels "$work/hazards"
expect 3 "--labels-every" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" \
  --trace "$work/scene.trace" --labels "$sample"
cp "$work/hazards/labels/000000.png" "$work/hazards/labels/000001.png"
head -c 200 "$work/hazards/labels/000000.png" >"$work/hazards/labels/000002.png"
expect 3 "000002.png" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" "${seeds[@]}"
rm "$work"/hazards/labels/*
"$program" render "$work/out.ply" -o "$work/hazards/labels/000000.png" --size 320x240 >/dev/null
expect 3 "000000.png" "$program" eval "$work/out.ply" "$work/hazards/mesh.ply" "${seeds[@]}"
expect 3 "both the cloud and the trace" run --data "$sample" --trace "$work/out.ply"
expect 3 "not a seed trace" run --data "$sample" --trace "$sample/video.mp4"

# A video that breaks off: what is there is reconstructed.
copy_sample
head -c 2000000 "$sample/video.mp4" >"$work/data/video.mp4"
expect 0 "warning" run --data "$work/data"
check "nothing of the cut video was reconstructed" test "$(vertices "$work/out.ply")" -gt 100

# --- Interrupted ------------------------------------------------------------------------------------
rm -f "$work/out.ply"
# At the pace of the film, so that it is under way however fast the machine.
"$program" run --data "$sample" --realtime --seeds 100000 -o "$work/out.ply" >"$work/log" 2>&1 &
pid=$!
sleep 3
interrupt_time=$(date +%s%N)
kill -TERM $pid
wait $pid
status=$?
check "interrupted run ended with $status, not 130" test $status -eq 130
check "interrupted run took over 5 s to end" test $((($(date +%s%N) - interrupt_time) / 1000000)) -lt 5000
check "interrupted run wrote no cloud" test -s "$work/out.ply"

# --- A printed board --------------------------------------------------------------------------------
expect 0 "check the ruler" "$program" board -o "$work/a4.json" --pdf "$work/a4.pdf" --png "$work/a4.png" --plain 4x2
check "the PDF is none" grep -q '^%PDF' "$work/a4.pdf"
expect 2 "does not fit the page" "$program" board -o "$work/a4.json" --pdf "$work/a4.pdf" --square-mm 40
expect 2 "fewer codes" "$program" board -o "$work/a4.json" --squares 40x40 --square-mm 5 --dictionary DICT_4X4_50
expect 2 "COLUMNSxROWS" "$program" board -o "$work/a4.json" --squares twelve
expect 0 "poses.txt" "$program" synth --scene sheet --frames 24 --arc 40 --size 640x480 --spp 2 --no-mesh -o "$work/sheet" \
  --progress none
tracked=(--data "$work/sheet" --board "$work/sheet/board.json")
expect 0 "tracked 24 of 24 frames" "$program" track "${tracked[@]}" -o "$work/poses.txt" --report "$work/frames.csv"
check "no TUM poses" test "$(grep -vc '^#' "$work/poses.txt")" -eq 24
expect 0 "transforms.json" "$program" track "${tracked[@]}" -o "$work/transforms.json"
expect 0 "colmap" "$program" track "${tracked[@]}" -o "$work/colmap" --camera-output "$work/camera.yaml"
check "no COLMAP model" test -s "$work/colmap/images.txt"
expect 0 "24" "$program" info "$work/sheet/video.mp4" --poses "$work/poses.txt" --camera "$work/camera.yaml" --quick
expect 1 "no good calibration" "$program" calibrate "${tracked[@]}" -o "$work/refused.yaml"
check "a refused calibration was written" test ! -e "$work/refused.yaml"
expect 3 "board not seen" "$program" track --data "$sample" --board "$work/a4.json" -o "$work/none.txt"
expect 3 "board not seen" "$program" calibrate --data "$sample" --board "$work/a4.json" -o "$work/none.yaml"
check "poses without a board were written" test ! -e "$work/none.txt"
echo '{"format": "livemvs board", "version": 1}' >"$work/broken.json"
expect 3 "broken.json" "$program" track --data "$work/sheet" --board "$work/broken.json" -o "$work/none.txt"
expect 3 "no such file or folder" "$program" track --data "$work/absent" --board "$work/a4.json" -o "$work/none.txt"

# --- Bad usage --------------------------------------------------------------------------------------
expect 2 "--data" "$program" run -o "$work/out.ply"
expect 2 "preset 'fast' is unknown" run --data "$sample" --preset fast
expect 2 "option eta_inlier" run --data "$sample" --set eta_inlier=2
expect 2 "option 'speed' is unknown" run --data "$sample" --set speed=1

# --- Bad input: the file, the place, the remedy; and what was there stays ----------------------------
printf 'ply\nprecious\n' >"$work/out.ply"
expect 3 "no such file or folder" run --data "$work/absent"
mkdir "$work/empty"
expect 3 "Supported are" run --data "$work/empty"
: >"$work/empty/zero.mp4"
expect 3 "zero.mp4" run --data "$work/empty/zero.mp4" --poses "$sample/poses.txt" --camera 900,900,480,360
echo "this is no video" >"$work/text.mp4"
expect 3 "text.mp4" run --data "$work/text.mp4" --poses "$sample/poses.txt" --camera 900,900,480,360
copy_sample
sed -i '5s/ [^ ]*$/ nan/' "$work/data/poses.txt"
expect 3 "poses.txt:5" run --data "$work/data"
copy_sample
sed -i '5s/^\([^ ]*\) [^ ]*/\1 7.5/' "$work/data/poses.txt"
expect 3 "not a rotation" run --data "$work/data"
copy_sample
for i in 180 181 182; do tail -1 "$sample/poses.txt" | sed "s/^[0-9]*/$i/" >>"$work/data/poses.txt"; done
expect 3 "183" run --data "$work/data"
copy_sample
echo "0 900 480 360 960 720" >"$work/data/intrinsics.txt"
expect 3 "intrinsics.txt" run --data "$work/data"
echo "900 900 480 360 640 480" >"$work/data/intrinsics.txt"
expect 3 "960 x 720" run --data "$work/data"
copy_sample
sed -i -n 's/^[0-9]* //; 2~2p' "$work/data/poses.txt"
expect 3 "poses for 90 frames" run --data "$work/data"
copy_sample
expect 3 "not a point cloud" "$program" run --data "$work/data" -o "$work/data/video.mp4"
check "the input video was replaced" cmp -s "$sample/video.mp4" "$work/data/video.mp4"
expect 3 "both the cloud and the statistics" run --data "$sample" --stats "$work/out.ply"
expect 2 "--near" run --data "$sample" --near -1
mkdir "$work/json"
printf '%10000s' '' | tr ' ' '[' >"$work/json/transforms.json"
expect 3 "transforms.json" run --data "$work/json"
expect 3 "near less than far" run --data "$sample" --near 2 --far 1
expect 3 "the box is empty" run --data "$sample" --box 0 0 0 0 1 1
expect 3 "does not exist" "$program" run --data "$sample" -o "$work/absent/out.ply"
expect 3 "is a directory" "$program" run --data "$sample" -o "$work"
check "an output from before was touched by a run that failed" grep -qx precious "$work/out.ply"

# --- Out of resources -------------------------------------------------------------------------------
if [[ -e /dev/full ]]; then
  expect 4 "disk full" "$program" run --data "$sample" --seeds 1000 --last-frame 20 -o /dev/full
fi

printf '%d passed, %d failed\n' "$passed" "$failed"
((failed == 0))
