# SPDX-License-Identifier: MIT
"""GIMP in a window of its own on a display of its own, driven by keys and clicks.

It needs Debian's xvfb, openbox, wmctrl, xdotool, x11-utils and imagemagick.  GIMP 3 is that of the
chroot of ./dev gimp3, GIMP 2.10 that of the system with what the build directory has.
"""

import gettext
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from support.gimp2 import gegl_modules

LOCALES = {"en": "en_US.UTF-8", "de": "de_DE.UTF-8"}
GIMPRC = '(color-profile-policy keep)\n(save-session-info no)\n(language "{language}")\n'
GIMPRC3 = "(show-welcome-dialog no)\n(check-updates no)\n"
NO_BLINK = "[Settings]\ngtk-cursor-blink=0\n"  # a picture is to come to rest
PATIENCE = 240  # seconds


def stones(side=512):
    """Heights of a wall of stones, as a photo gives them; it tiles."""
    rng = np.random.default_rng(3)
    g = 8
    cells = [(i, j) for i in range(g) for j in range(g)]
    jitter = rng.uniform(0.18, 0.82, (len(cells), 2))
    middles = (np.array([(i, j + i % 2 / 2) for i, j in cells]) + jitter) / g % 1
    y, x = np.mgrid[:side, :side] / side
    near = np.full((2, side, side), 9.0)
    which = np.zeros((side, side), int)
    for k, (px, py) in enumerate(middles):
        dx, dy = np.abs(x - px), np.abs(y - py)
        r = np.hypot(np.minimum(dx, 1 - dx), np.minimum(dy, 1 - dy))
        first = r < near[0]
        near[1] = np.where(first, near[0], np.minimum(near[1], r))
        which = np.where(first, k, which)
        near[0] = np.where(first, r, near[0])
    edge = ((near[1] - near[0]) * 512 / 14).clip(0, 1)
    tilt = rng.uniform(-1, 1, (len(cells), 2))[which]
    dx, dy = (x - middles[which, 0] + 0.5) % 1 - 0.5, (y - middles[which, 1] + 0.5) % 1 - 0.5
    high = 0.75 + 0.12 * rng.uniform(-1, 1, len(cells))[which]
    h = (1 - (1 - edge) ** 2) * (high + 0.8 * (dx * tilt[..., 0] + dy * tilt[..., 1]))
    waves = np.fft.fftfreq(side)
    soft = np.exp(-(waves[:, None] ** 2 + waves**2) * 900)
    noise = np.fft.ifft2(np.fft.fft2(rng.normal(size=(side, side))) * soft).real
    h += 0.02 * noise / noise.std() * edge
    return np.round((h - h.min()) / np.ptp(h) * 255).astype(np.uint8)


