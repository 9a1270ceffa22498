# SPDX-License-Identifier: MIT
# ./dev windows: libntp and ntp.exe for Windows by mingw-w64, and their tests under wine.

need_windows_tools() {
    want gcc-mingw-w64-x86-64 has x86_64-w64-mingw32-gcc
    want wine has wine
    install_missing
}

windows_build() { # windows_build DIR OPTION...
    windows_dir=$1
    shift
    [ -f "$windows_dir/build.ninja" ] || quietly "$windows_work/setup.log" meson setup "$windows_dir" \
        --wrap-mode=nodownload --cross-file packaging/cross/x86_64-w64-mingw32.ini \
        -Dgegl=disabled -Dgimp=disabled -Ddebug=false "$@"
    quietly "$windows_work/ninja.log" ninja -C "$windows_dir" -j "$jobs"
}

windows_installed() { # a folder as a user has it: the program needs no DLL but those of Windows
    rm -rf "$windows_work/installed"
    DESTDIR=$windows_work/installed meson install -C "$windows_dir" --no-rebuild --quiet
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

windows_c_tests() { # windows_c_tests ARG...: of meson test
    meson test -C "$windows_dir" --no-rebuild --print-errorlogs --timeout-multiplier 20 "$@"
}

windows_pytest() { # windows_pytest ARG...: with ntp.exe, and with the library of this system
    NTP_EXE=$top/$windows_dir/cli/ntp.exe NTP_BUILD=$top/build \
        python -m pytest -q -rs -p no:cacheprovider "$@"
}

windows_tests() { windows_pytest -c /dev/null --rootdir="$top" tests/windows/ntp_exe.py "$@"; }

# The suites of the program, but for what tests/windows/left_out.txt lists.
windows_suites() { NTP_PROGRAM=$top/tests/windows/under_wine windows_pytest "$@" tests/cli; }

windows_core="check_says or patterns or unicode or long or characters or read_only or full_disk \
    or in_place or console or closed_pipe or ctrl_c and 1 or bytes_are_those_of_linux and clean"

windows() { # windows [--core | --suites | ARG...]: the arguments are pytest's
    need_tools
    need_windows_tools
    windows_dir=build-windows
    windows_work=$top/build-windows-work
    mkdir -p "$windows_work"
    export WINEPREFIX="$windows_work/wine" WINEDEBUG=-all WINEDLLOVERRIDES=mscoree,mshtml=
    build_main
    stage "sources of other libraries" fetch_sources
    finish_stages
    case ${1:-} in
    --core) windows_dir=build-windows-core ;; # built fast, not to be fast
    esac
    stage "build for Windows" windows_build "$windows_dir" \
        -Doptimization="$([ "${1:-}" = --core ] && echo 1 || echo 2)"
    finish_stages
    case ${1:-} in
    --core)
        stage "what is installed" windows_installed
        stage "tests in C under wine" windows_c_tests io_round_trips io_sources threads views
        stage "tests under wine" windows_tests -k "$windows_core"
        ;;
    --suites)
        shift
        stage "suites of the program under wine" windows_suites "$@"
        ;;
    '')
        stage "what is installed" windows_installed
        stage "tests in C under wine" windows_c_tests
        stage "tests under wine" windows_tests
        stage "suites of the program under wine" windows_suites
        ;;
    *) stage "tests under wine" windows_tests "$@" ;;
    esac
    finish_stages
}
