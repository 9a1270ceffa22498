# SPDX-License-Identifier: MIT
# ./dev python and ./dev docs: the Python package and what is tested and shown with it.

wheel_of() { # wheel_of SOURCE ARG...: into build-python/dist
    wheel_source=$1
    shift
    quietly build-python/wheel.log python -m pip --disable-pip-version-check wheel -q --no-deps \
        --no-build-isolation -w build-python/dist "$@" "$wheel_source"
}

python_build() { # what is committed goes into the sdist, and only from that comes the wheel
    quietly build-python/sdist.log python -m build -q --sdist --no-isolation -o build-python/dist .
    wheel_of build-python/dist/*.tar.gz
}

python_repair() { # makes it a manylinux wheel: libpng and the others become part of it
    rm -rf build-python/repaired
    quietly build-python/repair.log auditwheel repair -w build-python/repaired build-python/dist/*.whl
    auditwheel show build-python/repaired/*.whl >build-python/show.txt
    grep -q manylinux build-python/show.txt || { cat build-python/show.txt; return 1; }
    python bindings/python/audit.py build-python/dist/*.tar.gz build-python/dist/*.whl \
        build-python/repaired/*.whl
}

python_types() {
    python -m mypy --cache-dir build-python/mypy bindings/python/normaltexture \
        bindings/python/tests/typed_use.py
    quietly build-python/pyright.log pyright --pythonpath .venv-python/bin/python \
        -p pyproject.toml
}

python_tests() {
    site=$(cd build-python && python -c 'import normaltexture; print(*normaltexture.__path__)')
    python -m pytest -q -p no:cacheprovider -n "$jobs" --dist loadfile bindings/python/tests "$@"
    PYTHONPATH=bindings/python/tests python -m pytest -q -p no:cacheprovider -c /dev/null \
        --rootdir "$site" -p pysupport.doctest_place --ignore "$site/usd/plugin.py" \
        --doctest-modules "$site" # the plugin is for USD alone to import
}

new_repository() { # new_repository DIR: of the files that are there
    git -C "$1" init -q
    git -C "$1" add -A
    git -C "$1" -c user.name=ntp -c user.email=ntp@example.com commit -q -m all
}

# With nothing but what the wheel's metadata asks for: as pre-commit installs it for its users.
python_clean_install() {
    clean=$top/build-python/clean
    rm -rf "$clean"
    mkdir -p "$clean/game"
    cp -r packaging/pre-commit "$clean/hooks"
    python_version=$(sed -n 's/^version = "\(.*\)"$/\1/p' pyproject.toml)
    sed -i "s/0\.0\.0/$python_version/" "$clean/hooks/pyproject.toml"
    new_repository "$clean/hooks"
    git -C "$clean/hooks" tag "v$python_version"
    cp test_files/standard_z_off.png "$clean/game/wall_n.png"
    printf 'repos: [{repo: %s, rev: v%s, hooks: [{id: ntp-check}]}]\n' "$clean/hooks" \
        "$python_version" >"$clean/game/.pre-commit-config.yaml"
    new_repository "$clean/game"
    export PRE_COMMIT_HOME="$clean/home" PIP_ONLY_BINARY=normaltexture
    export PIP_FIND_LINKS="$top/build-python/repaired ${PIP_FIND_LINKS:-}"
    (cd "$clean/game" && quietly "$clean/install.log" patiently pre-commit install-hooks)
    (cd "$clean/game" && ! pre-commit run --all-files >"$clean/hook.log")
    grep '^  error   NT001' "$clean/hook.log" || { cat "$clean/hook.log"; return 1; }
    programs=$(echo "$clean"/home/*/py_env-*/bin)
    (cd build-python && "$programs/python" -c 'import normaltexture as nt; print(nt.codecs)')
    "$programs/ntp" report test_files/standard.png -o build-python/report.html
    "$programs/ntp" help gltf >/dev/null
}

