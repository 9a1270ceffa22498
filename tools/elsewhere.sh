# SPDX-License-Identifier: MIT
# ./dev elsewhere: the same results on other processors and with another C library, as on x86-64;
# and what links for macOS.

elsewhere_targets="arm64 s390x i386 musl" # each has packaging/cross/TARGET.ini

elsewhere_runner() { # what starts a program of the target: nothing where this kernel can
    case $1 in
    arm64) say qemu-aarch64 ;;
    s390x) say qemu-s390x ;;
    esac
}

links_for() { # links_for COMPILER: with the C library of its target
    links=$(mktemp)
    links_status=0
    printf 'int main(void) { return 0; }\n' | "$1" -static -x c -o "$links" - || links_status=1
    rm -f "$links"
    return $links_status
}

need_elsewhere_tools() {
    want gcc-aarch64-linux-gnu has aarch64-linux-gnu-gcc
    want gcc-s390x-linux-gnu has s390x-linux-gnu-gcc
    want gcc-i686-linux-gnu has i686-linux-gnu-gcc
    want musl-tools has musl-gcc
    want qemu-user has qemu-s390x
    install_missing
    want libc6-dev-arm64-cross links_for aarch64-linux-gnu-gcc
    want libc6-dev-s390x-cross links_for s390x-linux-gnu-gcc
    want libc6-dev-i386-cross links_for i686-linux-gnu-gcc
    install_missing
}

elsewhere_setup() { # elsewhere_setup DIR TARGET OPTION...
    elsewhere_dir=$1 elsewhere_target=$2
    shift 2
    [ -f "$elsewhere_dir/build.ninja" ] || quietly "$elsewhere_dir.setup.log" meson setup \
        "$elsewhere_dir" --cross-file "packaging/cross/$elsewhere_target.ini" -Dwerror="$werror" \
        -Dbuildtype=plain -Doptimization=2 -Ddefault_library=static -Dgegl=disabled \
        -Dgimp=disabled "$@"
}

elsewhere_sums() { # elsewhere_sums TARGET SHARE
    elsewhere_setup "build-elsewhere/$1" "$1" -Dio=disabled -Dcli=disabled
    quietly "build-elsewhere/$1.log" ninja -C "build-elsewhere/$1" -j "$jobs" tests/sums
    # shellcheck disable=SC2046 # nothing, or one word
    $(elsewhere_runner "$1") "build-elsewhere/$1/tests/sums" "$2" >"build-elsewhere/$1.sums"
    diff build-elsewhere/here.sums "build-elsewhere/$1.sums"
    say "$(wc -l <"build-elsewhere/$1.sums") sums are those of this machine"
}

elsewhere_units() { # elsewhere_units TARGET
    quietly "build-elsewhere/$1.log" ninja -C "build-elsewhere/$1" -j "$jobs"
    meson test -C "build-elsewhere/$1" --no-rebuild --print-errorlogs --timeout-multiplier 40 \
        --suite unit
}

