#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes docs/pictures/*.png and demo.gif again: the window on the built-in synthetic room, on a private X server.
#   scripts/make_pictures.sh [FOLDER]     PLUMBLINE=path/to/plumbline chooses the program
# The first time it films the room (minutes); the room is kept in the user's cache.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${PLUMBLINE:-$root/build/bin/plumbline}
out=$(mkdir -p "${1:-$root/docs/pictures}" && cd "${1:-$root/docs/pictures}" && pwd)

fail() {
  printf 'make_pictures: %s\n' "$*" >&2
  exit 1
}
[ -x "$program" ] || fail "there is no $program; run ./dev build first, or set PLUMBLINE"
for tool in xvfb-run ffmpeg chromium; do
  command -v "$tool" >/dev/null || fail "$tool is missing; on Debian: apt-get install xvfb xauth ffmpeg chromium"
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/script.json" <<'JSON'
{"steps": [
  {"wait_for": {"frame": 118, "seeking": false}, "timeout_s": 1800},
  {"wait_frames": 5},
  {"screenshot": "window.png"},
  {"screenshot": "panel-image.png", "of": "panel.image"},
  {"screenshot": "panel-edges.png", "of": "panel.edges"},
  {"screenshot": "panel-depth.png", "of": "panel.depth"},
  {"screenshot": "panel-masks.png", "of": "panel.masks"},
  {"screenshot": "panel-particles.png", "of": "panel.particles"},
  {"screenshot": "panel-scene.png", "of": "panel.scene"},
  {"screenshot": "panel-objects.png", "of": "panel.objects"},
  {"screenshot": "panel-details.png", "of": "panel.details"},
  {"click": "relations.title"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 30},
  {"screenshot": "panel-relations.png", "of": "panel.relations"},
  {"click": "objects.title"},
  {"screenshot": "panel-timings.png", "of": "panel.timings"},
  {"screenshot": "panel-timeline.png", "of": "panel.timeline"},
  {"click": "why.title"},
  {"wait_for": {"probe_frame": 118}},
  {"click": "objects.row.6"},
  {"wait_frames": 60},
  {"screenshot": "why.png"},
  {"screenshot": "panel-why.png", "of": "panel.why"},
  {"click": "posterior.title"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 5},
  {"screenshot": "panel-posterior.png", "of": "panel.posterior"},
  {"click": "posterior.shapes"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 5},
  {"screenshot": "panel-shapes.png", "of": "panel.posterior"},
  {"click": "posterior.reliability"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 5},
  {"screenshot": "panel-reliability.png", "of": "panel.posterior"},
  {"click": "posterior.reliability"},
  {"click": "particle_table.title"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 5},
  {"screenshot": "panel-particle_table.png", "of": "panel.particle_table"},
  {"click": "details.title"},
  {"click": "edges.beside"},
  {"click": "image.scores"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 60},
  {"screenshot": "panel-edges-beside.png", "of": "panel.edges"},
  {"screenshot": "panel-scores.png", "of": "panel.image"},
  {"click": "image.scores"},
  {"click": "top.networks"},
  {"wait_for": {"networks_sheet": true}},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 10},
  {"screenshot": "networks.png", "of": "networks.sheet"},
  {"key": "escape"},
  {"wait_for": {"networks_sheet": false}},
  {"key": "f1"},
  {"wait_for": {"help": true}},
  {"wait_frames": 3},
  {"screenshot": "help.png"}
]}
JSON
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui demo: --frame 118 --out demo.plb --size 1600x1000 --ui-scale 1 --script script.json)
# Annotating the same room, whose floor nobody knows yet, for docs/annotate_guide.md.
room=$(ls -d "${XDG_CACHE_HOME:-$HOME/.cache}"/plumbline/demo-room-*/ | tail -n 1)
mkdir "$work/room"
cp "$room/scene.ply" "$work/room"
for part in camera.json trajectory.txt color depth edges models; do
  ln -s "$room/$part" "$work/room/$part"