# One commit gives one wheel, and that needs neither a compiler nor a library of its system.
wheel_twice() {
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
    export SOURCE_DATE_EPOCH
    for wheel_time in first second; do
        rm -rf build-python/dist build-python/$wheel_time
        mkdir -p build-python/dist build-python/$wheel_time
        python_build
        python_repair
        mv build-python/dist/* build-python/repaired/* build-python/$wheel_time
    done
    (cd build-python/first && sha256sum -- *) | tee build-python/first.sums
    (cd build-python/second && sha256sum -- *) | diff build-python/first.sums -
}

wheel_bare() { # a new Debian with Python alone, and no network; what the wheel asks for comes from here
    bare=$top/build-python/bare
    trap '$root rm -rf --one-file-system "$bare"' EXIT
    quietly build-python/bare.log patiently new_debian "$bare" trixie python3,python3-venv
    rm -rf build-python/wheels
    quietly build-python/bare.log patiently python -m pip --disable-pip-version-check download -q \
        --only-binary :all: --python-version 3.13 --abi cp313 --abi abi3 --abi none \
        --platform manylinux_2_34_x86_64 --platform manylinux_2_28_x86_64 \
        --platform manylinux_2_17_x86_64 --platform manylinux2014_x86_64 \
        -d build-python/wheels numpy jinja2 cffi
    cp build-python/first/*manylinux*.whl test_files/standard_z_off.png build-python/wheels
    $root cp -r build-python/wheels "$bare/wheels"
    in_chroot "$bare" '
        if command -v cc gcc clang ld || ls /usr/lib/*/libpng* 2>/dev/null; then exit 1; fi
        python3 -m venv /venv
        /venv/bin/pip install -q --no-index --find-links /wheels normaltexture
        cd /wheels
        /venv/bin/ntp --version
        /venv/bin/python -c "import normaltexture as nt; print(nt.__version__, nt.codecs)"
        /venv/bin/ntp clean standard_z_off.png -o clean.png
        /venv/bin/ntp report clean.png -o clean.html'
}

wheel() {
    need_root wheel || return 0
    need_tools
    want mmdebstrap has mmdebstrap
    install_missing
    enter_python_venv
    stage "two builds are equal" wheel_twice
    finish_stages
    stage "in a Debian without compilers" wheel_bare
    finish_stages
}

enter_python_venv() { # from here on `python` has the package's tools
    need_python_tools
    need_python_venv
    PATH=$top/.venv-python/bin:$PATH
    unset NTP_PROGRAM NTP_BUILD
    rm -rf build-python/dist
    mkdir -p build-python/dist
}

install_wheel() {
    python -m pip --disable-pip-version-check install -q --no-deps --force-reinstall "$@"
}

install_tree() { # the package of this tree as it is
    enter_python_venv
    wheel_of . --config-settings=build-dir=build-python/tree
    install_wheel build-python/dist/*.whl
}

python_package() {
    need_tools
    if [ "${1:-}" = --tree ]; then
        install_tree
        stage "tests of the package" python_tests
    else
        enter_python_venv
        [ -z "$(git status --porcelain bindings libntp io cli meson.build)" ] ||
            say "not committed, so not in the sdist: $(git status --porcelain | wc -l) files"
        stage "sdist and wheel" python_build
        finish_stages
        stage "manylinux wheel, audit" python_repair
        finish_stages
        install_wheel build-python/repaired/*.whl
        stage "tests of the package" python_tests
        stage "mypy and pyright" python_types
        stage "clean environment" python_clean_install
    fi
    finish_stages
}

docs_site() { # without the network: what it takes is in .venv-python
    NO_MKDOCS_2_WARNING=1 quietly build-python/mkdocs.log python -m mkdocs build -q
    say "build-python/site: $(find build-python/site -name '*.html' | wc -l) pages"
}

docs_examples() {
    PYTHONPATH=bindings/python/tests python -m pytest -q -p no:cacheprovider -c /dev/null \
        --rootdir docs -p pysupport.doctest_place --doctest-glob='*.md' docs/tutorial-pipelines.md
}

docs() { # docs [--installed]
    need_tools
    need_page_tools
    build_main
    if [ "${1:-}" = --installed ]; then enter_python_venv; else install_tree; fi
    stage "programs in the pages" python docs/check_c.py build
    stage "Python in the pages" docs_examples
    stage "site" docs_site
    stage "page for browsers" page_for_site
    finish_stages
}
