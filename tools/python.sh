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
        --rootdir "$site" -p pysupport.doctest_place --doctest-modules "$site"
}

python_clean_install() { # with nothing but what the wheel's metadata asks for
    rm -rf build-python/clean
    python -m venv build-python/clean
    pip_install build-python/clean/bin/python build-python/repaired/*.whl
    (cd build-python && clean/bin/python -c 'import normaltexture as nt; print(nt.codecs)')
    build-python/clean/bin/ntp check --fail-on never test_files/standard_z_off.png
    build-python/clean/bin/ntp report test_files/standard.png -o build-python/report.html
    build-python/clean/bin/ntp help gltf >/dev/null
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