class Screen:
    """A display without hardware, with a window manager."""

    def __init__(self, number, width=1920, height=1080, dpi=96):
        self.name, self.width, self.height = f":{number}", width, height
        self.environment = {**os.environ, "DISPLAY": self.name}
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        server = ["Xvfb", self.name, "-screen", "0", f"{width}x{height}x24", "-dpi", str(dpi)]
        self.memory = tempfile.TemporaryDirectory()
        server += ["-fbdir", self.memory.name, "-nolisten", "tcp"]
        self.processes = [subprocess.Popen(server, **quiet)]
        self.wait(lambda: self.ask("xprop", "-root") != "", "a display")
        shown = np.memmap(Path(self.memory.name) / "Xvfb_screen0", np.uint8, "r")
        head = np.frombuffer(shown[:100].tobytes(), ">u4")
        begin, stride = int(head[0] + 12 * head[19]), int(head[12])
        self.pixels = shown[begin : begin + height * stride].reshape(height, stride // 4, 4)
        resource = f"Xft.dpi: {dpi}\n"
        self.ask(
            "xprop", "-root", "-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER", resource
        )
        self.processes.append(subprocess.Popen(["openbox"], env=self.environment, **quiet))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            process.terminate()
            process.wait()
        self.memory.cleanup()

    def ask(self, *words):
        done = subprocess.run(words, env=self.environment, capture_output=True, check=False)
        return done.stdout.decode(errors="replace")

    def wait(self, condition, what, patience=PATIENCE):
        end = time.monotonic() + patience
        while time.monotonic() < end:
            found = condition()
            if found:
                return found
            time.sleep(0.1)
        raise TimeoutError(f"no {what}")

    def windows(self):
        """{title: (id, x, y, width, height)}, the newest last."""
        found = {}
        for line in self.ask("wmctrl", "-lG").splitlines():
            words = line.split(None, 7)
            if len(words) == 8:
                found[words[7]] = (words[0], *map(int, words[2:6]))
        return found

    def window(self, pattern, patience=PATIENCE):
        """(id, x, y, width, height) of the window whose title matches, as soon as it is there."""

        def look():
            return next((w for t, w in self.windows().items() if re.search(pattern, t)), None)

        return self.wait(look, f"window {pattern}", patience)

    def gone(self, pattern, patience=PATIENCE):
        self.wait(
            lambda: not any(re.search(pattern, t) for t in self.windows()),
            f"end of window {pattern}",
            patience,
        )

    def box(self, window):
        """(x, y, width, height) of a window, without its frame."""
        text = self.ask("xwininfo", "-id", window)
        names = ("Absolute upper-left X", "Absolute upper-left Y", "Width", "Height")
        return tuple(int(re.search(rf"{name}:\s+(-?\d+)", text)[1]) for name in names)

    def grab(self, window="root"):
        """The pixels that are shown, read from the memory of the display."""
        x, y, width, height = (0, 0, self.width, self.height)
        if window != "root":
            x, y, width, height = self.box(window)
        x, y = max(x, 0), max(y, 0)
        return self.pixels[y : y + height, x : x + width, 2::-1].copy()

    def settle(self, window="root", still=0.8, patience=20):
        """The picture, as soon as it has stopped to change."""
        end, last, since = time.monotonic() + patience, None, time.monotonic()
        while time.monotonic() < end:
            now = self.grab(window)
            if last is None or now.shape != last.shape or (now != last).any():
                last, since = now, time.monotonic()
            elif time.monotonic() - since >= still:
                break
            time.sleep(0.15)
        return last

    def park(self):
        """Moves the pointer where it points at nothing, so that no tip is shown."""
        self.ask("xdotool", "mousemove", str(self.width - 2), str(self.height - 2))

    def picture(self, file, window="root"):
        self.park()
        shown = self.settle(window)
        Image.fromarray(shown).save(file, optimize=True)
        return shown.shape[1], shown.shape[0]

    def key(self, *names):
        self.ask("xdotool", "key", *names)

    def type(self, text):
        self.ask("xdotool", "type", "--delay", "40", text)

    def click(self, x, y):
        self.ask("xdotool", "mousemove", str(int(x)), str(int(y)), "click", "1")

    def front(self, window):
        """Keys go there from now on."""
        self.ask("wmctrl", "-i", "-a", window)

        def is_active():
            active = self.ask("xdotool", "getactivewindow").strip()
            return active.isdigit() and int(active) == int(window, 16)

        self.wait(is_active, f"focus of {window}", 20)

    def place(self, window, x, y, width=-1, height=-1):
        self.ask("wmctrl", "-i", "-r", window, "-e", f"0,{x},{y},{width},{height}")

    def search(self, image_window, text, below=0):
        """GIMP's own search for a command, by the key /; takes the first or one below."""
        self.front(image_window)
        before = set(self.windows())
        self.key("slash")
        opened = self.wait(lambda: set(self.windows()) - before, "window to search in", 20)
        self.settle(still=0.3)
        self.type(text)
        self.settle(still=0.8)
        self.key(*["Down"] * below, "Return")
        self.gone("|".join(f"^{re.escape(title)}$" for title in opened), 20)


class Gimp:
    """A GIMP that runs a script and then stays open."""

    version = None
    process = None

    def __init__(self, screen, work, language="en", scale=1):
        self.screen, self.work, self.language, self.scale = screen, Path(work), language, scale
        shutil.rmtree(self.work, ignore_errors=True)
        (self.work / "profile").mkdir(parents=True)

    def text(self, message, domain="libntp"):
        """A text of ours in the language of this GIMP."""
        folder = Path(os.environ.get("NTP_BUILD", ROOT / "build")) / "gimp-plugin" / "po"
        return gettext.translation(domain, folder, [self.language], fallback=True).gettext(message)

    def start(self, command, environment):
        with open(self.work / "log", "w") as log:
            self.process = subprocess.Popen(
                command, env=environment, cwd=self.work, stdout=log, stderr=log
            )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process is not None:
            self.process.terminate()
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:  # GIMP 3 now and then does not end when told to
                self.process.kill()
                self.process.wait()

    def image_window(self):
        return self.screen.window(r"[– -] GIMP$")


class Gimp2(Gimp):
    version = 2

    def __init__(self, screen, work, language="en", scale=1):
        super().__init__(screen, work, language, scale)
        build = Path(os.environ.get("NTP_BUILD", ROOT / "build")) / "gimp-plugin"
        place = self.work / "profile" / "plug-ins" / "ntp-normals"
        place.mkdir(parents=True)
        shutil.copy(build / "plug-in" / "gimp2" / "ntp-normals", place)
        shutil.copytree(
            build / "po", place / "locale", ignore=shutil.ignore_patterns("*-gegl.mo", "*.p")
        )
        (self.work / "profile" / "gimprc").write_text(GIMPRC.format(language=language))
        (self.work / "gtkrc").write_text("gtk-cursor-blink = 0\n")
        modules = gegl_modules(self.work / "gegl")
        (modules / "ntp-gegl.so").symlink_to((build / "gegl" / "ntp-gegl.so").resolve())
        locales = self.work / "locale"
        locales.mkdir()
        territory = LOCALES[language].split(".")[0]
        words = ["localedef", "-i", territory, "-f", "UTF-8", locales / LOCALES[language]]
        subprocess.run(words, check=True)

    def run(self, script):
        """Script-Fu; files are in self.work."""
        environment = {
            **self.screen.environment,
            "GIMP2_DIRECTORY": str(self.work / "profile"),
            "HOME": str(self.work),
            "LOCPATH": str(self.work / "locale"),
            "LC_ALL": LOCALES[self.language],
            "LANGUAGE": self.language,
            "GTK2_RC_FILES": str(self.work / "gtkrc"),
            "GEGL_PATH": str(self.work / "gegl"),
            "GEGL_USE_OPENCL": "no",
            "BABL_INHIBIT_CACHE": "1",
        }
        self.start(["gimp-2.10", "-n", "-s", "-d", "-f", "-b", script], environment)


class Gimp3(Gimp):
    version = 3

    def __init__(self, screen, chroot, language="en", scale=1):
        self.chroot = Path(chroot)
        self.inside = f"/home/window{screen.name[1:]}"
        super().__init__(screen, self.chroot / self.inside[1:], language, scale)
        (self.work / ".config" / "gtk-3.0").mkdir(parents=True)
        (self.work / ".config" / "gtk-3.0" / "settings.ini").write_text(NO_BLINK)
        words = ["chroot", self.chroot, "gimp-console-3.0", "--version"]
        said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
        known = f'(config-version "{said.split()[-1]}")\n'  # else GIMP welcomes its user
        (self.work / "profile" / "gimprc").write_text(
            GIMPRC.format(language=language) + GIMPRC3 + known
        )

    def run(self, script):
        """Python; the work directory is HERE."""
        head = f"from gi.repository import Gio\nHERE = '{self.inside}'\n"
        (self.work / "script.py").write_text(head + script)
        variables = {
            "PATH": "/usr/bin:/bin",
            "HOME": self.inside,
            "DISPLAY": self.screen.name,
            "GIMP3_DIRECTORY": f"{self.inside}/profile",
            "LC_ALL": LOCALES[self.language],
            "LANGUAGE": self.language,
            "GDK_SCALE": str(self.scale),
            "GEGL_USE_OPENCL": "no",
        }
        command = ["chroot", self.chroot, "env", "-i"] + [f"{k}={v}" for k, v in variables.items()]
        command += ["gimp-3.0", "-n", "-s", "--batch-interpreter=python-fu-eval"]
        command += ["-b", f"exec(open('{self.inside}/script.py').read())"]
        self.start(command, None)
