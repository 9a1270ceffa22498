# SPDX-License-Identifier: MIT
# ./dev deb: Debian packages of what is committed, made and tried in chroots of Debian 13, the first
# that has a Meson which is new enough.  They are left in build-deb/.

deb_suite=trixie
deb_packages=build-essential,ccache,debhelper,dh-python,lintian

deb_sources() { # as a release has them, with packaging/debian where Debian wants it
    rm -rf build-deb
    mkdir -p "build-deb/libntp-$version"
    git archive --prefix="libntp-$version/" HEAD | xz -1 >"build-deb/libntp_$version.orig.tar.xz"
    tar -xf "build-deb/libntp_$version.orig.tar.xz" -C build-deb
    cp -r packaging/debian "build-deb/libntp-$version"
    $root rm -rf --one-file-system "$chroot/build"
    $root cp -r build-deb "$chroot/build"
    rm -rf "build-deb/libntp-$version"
}

deb_build() {
    quietly build-deb/tools.log patiently in_chroot "$chroot" "
        apt-get -q update
        apt-get -q -y --no-install-recommends build-dep /build/libntp-$version"
    quietly build-deb/build.log in_chroot "$chroot" "
        cd /build/libntp-$version
        export PATH=/usr/lib/ccache:\$PATH CCACHE_DIR=/var/cache/ccache
        export DEB_BUILD_OPTIONS='${DEB_BUILD_OPTIONS:-}'
        dpkg-buildpackage -us -uc -j$jobs"
    cp "$chroot"/build/libntp_* "$chroot"/build/*.deb build-deb
    ls build-deb/*.deb
}

deb_lintian() {
    in_chroot "$chroot" "lintian --allow-root --fail-on error,warning /build/libntp_*.changes"
}

deb_installed() { # in a new chroot, by what the package's own test does
    trap '$root rm -rf --one-file-system "$chroot.new"' EXIT
    quietly build-deb/new.log patiently new_debian "$chroot.new" $deb_suite \
        gcc,libc6-dev,man-db,pkgconf
    $root cp -r "$chroot/build" "$chroot.new/build"
    quietly build-deb/install.log patiently in_chroot "$chroot.new" "
        apt-get -q update
        apt-get -q -y --no-install-recommends install /build/*.deb"
    in_chroot "$chroot.new" "cd /build/libntp-$version && debian/tests/installed"
}

deb() {
    need_root deb || return 0
    need_tools
    chroot=${XDG_CACHE_HOME:-$HOME/.cache}/libntp/deb
    version=$(sed -n 's/^version = "\(.*\)"$/\1/p' pyproject.toml)
    stage "chroot of Debian 13" make_chroot "$chroot" $deb_suite $deb_packages
    finish_stages
    stage sources deb_sources
    finish_stages
    stage packages deb_build
    finish_stages
    stage lintian deb_lintian
    stage "installed in a new chroot" deb_installed
    finish_stages
}
