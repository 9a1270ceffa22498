#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The bytes that a build makes of test_files, outputs and reports: outputs.sh 'COMMAND OF NTP' DIR
# prints a checksum of each.
set -euo pipefail
cd "$(dirname "$0")/../.."
read -ra ntp <<<"$1" # what runs programs of another processor may come first
mkdir -p "$2"
dir=$(cd "$2" && pwd)
rm -rf "${dir:?}"/*
while read -r verb options; do
    mkdir -p "$dir/$verb"
    # shellcheck disable=SC2086
    (cd test_files && "${ntp[@]}" "$verb" -r -q . -o "$dir/$verb" $options) >"$dir/$verb.txt" 2>&1 </dev/null || true
done <<'END'
clean
convert
heatmap
from-height --scale 9.7 --kernel sobel5 --border-y mirror --force
to-height --kernel sobel3 --border clamp --y up
resize --size 61%
transform --strength 1.7 --rotate 90 --y up
END
(cd test_files && "${ntp[@]}" check -r . --format json) >"$dir/check.json" 2>/dev/null || true
sed -i "s|$dir||g" "$dir"/*.txt
# It names the image libraries; those of two builds differ.
sed -i 's/"codecs": "[^"]*"//' "$dir/check.json"
(cd "$dir" && find . -type f | sort | xargs -d '\n' sha256sum)