done
cat >"$work/annotate.json" <<'JSON'
{"steps": [
  {"wait_for": {"annotate.aligns": true, "annotate.models": 17, "annotate.busy": ""}, "timeout_s": 120},
  {"click": "floor.pick"},
  {"wait_for": {"annotate.tool": "floor"}},
  {"click": "annotate.view", "at": [0.42, 0.62]},
  {"wait_for": {"annotate.proposal": "floor", "annotate.running": false}, "timeout_s": 60},
  {"hover": "panel.annotate_floor", "at": [0.5, 0.9]},
  {"wait_frames": 10},
  {"screenshot": "annotate-floor.png"},
  {"key": "enter"},
  {"wait_for": {"annotate.floor_known": true}},
  {"key": "5"},
  {"wait_frames": 5},
  {"click": "annotate_models.chair_slat"},
  {"wait_for": {"annotate.tool": "place"}},
  {"click": "annotate.view", "at": [0.427, 0.516]},
  {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}, "timeout_s": 60},
  {"hover": "panel.annotate_candidates", "at": [0.5, 0.98]},
  {"wait_frames": 10},
  {"screenshot": "annotate-place.png"},
  {"key": "enter"},
  {"wait_for": {"annotate.instances": 1}},
  {"click": "annotate_models.table_rectangular"},
  {"wait_for": {"annotate.tool": "place"}},
  {"click": "annotate.view", "at": [0.5, 0.531]},
  {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}, "timeout_s": 60},
  {"key": "enter"},
  {"wait_for": {"annotate.instances": 2}},
  {"click": "annotate_models.chair_slat_arms"},
  {"click": "annotate.view", "at": [0.498, 0.413]},
  {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}, "timeout_s": 60},
  {"key": "enter"},
  {"wait_for": {"annotate.instances": 3}},
  {"click": "annotate_models.chair_shell"},
  {"click": "annotate.view", "at": [0.6186, 0.5503]},
  {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}, "timeout_s": 60},
  {"key": "enter"},
  {"wait_for": {"annotate.instances": 4}},
  {"key": "escape"},
  {"click": "annotate_instances.row.chair_slat_0"},
  {"wait_for": {"annotate.images": {"min": 1}}, "timeout_s": 60},
  {"wait_for": {"annotate.busy": ""}},
  {"click": "images.1"},
  {"wait_frames": 5},
  {"key": "d", "shift": true},
  {"wait_for": {"annotate.undo": "Move chair_slat_0", "annotate.agreement_percent": {"max": 60}}},
  {"click": "instance.refine"},
  {"wait_for": {"annotate.proposal": "refinement", "annotate.running": false}, "timeout_s": 60},
  {"wait_for": {"annotate.agreement_percent": {"min": 60}}},
  {"hover": "panel.annotate_refinement", "at": [0.5, 0.9]},
  {"wait_frames": 10},
  {"screenshot": "annotate-refine.png"},
  {"key": "enter"},
  {"wait_for": {"annotate.proposal": ""}},
  {"wait_frames": 5},
  {"hover": "panel.annotate_instance", "at": [0.5, 0.95]},
  {"wait_frames": 10},
  {"screenshot": "annotate.png"},
  {"screenshot": "annotate-images.png", "of": "panel.annotate_images"},
  {"key": "e", "shift": true},
  {"wait_for": {"annotate.findings": {"min": 1}}},
  {"click": "annotate_instances.check"},
  {"wait_frames": 3},
  {"click": "finding.0"},
  {"wait_frames": 5},
  {"hover": "panel.annotate_instance", "at": [0.5, 0.95]},
  {"wait_frames": 10},
  {"screenshot": "annotate-check.png"},
  {"click": "annotate_instances.check"},
  {"click": "project.undo"},
  {"wait_for": {"annotate.findings": 0}},
  {"click": "annotate.tool.sequence"},
  {"wait_for": {"annotate.frame": {"min": 0}}},
  {"key": "r"},
  {"key": "5"},
  {"wait_frames": 5},
  {"click": "annotate.view", "at": [0.555, 0.497]},
  {"wait_frames": 5},
  {"click": "frame.view", "at": [0.307, 0.43]},
  {"wait_for": {"annotate.pairs": 1}},
  {"wait_frames": 5},
  {"hover": "panel.annotate_sequence", "at": [0.5, 0.9]},
  {"wait_frames": 10},
  {"screenshot": "annotate-sequence.png"},
  {"click": "annotate.tool.select"},
  {"click": "project.export"},
  {"wait_frames": 3},
  {"click": "export.bop"},
  {"hover": "export.close", "at": [3, 0.5]},
  {"wait_frames": 10},
  {"screenshot": "annotate-export.png"},
  {"key": "escape"},
  {"click": "annotate.tool.cut"},
  {"wait_frames": 5},
  {"click": "annotate.view", "at": [0.6186, 0.5503]},
  {"wait_for": {"annotate.box": true}},
  {"drag": "annotate.view", "from": [0.3, 0.3], "to": [0.36, 0.12]},
  {"wheel": "annotate.view", "at": [0.62, 0.52], "amount": 4},
  {"hover": "panel.annotate_crop", "at": [0.5, 0.9]},
  {"wait_frames": 10},
  {"screenshot": "annotate-cut.png"}
]}
JSON
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui room/scene.ply --size 1600x1000 --ui-scale 1 --script annotate.json)
# The page that shows a run in any browser.
"$program" report --interactive "$work/demo.plb" --out "$work/page.html"
chromium --headless=new --no-sandbox --hide-scrollbars --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=1400,860 \
  --virtual-time-budget=6000 --user-data-dir="$work/browser" --screenshot="$work/run-page.png" "file://$work/page.html#frame=90&object=6&theme=light&boxes" 2>/dev/null
