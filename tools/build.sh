# SPDX-License-Identifier: MIT
# Building, and running in stages that say how long they took.

quietly() { # quietly LOG COMMAND...: shows the log only on failure
    quiet_log=$1
    shift
    "$@" >"$quiet_log" 2>&1 || { cat "$quiet_log"; die "failed: $*"; }
}

# The build looks for these by pkg-config, and what it finds decides what is built.
looked_for="libpng zlib libdeflate libzstd libjpeg libwebp OpenEXR popt jansson gegl-0.4 gimp-3.0 gimpui-3.0 gimp-2.0 gimpui-2.0"

first_line() { "$@" 2>/dev/null | sed -n 1p; }

what_is_here() { # what a build directory was configured with, besides its options
    for package in $looked_for; do
        say "$package $(pkg-config --modversion "$package" 2>/dev/null || echo none)"
    done
    say "pkg-config ${PKG_CONFIG_PATH:-} ${PKG_CONFIG_LIBDIR:-}"
    say "c++ $(first_line c++ --version)"
    say "msgfmt $(first_line msgfmt --version)"
    say "python3 $(command -v python3) $(first_line python3 --version)"
}

# build_dir DIR OPTION...: configures anew when the options, the tools or the installed packages
# changed, then builds.  A directory that a developer configured by hand is built as it is.
build_dir() {
    dir=$1
    shift
    options="$(meson --version) $(first_line "${CC:-cc}" --version) in $top: $*"
    here=$(what_is_here)
    stamp=$dir/.dev-options
    if [ -f "$stamp" ] && [ "$(sed -n 1p "$stamp")" != "$options" ]; then
        rm -rf "$dir"
    elif [ -f "$stamp" ] && [ -f "$dir/build.ninja" ] && [ "$(sed 1d "$stamp")" != "$here" ]; then
        say "configuring $dir anew, for what is installed has changed"
        meson setup --reconfigure --clearcache "$dir" >"$dir/setup.log" 2>&1 || rm -rf "$dir"
    fi
    if [ ! -f "$dir/build.ninja" ]; then
        rm -rf "$dir"
        mkdir -p "$dir"
        quietly "$dir/setup.log" meson setup "$dir" "$@"
        say "$options" >"$stamp"
    fi
    [ ! -f "$stamp" ] || printf '%s\n%s\n' "$options" "$here" >"$stamp"
    quietly "$dir/ninja.log" ninja -C "$dir" -j "$jobs"
}

build_main() { build_dir build -Dwerror="$werror" -Dstatic=true; }

# stage NAME COMMAND...: runs it, prints how long it took, remembers failure
failed=
stage() {
    stage_name=$1
    shift
    stage_start=$(date +%s)
    say "== $stage_name"
    # A subshell of its own, so that set -e holds inside it.
    set +e
    (set -e; "$@")
    stage_status=$?
    set -e
    stage_result=ok
    [ $stage_status = 0 ] || { stage_result=FAILED failed="$failed '$stage_name'"; }
    say "== $stage_name: $stage_result, $(($(date +%s) - stage_start)) s"
}

finish_stages() { [ -z "$failed" ] || die "failed:$failed"; }
