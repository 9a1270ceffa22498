# SPDX-License-Identifier: MIT
# ./dev format and ./dev lint.

c_files() { git ls-files '*.c' '*.cc' '*.h'; }

format() {
    need_venv
    if [ "${1:-}" = --check ]; then
        c_files | xargs clang-format --dry-run -Werror
        ruff format --check .
    else
        c_files | xargs clang-format -i
        ruff format .
    fi
}

lint_cppcheck() {
    # Suppressed: cppcheck does not see that loops fill these variables.
    cppcheck --quiet --std=c11 --enable=warning,performance,portability --inline-suppr \
        --suppress=missingIncludeSystem --suppress=uninitvar:libntp/src/base/bignum.c \
        --suppress=legacyUninitvar:io/png_write.c \
        --suppress=uninitvar:libntp/src/base/rgb_avx2.c --suppress=uninitvar:libntp/src/texel/packed_avx2_tmpl.h \
        --suppress=uninitvar:libntp/src/measure/dense_row_avx2.c --suppress=uninitvar:libntp/src/to_height/evidence.c \
        --suppress=uninitvar:libntp/src/detect/find_kernel.c --suppress=uninitvar:libntp/src/texel/turn_avx512_tmpl.h --suppress=uninitvar:bench/bench_to_height.c --error-exitcode=1 -j "$jobs" \
        -I. -Ilibntp/include -Ilibntp/src -Iio -Icli -Igimp-plugin/plug-in '-DG_DEFINE_TYPE(A,B,C)=' \
        -DNTP_BUILDING -DNTP_ISA=base '-DNTP_ISA_NAME="base"' \
        '-Djson_array_foreach(a,i,v)=while((v=json_array_get(a,(i=0)))!=NULL)' \
        '-Djson_object_foreach(o,k,v)=while((v=json_object_get(o,(k="")))!=NULL)' \
        libntp os io cli gimp-plugin examples bench
}

lint_tidy() {
    mkdir -p build/tidy
    # The build is of gcc, whose options to optimize are not all clang's.
    python - <<'END' >build/tidy-files
import json, os, re
top = os.getcwd()
entries = json.load(open("build/compile_commands.json"))
names = {os.path.realpath(os.path.join(e["directory"], e["file"])) for e in entries}
for e in entries:
    e["command"] = re.sub(r"'-mtune-ctrl=[^']*'|-fvect-cost-model=very-cheap|-fira-region=all|-fno-(move-loop-invariants|split-loops|thread-jumps)\b", "", e["command"])
json.dump(entries, open("build/tidy/compile_commands.json", "w"))
names = {os.path.relpath(n, top) for n in names}
print("\n".join(sorted(n for n in names if n.endswith(".c") and n.split("/")[0] in ("libntp", "os", "io", "cli", "gimp-plugin", "tests"))))
END
    xargs -n 1 -P "$jobs" clang-tidy --quiet -p build/tidy --warnings-as-errors='*' \
        --extra-arg=-Wno-unused-command-line-argument \
        --extra-arg=-Wno-ignored-optimization-argument <build/tidy-files
}

lint_python() { ruff check . && ruff format --check .; }

# The interface is one header, and GEGL wants the properties of an operation beside its code.
lint_lengths() {
    git ls-files '*.c' '*.h' '*.py' |
        grep -v -e '^libntp/include/libntp.h$' -e '^gimp-plugin/gegl/normals_from_height.c$' |
        xargs awk 'FNR == 501 { print FILENAME ": more than 500 lines"; bad = 1 } END { exit bad }'
}

lint_spelling() {
    codespell --skip '*.png,*.tga,*.jpg,*.pfm' --ignore-words-list 'ue,fo,ba,nd,paeth,chekc,autor,aci,absolut' $(git ls-files '*.md' '*.c' '*.cc' '*.h' '*.py' '*.txt' '*.sh' dev)
}

lint() {
    need_tools
    need_test_tools # what the parts for GIMP are built with: what is not built is not looked at
    need_lint_tools
    build_main
    stage cppcheck lint_cppcheck
    stage clang-tidy lint_tidy
    stage rooms python tools/rooms.py build
    stage "lengths of files" lint_lengths
    stage ruff lint_python
    stage clang-format format --check
    stage codespell lint_spelling
    stage "shader snippets" python docs/check_shaders.py
    stage "outputs in the pages" python docs/console.py --check build/cli/ntp
    finish_stages
}