# What if the edges counted for less from frame 30 on?
cat >"$work/what-if.json" <<'JSON'
{"steps": [
  {"wait_for": {"frame": 30}},
  {"click": "what_if.title"},
  {"wait_frames": 3},
  {"click": "what_if.fork"},
  {"wait_for": {"fork_sheet": true}},
  {"click": "fork.option.beta"},
  {"key": "a", "control": true}, {"text": "1"}, {"key": "enter"},
  {"hover": "fork.option.beta", "at": [0.5, 1.2]},
  {"wait_frames": 5},
  {"screenshot": "fork.png"},
  {"click": "fork.start"},
  {"wait_for": {"fork": "done", "other_frame": 30}, "timeout_s": 600},
  {"key": "g"}, {"wait_frames": 3}, {"text": "118"}, {"key": "enter"},
  {"wait_for": {"frame": 118, "other_frame": 118}},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 60},
  {"screenshot": "what-if.png"},
  {"click": "what_if.close"},
  {"key": "f5"},
  {"wait_for": {"presenting": true, "shot": 5}, "timeout_s": 90},
  {"wait_frames": 20},
  {"screenshot": "demo-mode.png"},
  {"key": "space"},
  {"wait_for": {"presenting": false}}
]}
JSON
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui demo.plb --frame 30 --size 1600x1000 --ui-scale 1 --script what-if.json)
# The same room with an IMU, mapped from its own poses.
cat >"$work/missed.json" <<'JSON'
{"steps": [
  {"wait_for": {"frame": 40, "seeking": false, "missed": {"min": 1}}, "timeout_s": 600},
  {"click": "objects.missed"},
  {"click": "objects.truth.chair_2", "at": [0.3, 0.5]},
  {"click": "image.truth"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_for": {"probe_frame": 40}},
  {"wait_frames": 40},
  {"screenshot": "why-missed.png"}
]}
JSON
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui demo: --frame 40 --size 1600x1000 --ui-scale 1 --script missed.json)
"$program" synth --out "$work/walk" --scene room --seed 1 --imu --rest 2 --size 640x480 --rate 15 --frames 180 --light-rays 16
"$program" run "$work/walk" --poses vio --edges gradient --out "$work/walk.plb"
cat >"$work/inertial.json" <<'JSON'
{"steps": [
  {"wait_for": {"frame": 150, "seeking": false}, "timeout_s": 300},
  {"click": "inertial.title"},
  {"click": "inertial.over_time"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  {"wait_frames": 20},
  {"screenshot": "panel-inertial.png", "of": "panel.inertial"},
  {"screenshot": "panel-tracks.png", "of": "panel.image"}
]}
JSON
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui walk.plb --frame 150 --size 1600x1000 --ui-scale 1 --script inertial.json)
# A graph of processes with the window attached, whose nodes are killed one after another: a film and the panel.
"$program" up paper "$room" --models "$room/models" --edges gradient --out "$work/graph.plb" --folder "$work/graph" &
graph=$!
until [ -e "$work/graph/graph.json" ]; do sleep 0.1; done
steps=''
for i in $(seq 10 39); do
  steps+="{\"wait_frames\": 12}, {\"screenshot\": \"film-$i.png\"},"
  [ "$i" -ne 26 ] || steps+='{"screenshot": "panel-processes.png", "of": "panel.processes"},'
