#!/usr/bin/env bash
# The scenes that the rasteriser is timed with, for other renderers: the GLB of each, and beside it its camera and light as
# NAME.view.json (metres, y up; eye, target, up, fovy in degrees, near, far, light_dir from the sun).
#   scenes/bench.sh OUT [leafseason]
set -euo pipefail
out=${1:?folder to write into}
program=${2:-target/release/leafseason}
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$out"
for name in bench-10k bench-100k bench-1m; do
    "$program" render "$here/$name.toml" --out "$out" --force --report "$out/$name.report.json"
    python3 - "$out/$name" <<'PY'
import json, sys
stem = sys.argv[1]
view = json.load(open(stem + ".report.json"))["frames"][0]["view"]
sun = view["sun"]
json.dump({"eye": view["position"], "target": view["target"], "up": [0, 1, 0], "fovy": view["field_of_view"], "near": 0.1,
           "far": 400.0, "light_dir": [-s for s in sun], "light": 2.2, "ambient": 0.5, "background": [0.5, 0.6, 0.7]},
          open(stem + ".view.json", "w"), indent=1)
PY
done
