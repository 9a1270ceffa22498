# SPDX-License-Identifier: MIT
"""Compiles and runs the programs in the pages: check_c.py BUILD

Each ```c block with a main that includes libntp.h, in docs/*.md, is built against BUILD's libntp;
the ```text block after it is what it prints.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = re.compile(r"```c\n(?P<code>(?:(?!```).)*?\bint main\b.*?)```", re.DOTALL)
OUTPUT = re.compile(r"```text\n(.*?)```", re.DOTALL)
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


def main(build):
    wrong = count = 0
    for page in sorted((ROOT / "docs").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        for match in PROGRAM.finditer(text):
            if "libntp.h" not in match["code"]:
                continue
            count += 1
            want = OUTPUT.search(text, match.end())[1]
            with tempfile.TemporaryDirectory() as folder:
                source, program = Path(folder) / "program.c", Path(folder) / "program"
                source.write_text(match["code"], encoding="utf-8")
                library = Path(build) / "libntp"
                command = ["cc", *STRICT, f"-I{ROOT}/libntp/include", source, "-o", program]
                command += [f"-L{library}", "-lntp", f"-Wl,-rpath,{library.resolve()}"]
                subprocess.run(command, check=True)
                got = subprocess.run([program], check=True, capture_output=True, text=True).stdout
            if got != want:
                print(f"{page.name}: the page shows {want!r}, the program prints {got!r}")
                wrong += 1
    print(f"{count} programs in the pages")
    return 1 if wrong or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
