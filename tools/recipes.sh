# SPDX-License-Identifier: MIT
# ./dev recipes: the recipes for vcpkg, Conan and Homebrew, filled for an archive of what is
# committed, and run as far as that goes without vcpkg and Homebrew.

need_recipe_tools() {
    want cmake has cmake
    want ruby has ruby
    want pkgconf has pkgconf
    install_missing
    .venv-conan/bin/conan --version 2>/dev/null | grep -qF " $conan_version" && return 0
    find_python || die "no Python 3.11 or newer with venv found"
    "$python" -m venv --clear .venv-conan
    pip_install .venv-conan/bin/python "conan==$conan_version" ||
        die "pip could not install conan (it needs the network once)"
}
conan_version=2.34.0

recipes_fill() { # the archive is made as the workflow makes it
    rm -rf build-recipes
    mkdir -p build-recipes
    archive=build-recipes/libntp-$version.tar.gz
    git archive --prefix="libntp-$version/" HEAD | gzip -9n >"$archive"
    python packaging/recipes.py "$archive" https://example.org/libntp build-recipes
    # Conan can fetch from a file.
    sed "s|https://example.org/.*/|file://$top/build-recipes/|" build-recipes/conan/conandata.yml \
        >build-recipes/conandata.yml
}

recipe_vcpkg() {
    for linkage in static dynamic; do
        cmake -DPORTFILE="$top/build-recipes/vcpkg/portfile.cmake" \
            -DARCHIVE="$top/build-recipes/libntp-$version.tar.gz" -DVERSION="$version" \
            -DWORK="$top/build-recipes/vcpkg-$linkage" -DVCPKG_LIBRARY_LINKAGE=$linkage \
            -P tests/recipes/vcpkg.cmake
        (cd "build-recipes/vcpkg-$linkage/package" && find . -type f | sort)
        # shellcheck disable=SC2046 # words
        cc packaging/conan/test_package/version.c -o build-recipes/version \
            $(PKG_CONFIG_PATH=build-recipes/vcpkg-$linkage/package/lib/pkgconfig \
                pkg-config --cflags --libs libntp) -lm
        LD_LIBRARY_PATH=build-recipes/vcpkg-$linkage/package/lib build-recipes/version
    done
}

recipe_conan() { # with this machine's Meson, Ninja and pkgconf instead of Conan's packages
    export CONAN_HOME="$top/build-recipes/conan-home" CONAN_DEFAULT_PROFILE=default
    conan=.venv-conan/bin/conan
    cp build-recipes/conandata.yml build-recipes/conan/conandata.yml
    quietly build-recipes/conan.log $conan profile detect
    cat >>"$CONAN_HOME/profiles/default" <<END

[platform_tool_requires]
meson/$(meson --version)
ninja/$(ninja --version)
pkgconf/$(pkgconf --version)
END
    for shared in True False; do
        quietly build-recipes/conan.log $conan create build-recipes/conan -o "libntp/*:shared=$shared" \
            --no-remote
        grep '^libntp ' build-recipes/conan.log
    done
}

recipe_homebrew() { ruby tests/recipes/homebrew.rb build-recipes/homebrew/libntp.rb \
    "build-recipes/libntp-$version.tar.gz" build-recipes/homebrew-work; }

recipes() {
    need_tools
    need_recipe_tools
    version=$(sed -n 's/^version = "\(.*\)"$/\1/p' pyproject.toml)
    stage "filled for an archive" recipes_fill
    finish_stages
    stage vcpkg recipe_vcpkg
    stage Conan recipe_conan
    stage Homebrew recipe_homebrew
    finish_stages
}
