# SPDX-License-Identifier: MIT
# ./dev bench and ./dev fuzz.

bench_python() {
    need_tools
    install_tree
    python bench/bench_python.py "$@"
}

bench() {
    if [ "${1:-}" = python ]; then
        shift
        bench_python "$@"
        return
    fi
    if [ "${1:-}" = operations ]; then
        shift
        need_tools
        install_tree
        pip_install python -r bench/requirements.txt
        python bench/bench_operations.py "$@"
        return
    fi
    if [ "${1:-}" = auto ]; then
        shift
        need_tools
        install_tree
        python bench/bench_auto.py "$@"
        return
    fi
    need_tools
    if [ "${1:-}" = png ]; then
        want libspng-dev pkg-config --exists spng
        [ -z "$missing" ] || rm -rf build-bench
        install_missing
    fi
    build_dir build-bench -Dbench=true -Dtests=false -Dbuildtype=release -Dstatic=true
    if [ "${1:-}" = quality ]; then
        shift
        NTP_BUILD=$top/build-bench python bench/quality.py "$@"
        return
    fi
    if [ "${1:-}" = refine ]; then
        shift
        NTP_BUILD=$top/build-bench python bench/bench_heights_loop.py "$@"
        return
    fi
    if [ "${1:-}" = exchange ]; then
        shift
        NTP_BUILD=$top/build-bench python bench/bench_exchange.py "$@"
        return
    fi
    if [ "${1:-}" = cliffs ]; then
        shift
        NTP_BUILD=$top/build-bench python bench/bench_cliffs.py "$@"
        return
    fi
    if [ "${1:-}" = heights ]; then
        shift
        pip_install python -r bench/requirements.txt
        NTP_BUILD=$top/build-bench python bench/bench_heights.py "$@"
        return
    fi
    if [ "${1:-}" = check ]; then
        shift
        pip_install python -r bench/requirements.txt
        NTP_BUILD=$top/build-bench python bench/bench_check.py "$@"
        return
    fi
    if [ "${1:-}" = compression ]; then
        shift
        pip_install python -r bench/requirements.txt
        NTP_BUILD=$top/build-bench python bench/block_encoders.py "$@"
        return
    fi
    if [ "${1:-}" = png ]; then
        shift
        pip_install python -r bench/requirements.txt
        NTP_BUILD=$top/build-bench python bench/bench_png.py "$@"
        return
    fi
    python bench/run.py build-bench "$@"
    pip_install python -r bench/requirements.txt
    printf '\nHeights to normals, beside OpenCV and numpy:\n'
    NTP_BUILD=$top/build-bench python bench/bench_height.py
    printf '\nNormals to heights, beside scipy.fft:\n'
    NTP_BUILD=$top/build-bench python bench/bench_to_height.py
}

fuzz() {
    seconds=${1:-60}
    fuzz_seed=0 fuzz_timeout=20 # seed 0: of the clock
    [ $werror = false ] || fuzz_seed=20261121 fuzz_timeout=120 # CI: always the same, and patient
    need_tools
    need_fuzz_tools
    CC=clang
    export CC
    build_dir build-fuzz -Dfuzz=libfuzzer -Dtests=false -Dcli=disabled -Ddefault_library=static \
        -Db_sanitize=address,undefined -Db_lundef=false
    for target in build-fuzz/fuzz/fuzz_*; do
        [ -f "$target" ] && [ -x "$target" ] || continue
        name=${target##*/}
        mkdir -p "build-fuzz/corpus/$name"
        say "== $name, $seconds s"
        seeds=fuzz/corpus/${name#fuzz_}
        [ -d "$seeds" ] || seeds=
        words=fuzz/$name.dict
        [ -f "$words" ] || words=
        # test_files are good seeds for the readers, and harmless for the rest
        quietly "build-fuzz/$name.log" plain_addresses \
            env UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 "$target" -max_total_time="$seconds" \
            -seed="${NTP_SEED:-$fuzz_seed}" -timeout="$fuzz_timeout" -rss_limit_mb=3000 \
            -max_len=65536 -print_final_stats=1 ${words:+"-dict=$words"} \
            -artifact_prefix="build-fuzz/$name-" "build-fuzz/corpus/$name" $seeds test_files
        grep -E 'number_of_executed_units' "build-fuzz/$name.log" || true
    done
}
