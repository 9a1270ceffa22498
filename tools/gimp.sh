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

gimp3_chroot() {
    [ "$(cat "$chroot.made" 2>/dev/null)" = "$gimp3_suite $gimp3_packages" ] && return 0
    want mmdebstrap has mmdebstrap
    install_missing
    say "making a chroot of Debian $gimp3_suite with GIMP 3 in $chroot (about 1 GB, once)"
    # The packages come from the mirror that this machine uses.
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' \
        'Label: Debian' 2>/dev/null | head -n 1)
    rm -f "$chroot.made"
    quietly "$chroot.log" patiently gimp3_debian
    say "$gimp3_suite $gimp3_packages" >"$chroot.made"
}

gimp3_debian() {
    $root rm -rf "$chroot"
    $root mmdebstrap --variant=apt --aptopt='Acquire::Languages "none"' \
        --aptopt='Acquire::Retries "5"' --dpkgopt='path-exclude=/usr/share/doc/*' \
        --dpkgopt='path-exclude=/usr/share/man/*' \
        --dpkgopt='path-exclude=/usr/share/locale/*' --include="$gimp3_packages" \
        "$gimp3_suite" "$chroot" $mirror
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
    root=
    if [ "$(id -u)" != 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            [ $werror = false ] || die "gimp3 needs root, for chroot"
            say "gimp3: skipped, it needs root for chroot"
            return 0
        fi
        root='sudo -n'
    fi
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
