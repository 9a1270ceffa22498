// SPDX-License-Identifier: MIT
// A row of buttons of which one is chosen: Tab comes to that one, arrow keys choose among them.
const STEPS: Record<string, number> = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1, Home: -Infinity, End: Infinity };

/** Marks the chosen one by this attribute, as its role wants it. */
export function mark(row: HTMLElement, attribute: "aria-checked" | "aria-selected", chosen: Element) {
  for (const button of row.querySelectorAll("button")) {
    button.setAttribute(attribute, String(button === chosen));
    button.tabIndex = button === chosen ? 0 : -1;
  }
}

export function listenForArrows(row: HTMLElement) {
  row.addEventListener("keydown", (event) => {
    const buttons = [...row.querySelectorAll("button")];
    const at = buttons.indexOf(event.target as HTMLButtonElement);
    const step = STEPS[event.key];
    if (at < 0 || step === undefined) return;
    event.preventDefault();
    const to = Number.isFinite(step) ? (at + step + buttons.length) % buttons.length : step < 0 ? 0 : buttons.length - 1;
    buttons[to].focus();
    buttons[to].click();
  });
}
