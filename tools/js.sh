# SPDX-License-Identifier: MIT
# ./dev js: libntp as a WebAssembly module, the npm package around it, and their tests.

js_compile() { # js_compile FILE: the kernels too are compiled once, with WebAssembly's own vectors
    clang --target=wasm32-wasi -msimd128 -O2 -std=c11 -ffp-contract=off -Wall -Wextra -Werror \
        -DNTP_BUILDING -DNTP_STATIC -DNTP_ISA=base '-DNTP_ISA_NAME="base"' \
        -Ilibntp/include -Ilibntp/src -c "$1" -o "build-js/$(echo "$1" | tr / _).o"
}

js_compile_share() { # js_compile_share N: every file whose number is N modulo the jobs
    js_number=0
    for js_file in bindings/js/*.c $(find libntp/src -name '*.c' ! -name '*_avx*.c' | sort); do
        [ $((js_number % jobs)) != "$1" ] || js_compile "$js_file"
        js_number=$((js_number + 1))
    done
}

js_build() {
    rm -rf build-js
    mkdir -p build-js
    js_waited=
    for js_share in $(seq 0 $((jobs - 1))); do
        js_compile_share "$js_share" &
        js_waited="$js_waited $!"
    done
    for js_process in $js_waited; do wait "$js_process"; done
    # The stack lies below all else, so that an overflow traps instead of overwriting data.
    clang --target=wasm32-wasi -nostartfiles -Wl,--no-entry -Wl,--strip-all -Wl,--gc-sections \
        -Wl,--stack-first -Wl,-z,stack-size=1048576 -Wl,--max-memory=4294967296 \
        -o bindings/js/libntp.wasm build-js/*.o
    say "bindings/js/libntp.wasm: $(wc -c <bindings/js/libntp.wasm) bytes," \
        "$(gzip -9 -c bindings/js/libntp.wasm | wc -c) gzipped"
}

js_types() {
    tsc --noEmit --strict --target es2022 --module node16 --moduleResolution node16 \
        bindings/js/tests/typed_use.ts
}

js_tests() { python -m pytest -q -p no:cacheprovider -c /dev/null bindings/js/tests; }

js_pack() { # what npm would publish, and a use of it from another directory
    cmp LICENSE bindings/js/LICENSE
    rm -rf build-js/user
    mkdir -p build-js/user/node_modules/normaltexture
    (cd bindings/js && npm pack --silent --pack-destination "$top/build-js" >/dev/null)
    tar -tzf build-js/normaltexture-*.tgz | sort
    tar -xzf build-js/normaltexture-*.tgz --strip-components=1 -C build-js/user/node_modules/normaltexture
    for js_file in $(python -c 'import json; print(*json.load(open("bindings/js/package.json"))["files"])'); do
        [ -f "build-js/user/node_modules/normaltexture/$js_file" ] || { say "not packed: $js_file"; return 1; }
    done
    (cd build-js/user && node --input-type=module -e '
        import { load } from "normaltexture";
        const picture = { data: new Uint8Array([200, 100, 10]), width: 1, height: 1 };
        const { data } = (await load()).clean(picture, { type: "standard" });
        if (String(data) !== "200,100,229") throw new Error(String(data));')
}

js() {
    need_tools
    need_js_tools
    build_main
    stage "WebAssembly module" js_build
    finish_stages
    stage "types" js_types
    stage "tests of the module" js_tests
    stage "package" js_pack
    finish_stages
}