# What libraries Debian has for a target, unpacked and not installed: its lists are kept apart too.
elsewhere_libraries() { # elsewhere_libraries ARCHITECTURE ROOT
    [ ! -f "$2/.complete" ] || return 0
    rm -rf "$2"
    mkdir -p "$2/lists" "$2/cache" "$2/packages"
    set -- "$1" "$(cd "$2" && pwd)"
    elsewhere_apt="apt-get -q -o APT::Architecture=$1 -o APT::Architectures=$1 -o Debug::NoLocking=1
        -o Dir::State::Lists=$2/lists -o Dir::Cache=$2/cache -o Dir::State::status=/dev/null
        -o Acquire::Languages=none -o APT::Sandbox::User=root"
    patiently $elsewhere_apt update >"$2/apt.log" 2>&1 ||
        say "apt-get update failed; trying with what there is"
    (cd "$2/packages" && quietly "$2/apt.log" patiently $elsewhere_apt download libpng-dev \
        zlib1g-dev libjpeg62-turbo-dev libdeflate-dev libzstd-dev libpopt-dev libjansson-dev)
    for elsewhere_package in "$2"/packages/*.deb; do dpkg -x "$elsewhere_package" "$2"; done
    touch "$2/.complete"
}

elsewhere_program() { # elsewhere_program TARGET: tests of io/, and what ntp makes of test_files
    case $1 in
    arm64) elsewhere_triplet=aarch64-linux-gnu ;;
    *) elsewhere_triplet=$1-linux-gnu ;;
    esac
    elsewhere_root=$top/build-elsewhere/root-$1
    elsewhere_libraries "$1" "$elsewhere_root"
    (
        export PKG_CONFIG_LIBDIR="$elsewhere_root/usr/lib/$elsewhere_triplet/pkgconfig"
        export PKG_CONFIG_SYSROOT_DIR="$elsewhere_root" PKG_CONFIG_PATH=
        # The compiler of a target does not look there by itself, nor does pkg-config name them.
        elsewhere_setup "build-elsewhere/ntp-$1" "$1" -Dprefer_static=true \
            -Dc_args="-isystem $elsewhere_root/usr/include/$elsewhere_triplet" \
            -Dc_link_args="-static -L$elsewhere_root/usr/lib/$elsewhere_triplet" \
            -Djpeg=enabled -Dlibdeflate=enabled -Dzstd=enabled -Dwebp=disabled -Dexr=disabled
        quietly "build-elsewhere/$1.log" ninja -C "build-elsewhere/ntp-$1" -j "$jobs"
    )
    # On arm64 these compare the filters of PNG in NEON with those in plain C.
    meson test -C "build-elsewhere/ntp-$1" --no-rebuild --print-errorlogs --timeout-multiplier 40 \
        --suite io
    tests/elsewhere/outputs.sh "$(elsewhere_runner "$1") $top/build-elsewhere/ntp-$1/cli/ntp" \
        build-elsewhere/outputs >"build-elsewhere/$1.outputs"
    diff build-elsewhere/here.outputs "build-elsewhere/$1.outputs"
    say "$(wc -l <"build-elsewhere/$1.outputs") files are those of this machine"
}

need_zig() {
    .venv-zig/bin/python -m ziglang version >/dev/null 2>&1 && return 0
    "$python" -m venv --clear .venv-zig
    pip_install .venv-zig/bin/python ziglang==0.17.1 macholib==1.16.4
}

# ntp and libntp for a Mac, with the other libraries from their sources; they cannot run here.
elsewhere_macos() { # elsewhere_macos PROCESSOR
    elsewhere_dir=build-elsewhere/macos-$1
    (
        export PATH="$top/.venv-zig/bin:$PATH" # the cross file says python3 -m ziglang
        # In there: zig leaves an a.o where Meson asks it what it is.
        [ -f "$elsewhere_dir/build.ninja" ] || (
            cd build-elsewhere
            quietly "macos-$1.setup.log" meson setup "macos-$1" "$top" --wrap-mode=nodownload \
                --cross-file "$top/packaging/cross/macos-$1.ini" -Ddebug=false -Doptimization=1 \
                -Dgegl=disabled -Dgimp=disabled -Dtests=false
        )
        quietly "$elsewhere_dir.log" ninja -C "$elsewhere_dir" -j "$jobs"
    )
    .venv-zig/bin/python tests/elsewhere/mach_o.py "$elsewhere_dir/cli/ntp" \
        "$elsewhere_dir"/libntp/libntp.[0-9]*.dylib
}

elsewhere() { # elsewhere [--sums | TARGET...]
    elsewhere_share=1 elsewhere_macs="arm64 x86_64"
    case ${1:-} in
    --sums) elsewhere_share=64 ;;
    ?*) elsewhere_targets=$* elsewhere_macs= ;;
    esac
    need_tools
    need_elsewhere_tools
    build_main
    mkdir -p build-elsewhere
    quietly build-elsewhere/here.log ninja -C build -j "$jobs" tests/sums
    build/tests/sums $elsewhere_share >build-elsewhere/here.sums
    for elsewhere_target in $elsewhere_targets; do
        stage "$elsewhere_target: sums" elsewhere_sums "$elsewhere_target" $elsewhere_share
    done
    if [ $elsewhere_share = 1 ]; then
        tests/elsewhere/outputs.sh "$top/build/cli/ntp" build-elsewhere/outputs \
            >build-elsewhere/here.outputs
        for elsewhere_target in $elsewhere_targets; do
            stage "$elsewhere_target: unit tests" elsewhere_units "$elsewhere_target"
            [ "$elsewhere_target" = musl ] || # Debian has no libraries for it
                stage "$elsewhere_target: ntp" elsewhere_program "$elsewhere_target"
        done
        [ -z "$elsewhere_macs" ] || {
            find_python
            need_zig
            fetch_sources
        }
        for elsewhere_target in $elsewhere_macs; do
            stage "macOS, $elsewhere_target" elsewhere_macos "$elsewhere_target"
        done
    fi
    finish_stages
}
