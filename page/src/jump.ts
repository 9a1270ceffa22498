// SPDX-License-Identifier: MIT
// The half of setjmp and longjmp that WebAssembly cannot do itself; module/jump.c is the other.

interface Jumping {
  __stack_pointer: WebAssembly.Global;
  __indirect_function_table: WebAssembly.Table;
}

const JUMP = Symbol("longjmp");

/** What a module with jumps imports from "env": throwJump, and one invoke_ function for each form of
 * call.  `exportsOf` gives the exports of its instance, which is made later. */
export function jumpImports(module: WebAssembly.Module, exportsOf: () => Jumping) {
  const imports: Record<string, (...values: number[]) => unknown> = {
    throwJump() {
      throw JUMP;
    },
  };
  for (const { module: from, name } of WebAssembly.Module.imports(module))
    if (from === "env" && name.startsWith("invoke_"))
      imports[name] = (index, ...values) => {
        const { __stack_pointer: stack, __indirect_function_table: table } = exportsOf();
        const top = stack.value;
        try {
          return table.get(index)(...values);
        } catch (thrown) {
          if (thrown !== JUMP) throw thrown;
          stack.value = top;
          return 0;
        }
      };
  return imports;
}
