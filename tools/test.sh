# SPDX-License-Identifier: MIT
# ./dev test: every test, and the same under ASan and UBSan.

# Sanitizers of these compilers fail where a kernel gives addresses more random bits than they know.
plain_addresses() {
    if setarch "$(uname -m)" -R true 2>/dev/null; then
        setarch "$(uname -m)" -R "$@"
    else
        "$@"
    fi
}

meson_test() { # meson_test DIR ARG...; in CI a skipped test is a failure (pytest's: tests/conftest.py)
    meson_dir=$1
    shift
    plain_addresses meson test -C "$meson_dir" --no-rebuild --print-errorlogs \
        --timeout-multiplier 5 "$@" # limits end what hangs; a busy machine is no failure
    if [ $werror = true ] && grep '"result": "SKIP"' "$meson_dir/meson-logs/testlog.json"; then
        return 1
    fi
}

# The C tests of the sanitizer build, then its library inside Python and its program.
test_asan() {
    export ASAN_OPTIONS=detect_leaks=1:abort_on_error=1 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    meson_test build-asan --no-suite python --no-suite exhaustive --no-suite sweep \
        --no-suite symbols --no-suite examples --no-suite headers
}

pytest_asan() {
    # Python's own allocations at exit are no leaks of ours; the program is checked for leaks above.
    plain_addresses env NTP_BUILD=$top/build-asan NTP_PROGRAM=$top/build-asan/cli/ntp \
        NTP_LIBRARY=$top/build-asan/libntp/libntp.so NTP_SANITIZED=1 \
        LD_PRELOAD="$(cc -print-file-name=libasan.so) $(cc -print-file-name=libubsan.so)" \
        ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
        python -m pytest -q -p no:cacheprovider tests --ignore=tests/test_exhaustive.py "$@"
}

pytest_asan_beside() { # the status file appears whole
    set +e
    pytest_asan >build-asan/pytest.log 2>&1
    echo $? >build-asan/pytest.status.new
    mv build-asan/pytest.status.new build-asan/pytest.status
}

pytest_asan_done() { # waits, and shows
    while [ ! -f build-asan/pytest.status ]; do sleep 1; done
    tail -n 200 build-asan/pytest.log
    [ "$(cat build-asan/pytest.status)" = 0 ]
}

# For --quick: single texels, what ntp says and writes, the table of test_files.
quick_tests="tests/test_levels.py tests/test_inspect.py tests/test_files_table.py
    tests/cli/test_check.py tests/cli/test_program.py tests/cli/test_write.py"
pytest_quick() { NTP_BUILD=$top/build python -m pytest -q -p no:cacheprovider $quick_tests; }

run_tests() {
    quick=no
    [ "${1:-}" != --quick ] || { quick=yes; shift; }
    need_tools
    need_test_tools
    if [ "${1:-}" = -- ]; then
        shift
        build_main
        NTP_BUILD=$top/build exec python -m pytest -p no:cacheprovider "$@"
    fi
    stage build build_main
    finish_stages
    if [ $# -gt 0 ]; then
        for suite in "$@"; do
            stage "suite $suite" meson_test build --suite "$suite"
        done
    elif [ $quick = yes ]; then
        stage "C tests" meson_test build --no-suite sweep --no-suite exhaustive --no-suite python
        stage "a choice of the Python tests" pytest_quick
    else
        stage "build with ASan and UBSan" build_asan
        finish_stages
        rm -f build-asan/pytest.status
        pytest_asan_beside &
        stage "tests (pytest under ASan and UBSan goes on beside them)" meson_test build --no-suite sweep
        stage "C tests under ASan and UBSan" test_asan
        stage "pytest under ASan and UBSan, from here" pytest_asan_done
    fi
    finish_stages
    say "all tests passed"
}
