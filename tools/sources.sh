# SPDX-License-Identifier: MIT
# Sources of the libraries that Meson wraps name, from this system's source packages, for builds that
# cannot use its own: Windows, WebAssembly.

# TOOL ARG...: the source packages of this Debian, beside the lists that the system has.
for_sources() {
    sources_tool=$1
    shift
    "$sources_tool" -q -o Dir::Etc::SourceList=/dev/null -o "Dir::Etc::SourceParts=$sources_work/parts" \
        -o "Dir::State::Lists=$sources_work/lists" -o "Dir::Cache=$sources_work/cache" \
        -o APT::Sandbox::User=root "$@"
}

source_dir() { echo "subprojects/$(sed -n 's/^directory = //p' "subprojects/$1.wrap")"; }

# Of the versions that are listed a mirror may have only some: security updates lag behind, or are gone.
download_source() {
    for sources_version in '' $(for_sources apt-cache showsrc "$1" | sed -n 's/^Version: /=/p' | sort -rVu); do
        ! for_sources apt-get source --download-only --tar-only "$1$sources_version" >/dev/null || return 0
    done
    return 1
}

# fetch_source PACKAGE WRAP: its source where the wrap would put it, with the build files of the wrap
fetch_source() {
    sources_to=$(source_dir "$2")
    if [ ! -d "$sources_to" ]; then
        (cd "$sources_work" && download_source "$1")
        mkdir -p "$sources_to.new"
        tar -x --strip-components=1 -C "$sources_to.new" -f "$sources_work/$1"_*.orig.tar.*
        mv "$sources_to.new" "$sources_to"
    fi
    cp -r "subprojects/packagefiles/$2/." "$sources_to"
}

fetch_sources() {
    sources_work=$top/build-sources
    mkdir -p "$sources_work/parts" "$sources_work/lists/partial" "$sources_work/cache/archives/partial"
    sources_missing=
    for sources_wrap in zlib libpng libdeflate libjpeg-turbo popt jansson zstd; do
        [ -d "$(source_dir "$sources_wrap")" ] || sources_missing=yes
    done
    if [ -n "$sources_missing" ]; then
        for sources_list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
            [ ! -f "$sources_list" ] || ! grep -q debian "$sources_list" ||
                sed 's/^deb /deb-src /; s/^Types:.*/Types: deb-src/' "$sources_list" \
                    >"$sources_work/parts/$(basename "$sources_list")"
        done
        patiently for_sources apt-get update >/dev/null || say "apt-get update failed; trying with what there is"
    fi
    fetch_source zlib zlib
    fetch_source libpng1.6 libpng
    fetch_source libdeflate libdeflate
    fetch_source libjpeg-turbo libjpeg-turbo
    fetch_source popt popt
    fetch_source jansson jansson
    fetch_source libzstd zstd
}
