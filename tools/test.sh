# SPDX-License-Identifier: MIT
# ./dev test: every test, or the same under ASan and UBSan, or some of them.

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

pytest_of() { # pytest_of DIR ARG...: the built files come from this directory only
    pytest_dir=$1
    shift
    NTP_BUILD=$top/$pytest_dir python -m pytest -q -p no:cacheprovider "$@"
}

# Runs on all cores.  --dist loadgroup keeps modules that start GIMP in one process.
pytest_all() { pytest_of build -rs -n "$jobs" --dist loadgroup tests; }

c_tests() { meson_test build --no-suite sweep --no-suite exhaustive --no-suite python; }

# The C tests of the sanitizer build, then its library inside Python and its program.
c_tests_sanitized() {
    export ASAN_OPTIONS=detect_leaks=1:abort_on_error=1 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
    meson_test build-asan --no-suite python --no-suite exhaustive --no-suite sweep \
        --no-suite symbols --no-suite examples --no-suite headers
}

pytest_sanitized() {
    # What Python still holds at exit is no leak of the library; the C tests look for leaks.
    plain_addresses env NTP_BUILD=$top/build-asan NTP_SANITIZED=1 \
        LD_PRELOAD="$(cc -print-file-name=libasan.so) $(cc -print-file-name=libubsan.so)" \
        ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
        python -m pytest -q -rs -p no:cacheprovider -n "$jobs" --dist loadgroup \
        tests --ignore=tests/test_exhaustive.py
}

# --quick runs these: single texels, what ntp says and writes, the table of test_files.
quick_tests="tests/test_levels.py tests/test_inspect.py tests/test_files_table.py
    tests/cli/test_check.py tests/cli/test_program.py tests/cli/test_clean.py
    tests/cli/test_written_files.py"
pytest_quick() { pytest_of build -n "$jobs" --dist loadgroup $quick_tests; }

c_file() { # c_file FILE: the C tests that are made of it, by the names that meson has for them (x, x_avx2, x_avx512)
    [ -f "$1" ] || die "there is no $1"
    name=$(basename "$1" .c)
    name=${name#test_}
    case $1 in */io/*) name=io_$name ;; esac
    meson_test build "$name*"
}

package_file() { # package_file ARG...: tests of the Python package, which is installed first
    install_tree
    python -m pytest -q -p no:cacheprovider "$@"
}

test_some() { # test_some FILE|SUITE... or FILE... ARG...: what follows a Python file is pytest's
    while [ $# -gt 0 ]; do
        case $1 in
        tests/gimp/gimp3*) die "this file runs in GIMP 3: ./dev gimp3" ;;
        --) shift; stage pytest pytest_of build tests "$@"; return ;;
        -*) stage pytest pytest_of build tests "$@"; return ;;
        *.c) stage "$1" c_file "$1" ;;
        bindings/python/*) stage "$*" package_file "$@"; return ;;
        tests | tests/*) stage "$*" pytest_of build "$@"; return ;;
        python) stage "suite $1" pytest_all ;;
        unit | io | headers | symbols | exhaustive | sweep | examples)
            stage "suite $1" meson_test build --suite "$1" ;;
        *) die "no such suite or file: $1 (./dev help lists them)" ;;
        esac
        shift
    done
}

not_run() {
    say "not run: ASan and UBSan (./dev test --sanitize), all 2^32 pairs of 16 bit (./dev test sweep),"
    say "the Python package (./dev python), GIMP 3 (./dev gimp3), the pages (./dev docs), fuzzing (./dev fuzz)"
}

run_tests() {
    need_tools
    need_test_tools
    case ${1:-} in
    --sanitize)
        stage "build with ASan and UBSan" build_dir build-asan -Dwerror="$werror" \
            -Db_sanitize=address,undefined -Db_lundef=false -Doptimization=2 -Dfuzz=replay
        finish_stages
        stage "C tests under ASan and UBSan" c_tests_sanitized
        stage "pytest under ASan and UBSan" pytest_sanitized
        finish_stages
        say "all tests passed; of modules with many cases every fourth was run"
        return
        ;;
    esac
    stage build build_main
    finish_stages
    case ${1:-} in
    --quick)
        stage "C tests" c_tests
        stage "a choice of the Python tests" pytest_quick
        finish_stages
        say "passed; not run: the other tests (./dev test)"
        ;;
    '')
        stage "C tests" c_tests
        stage "pytest" pytest_all
        finish_stages
        say "all tests passed"
        not_run
        ;;
    *)
        test_some "$@"
        finish_stages
        ;;
    esac
}
