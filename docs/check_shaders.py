# SPDX-License-Identifier: MIT
"""Compiles every GLSL and HLSL snippet of shaders.md with glslangValidator."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

PAGE = Path(__file__).with_name("shaders.md")
FRAME = {
    "glsl": ("#version 330 core\nout vec4 color;\n", "\nvoid main() { color = vec4(0.0); }\n"),
    "hlsl": ("", "\nfloat4 main() : SV_Target { return float4(0, 0, 0, 0); }\n"),
}
OPTIONS = {"glsl": [], "hlsl": ["-D", "-V", "-e", "main"]}


def definition_of(name, snippets):
    """The snippet that defines a function, for one that only declares it."""
    return next(s for s in snippets if re.search(rf"\b{name}\([^)]*\)\n{{", s))


def main():
    text = PAGE.read_text(encoding="utf-8")
    failed = 0
    for language, (head, tail) in FRAME.items():
        snippets = re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)
        for snippet in snippets:
            needed = re.findall(r"(\w+)\([^)]*\);\n\n", snippet)
            parts = [definition_of(name, snippets) for name in needed]
            with tempfile.TemporaryDirectory() as folder:
                source = Path(folder) / "snippet.frag"
                source.write_text(head + "".join(parts) + snippet + tail, encoding="utf-8")
                output = [] if language == "glsl" else ["-o", Path(folder) / "out.spv"]
                command = ["glslangValidator", *OPTIONS[language], "-S", "frag", *output, source]
                done = subprocess.run(command, check=False, capture_output=True, text=True)
            if done.returncode != 0:
                failed += 1
                print(f"{language}:\n{snippet}\n{done.stdout}{done.stderr}")
        print(f"{language}: {len(snippets)} snippets")
        if not snippets:
            failed += 1
    sys.exit(failed != 0)


main()
