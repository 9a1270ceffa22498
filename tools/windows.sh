# SPDX-License-Identifier: MIT
# ./dev windows: libntp and ntp.exe for Windows by mingw-w64, and their tests under wine.

need_windows_tools() {
    want gcc-mingw-w64-x86-64 has x86_64-w64-mingw32-gcc
    want wine has wine
    install_missing
}

windows_build() {
    if [ ! -f build-windows/build.ninja ]; then
        quietly "$windows_work/setup.log" meson setup build-windows --wrap-mode=nodownload \
            --cross-file packaging/cross/x86_64-w64-mingw32.ini -Dgegl=disabled -Dgimp=disabled \
            -Ddebug=false -Doptimization=2 -Dtests=false
    fi
    quietly "$windows_work/ninja.log" ninja -C build-windows -j "$jobs"
}

windows_installed() { # a folder as a user has it: the program needs no DLL but those of Windows
    rm -rf "$windows_work/installed"
    DESTDIR=$windows_work/installed meson install -C build-windows --no-rebuild --quiet
    windows_prefix=$(dirname "$(find "$windows_work/installed" -type d -name bin)")
    for windows_file in bin/ntp.exe bin/libntp-1.dll lib/libntp.dll.a lib/pkgconfig/libntp.pc include/libntp.h; do
        [ -f "$windows_prefix/$windows_file" ] || { say "missing: $windows_file"; return 1; }
    done
    if x86_64-w64-mingw32-objdump -p "$windows_prefix/bin/ntp.exe" | grep 'DLL Name' |
        grep -viE 'kernel32|advapi32|shell32|user32|msvcrt|api-ms-win'; then
        say "ntp.exe needs more than Windows has"
        return 1
    fi
}

windows_tests() {
    NTP_EXE=$top/build-windows/cli/ntp.exe NTP_BUILD=$top/build \
        python -m pytest -q -rs -p no:cacheprovider -c /dev/null --rootdir="$top" tests/windows/ntp_exe.py "$@"
}

windows() { # windows [ARG...]: the arguments are pytest's
    need_tools
    need_windows_tools
    windows_work=$top/build-windows-work
    mkdir -p "$windows_work"
    export WINEPREFIX="$windows_work/wine" WINEDEBUG=-all WINEDLLOVERRIDES=mscoree,mshtml=
    build_main
    stage "sources of other libraries" fetch_sources
    finish_stages
    stage "build for Windows" windows_build
    finish_stages
    stage "what is installed" windows_installed
    stage "tests under wine" windows_tests "$@"
    finish_stages
}
