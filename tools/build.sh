# SPDX-License-Identifier: MIT
# Building, and running in stages that say how long they took.

quietly() { # quietly LOG COMMAND...: shows the log only on failure
    quiet_log=$1
    shift
    "$@" >"$quiet_log" 2>&1 || { cat "$quiet_log"; die "failed: $*"; }
}

# build_dir DIR OPTION...: configures anew when the options changed, then builds.  A directory
# that a developer configured by hand is built as it is.
build_dir() {
    dir=$1
    shift
    options="$(meson --version) ${CC:-cc} $*"
    if [ -f "$dir/.dev-options" ] && [ "$(cat "$dir/.dev-options")" != "$options" ]; then
        rm -rf "$dir"
    fi
    if [ ! -f "$dir/build.ninja" ]; then
        rm -rf "$dir"
        mkdir -p "$dir"
        quietly "$dir/setup.log" meson setup "$dir" "$@"
        say "$options" >"$dir/.dev-options"
    fi
    quietly "$dir/ninja.log" ninja -C "$dir" -j "$jobs"
}

build_main() { build_dir build -Dwerror="$werror"; }

build_asan() {
    build_dir build-asan -Dwerror="$werror" -Db_sanitize=address,undefined -Db_lundef=false \
        -Doptimization=1
}

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