done
cat >"$work/attached.json" <<JSON
{"steps": [
  {"wait_for": {"nodes_answer": 5, "newest_frame": {"min": 5}}, "timeout_s": 600},
  {"click": "processes.title"},
  {"hover": "panel.image", "at": [0.02, 0.99]},
  $steps
  {"wait_for": {"growing": false}, "timeout_s": 600}
]}
JSON
(for kill in 14:detector 19:mapper 24:player 29:recorder 34:edges; do
  until [ -e "$work/film-${kill%:*}.png" ]; do sleep 0.1; done
  pkill -KILL -f "node ${kill#*:} --graph $work/graph"
done) &
killer=$!
(cd "$work" && xvfb-run -a -s "-screen 0 1600x1000x24" \
  "$program" gui --attach graph --size 1600x1000 --ui-scale 1 --script attached.json)
kill "$killer" 2>/dev/null || true
kill -INT "$graph" || true
wait "$graph" || true
ffmpeg -v error -y -framerate 3 -start_number 10 -i "$work/film-%d.png" -vf "scale=800:-1:flags=lanczos,split[a][b];\
[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=5:diff_mode=rectangle" "$out/attached.gif"
rm "$work"/film-*.png
# A street: what the paper shows in its figure 3, on one of ours.
"$program" synth --out "$work/street" --scene street --seed 303
"$program" run "$work/street" --models "$work/street/right/models" --edges dataset --frames 0:46 --out "$work/street.plb"
"$program" render "$work/street.plb" --models "$work/street/right/models" --layout insets --frames 45:46 --size 1400x480 --out "$work/street_frame"
mv "$work/street_frame/000045.png" "$work/street.png"
# The film: every fourth frame of the run that the window left, made small.
"$program" render "$work/demo.plb" --layout column --frames 0:120:4 --rate 8 --size 800x480 --ui-scale 0.7 --out "$work/large.gif"
ffmpeg -v error -y -i "$work/large.gif" -vf "scale=640:-1:flags=lanczos,split[a][b];\
[a]palettegen=max_colors=96:stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=5:diff_mode=rectangle" "$out/demo.gif"
# 256 colours: a quarter of the size, and nobody sees it.
for picture in "$work"/*.png; do
  name=$(basename "$picture")
  ffmpeg -v error -y -i "$picture" \
    -vf "split[a][b];[a]palettegen=max_colors=256:stats_mode=full[p];[b][p]paletteuse=dither=sierra2_4a" \
    "$work/small.png"
  mv "$work/small.png" "$out/$name"
  size=$(stat -c %s "$out/$name")
  [ "$size" -le 600000 ] || fail "$out/$name has $size bytes, more than a repository should carry"
  printf 'wrote %s (%d kB)\n' "$out/$name" $((size / 1000))
done
