# SPDX-License-Identifier: MIT
# ./dev page: one HTML file that checks and repairs textures in a browser, and its tests.

need_page_tools() {
    want clang has clang
    want llvm has llvm-ar
    want zopfli has zopfli
    want binaryen has wasm-opt
    want nodejs has node
    want npm has npm
    install_missing
    want lld links_wasm
    want wasi-libc links_wasm
    want libclang-rt-dev-wasm32 links_wasm
    install_missing
}

page_packages() { (cd page && patiently npm ci --no-audit --no-fund --ignore-scripts --loglevel=error >/dev/null); }

page_module() {
    fetch_sources
    # libdeflate would only make checksums a little faster, for eight kilobytes.
    if [ ! -f build-page/build.ninja ]; then
        quietly build-sources/page.log meson setup build-page --wrap-mode=nodownload \
            --cross-file packaging/cross/wasm32-wasi.ini -Dgegl=disabled -Dgimp=disabled \
            -Dzstd=disabled -Dwebp=disabled -Dexr=disabled -Ddebug=false -Doptimization=s \
            -Dlibdeflate=disabled -Dtests=false -Ddefault_library=static
    fi
    quietly build-sources/page.log ninja -C build-page -j "$jobs" page/page
}

page_for_site() {
    page_packages
    page_module
    page_build
    cp build-page/normals-texture.html build-python/site/
}

page_types() { (cd page && node_modules/.bin/tsc -p .); }

page_build() { (cd page && node build.mjs ../build-page/page/page ../build-page/normals-texture.html); }

page_tests() { # page_tests BROWSER
    PAGE=$top/build-page/normals-texture.html NTP=$top/build/cli/ntp TEXTURES=$top/test_files BROWSER=$1 \
        CORPUS=${NTP_CORPUS:-$top/../shared/corpus} node --test --test-reporter=spec page/tests/page.test.mjs
}

# The pictures of docs/page.md, of few colors so that they are small.
page_pictures() {
    (cd page && node pictures.mjs ../build-page/normals-texture.html ../test_files ../docs/images)
    python - docs/images/page.png docs/images/page-phone.png <<'END'
import sys
from PIL import Image

for path in sys.argv[1:]:
    Image.open(path).convert("RGB").quantize(128).save(path, optimize=True)
END
}

need_browsers() {
    want chromium has chromium
    want firefox-esr has firefox-esr
    install_missing
}

page() { # page [--build | --pictures]
    need_tools
    need_page_tools
    [ "${1:-}" = --build ] || need_browsers
    build_main
    stage "packages of npm" page_packages
    stage "WebAssembly module" page_module
    finish_stages
    stage "types" page_types
    stage "page" page_build
    finish_stages
    [ "${1:-}" != --pictures ] || stage "pictures" page_pictures
    [ -n "${1:-}" ] || for page_browser in chromium firefox; do
        stage "the page in $page_browser" page_tests "$page_browser"
    done
    finish_stages
}
