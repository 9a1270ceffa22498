# SPDX-License-Identifier: MIT
# ./dev windows: libntp and ntp.exe for Windows by mingw-w64, and their tests under wine.

need_windows_tools() {
    want gcc-mingw-w64-x86-64 has x86_64-w64-mingw32-gcc
    want wine has wine
    install_missing
}

# The source packages of this Debian, beside the lists that the system has.
windows_apt() {
    apt-get -q -o Dir::Etc::SourceList=/dev/null -o "Dir::Etc::SourceParts=$windows_work/parts" \
        -o "Dir::State::Lists=$windows_work/lists" -o "Dir::Cache=$windows_work/cache" \
        -o APT::Sandbox::User=root "$@"
}

# windows_source PACKAGE WRAP: its source where the wrap would put it, with the build files of the wrap
windows_source() {
    windows_to=subprojects/$(sed -n 's/^directory = //p' "subprojects/$2.wrap")
    if [ ! -d "$windows_to" ]; then
        (cd "$windows_work" && windows_apt source --download-only "$1" >/dev/null)
        mkdir -p "$windows_to.new"
        tar -x --strip-components=1 -C "$windows_to.new" -f "$windows_work/$1"_*.orig.tar.*
        mv "$windows_to.new" "$windows_to"
    fi
    cp -r "subprojects/packagefiles/$2/." "$windows_to"
}

windows_sources() {
    mkdir -p "$windows_work/parts" "$windows_work/lists/partial" "$windows_work/cache/archives/partial"
    if ! ls -d subprojects/popt-*/ >/dev/null 2>&1; then
        for windows_list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
            [ ! -f "$windows_list" ] || ! grep -q debian "$windows_list" ||
                sed 's/^deb /deb-src /; s/^Types:.*/Types: deb-src/' "$windows_list" \
                    >"$windows_work/parts/$(basename "$windows_list")"
        done
        patiently windows_apt update >/dev/null || say "apt-get update failed; trying with what there is"
    fi
    windows_source zlib zlib
    windows_source libpng1.6 libpng
    windows_source libdeflate libdeflate
    windows_source libjpeg-turbo libjpeg-turbo
    windows_source popt popt
    windows_source jansson jansson
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
    export WINEPREFIX="$windows_work/wine" WINEDEBUG=-all WINEDLLOVERRIDES=mscoree,mshtml=
    build_main
    stage "sources of other libraries" windows_sources
    finish_stages
    stage "build for Windows" windows_build
    finish_stages
    stage "what is installed" windows_installed
    stage "tests under wine" windows_tests "$@"
    finish_stages
}
