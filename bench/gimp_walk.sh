#!/bin/sh
# SPDX-License-Identifier: MIT
# gimp_walk.sh HEIGHTS DETAILS DIRECTORY: GIMP 3 by hand, without a manual: from the height of a photo
# to normals, to the dialog that blends the details of another texture, and checked and lit.  Makes a
# picture of each step (1-heights.png ...).
#
# It types and clicks on the display of DISPLAY, as from `xvfb-run`, which needs a window manager
# (openbox), xdotool, wmctrl and ImageMagick.  START is the command that starts GIMP with two files.
set -eu
heights=$1 details=$2 out=$3
start=${START:-gimp-3.0 -n -s}
mkdir -p "$out"

await() { # TITLE: until there is such a window
    for _ in $(seq 240); do
        wmctrl -l | grep -qE "$1" && break
        sleep 0.5
    done
    wmctrl -l | grep -qE "$1" || {
        echo "no window $1" >&2
        exit 1
    }
    sleep "${PAUSE:-3}"
}

picture() { # NAME [TITLE]: of all windows, or of one; without the pointer, which shows tips
    xdotool mousemove 1910 1190
    sleep "${PAUSE:-3}"
    if [ $# -gt 1 ]; then
        import -window "$(xdotool search --name "$2" | tail -n 1)" "$out/$1.png"
    else
        import -window root "$out/$1.png"
    fi
}

search() { # WORDS: GIMP's own search for a command, by the key /
    wmctrl -a 'GIMP'
    xdotool key slash
    sleep "${PAUSE:-3}"
    xdotool type "$1"
    sleep "${PAUSE:-3}"
    xdotool key Return
}

# shellcheck disable=SC2086 # START is a command with arguments
$start "$details" "$heights" >"$out/gimp.log" 2>&1 &
gimp=$!
trap 'kill $gimp 2>/dev/null || true' EXIT
trap 'exit 1' INT TERM
await 'GIMP$'
sleep "${PAUSE:-3}"
wmctrl -r 'GIMP' -e 0,0,0,1300,900
sleep 1
picture 1-heights

search 'normals from another'
await 'Normals from Another Layer'
picture 2-normals 'Normals from Another Layer'
xdotool key Return
sleep "${PAUSE:-3}"

search 'blend normals'
await 'Blend Normals'
picture 3-blend
xdotool key Escape # Aux Input, the layer with the details, is for a hand to choose
sleep "${PAUSE:-3}"

search 'check normals'
await 'Is this map right'
sleep "${PAUSE:-3}"
picture 4-check 'Is this map right'
xdotool key alt+l # Clean, if there is something to clean
sleep "${PAUSE:-3}"
picture 5-right 'Is this map right'
xdotool key Escape
picture 6-done
