# SPDX-License-Identifier: MIT
# ./dev gimp and ./dev gimp3: the parts for GIMP, here and in a chroot of Debian 13.

# Only the parts for GIMP are built and installed; the user's own directories need no root.
gimp() {
    need_tools
    want libgegl-dev pkg-config --exists gegl-0.4
    want_gimp
    install_missing
    build_dir build-gimp -Dgimp_install=user -Dgegl=enabled -Dgimp=enabled -Dbuildtype=release \
        -Dio=disabled -Dcli=disabled -Dtests=false
    meson install -C build-gimp --no-rebuild --tags gimp,i18n | grep '^Installing'
    say "To remove them again: ninja -C build-gimp uninstall"
    if [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
        say "There is no display: start GIMP yourself and open test_files/height_rgb.png"
    else
        say "Filters > Generic has the filters (GIMP 2.10: the operations are in Tools > GEGL Operation)."
        command gimp test_files/height_rgb.png
    fi
}

# GIMP 3 runs in a chroot of Debian 13, which is kept in the cache; nothing is mounted there.
gimp3_suite=trixie
gimp3_packages=gimp,libgimp-3.0-dev,meson,gcc,libc6-dev,pkgconf,gettext,python3-gi

gimp3_chroot() { # about 1 GB
    make_chroot "$chroot" $gimp3_suite $gimp3_packages --dpkgopt='path-exclude=/usr/share/doc/*' \
        --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/locale/*'
}

gimp3_build() { # the tree, built and installed inside
    $root rm -rf "$chroot/src"
    $root mkdir -p "$chroot/src"
    tar -cf - --exclude='./build*' --exclude='./.venv*' --exclude=./.git . | $root tar -xf - -C "$chroot/src"
    options="-Dprefix=/usr -Dio=disabled -Dcli=disabled -Dtests=false -Dgegl=enabled -Dgimp=enabled"
    options="$options -Dwerror=$werror"
    quietly "$chroot.log" $root chroot "$chroot" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 sh -ec "
        [ \"\$(cat /build/.dev-options 2>/dev/null)\" = '$options' ] || rm -rf /build
        [ -f /build/build.ninja ] || meson setup /build /src $options
        echo '$options' >/build/.dev-options
        ninja -C /build
        meson install -C /build --no-rebuild --tags gimp,i18n"
}

gimp3() {
    need_root gimp3 || return 0
    need_tools
    build_main
    cache=${XDG_CACHE_HOME:-$HOME/.cache}/libntp
    chroot=$cache/gimp3
    mkdir -p "$cache"
    stage "chroot with GIMP 3" gimp3_chroot
    finish_stages
    stage "build in the chroot" gimp3_build
    finish_stages
    if [ "${1:-}" = --bench ]; then
        shift
        NTP_BUILD=$top/build NTP_GIMP3=$chroot python bench/gimp3.py "$@"
        return
    fi
    stage "tests in GIMP 3" gimp3_tests "$@"
    finish_stages
}

gimp3_tests() { # each file starts a GIMP of its own, with a profile of its own
    NTP_BUILD=$top/build NTP_GIMP3=$chroot python -m pytest -q -p no:cacheprovider -n "$jobs" \
        --dist loadfile tests/gimp/gimp3*.py "$@"
}
