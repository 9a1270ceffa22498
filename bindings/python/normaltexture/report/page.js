// SPDX-License-Identifier: MIT
// Sorting, finding, and the sliders.  Without it the page is complete, only still.
"use strict";
(() => {
  const table = document.getElementById("table");
  const body = table.tBodies[0];
  const rows = Array.from(body.rows);
  const original = new Map(rows.map((row, i) => [row, i]));

  // ---- sorting: a button in each heading; ties keep the order of the report
  const value = (row, column) => {
    const cell = row.cells[column];
    return cell ? cell.dataset.sort || "" : "";
  };
  const order = (a, b) => {
    if (a === "" || b === "") return (a === "") - (b === "");
    const x = Number(a), y = Number(b);
    if (!Number.isNaN(x) && !Number.isNaN(y)) return x - y;
    return a.localeCompare(b, "en", { numeric: true });
  };
  const sort = (heading, direction) => {
    const column = heading.cellIndex;
    for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
    rows.sort((a, b) =>
      direction * order(value(a, column), value(b, column)) || original.get(a) - original.get(b));
    body.append(...rows);
  };
  for (const heading of table.tHead.rows[0].cells) {
    if (!heading.dataset.key) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = heading.textContent;
    heading.replaceChildren(button);
    const worstFirst = ["state", "failing", "angle", "size"].includes(heading.dataset.key);
    button.addEventListener("click", () => {
      const now = heading.getAttribute("aria-sort");
      const first = worstFirst ? -1 : 1;
      sort(heading, now === null ? first : now === "ascending" ? -1 : 1);
    });
  }

  // ---- finding: rows and cards together
  const tools = document.querySelector(".tools");
  const find = document.getElementById("find");
  const boxes = Array.from(tools.querySelectorAll("[data-state]"));
  const show = () => {
    const words = find.value.toLowerCase().split(/\s+/).filter(Boolean);
    const states = new Set(boxes.filter((box) => box.checked).map((box) => box.dataset.state));
    let shown = 0;
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      const fits = states.has(row.dataset.state) && words.every((word) => text.includes(word));
      row.hidden = !fits;
      document.getElementById(row.dataset.card).hidden = !fits;
      shown += fits;
    }
    document.getElementById("none").hidden = shown > 0;
    document.getElementById("count").textContent =
      shown === rows.length ? "" : `${shown} of ${rows.length}`;
  };
  tools.hidden = rows.length < 2;
  find.addEventListener("input", show);
  for (const box of boxes) box.addEventListener("change", show);
  find.value = "";
  for (const box of boxes) box.checked = true;

  // ---- sliders, and their switch between texture and lit surface
  for (const figure of document.querySelectorAll(".slider")) {
    const compare = figure.querySelector(".compare");
    const range = compare.querySelector("input");
    const move = () => compare.style.setProperty("--cut", `${range.value}%`);
    range.addEventListener("input", move);
    move();
    const swap = figure.querySelector(".swap");
    const before = compare.querySelector(".before");
    const after = compare.querySelector(".after");
    const lit = figure.closest(".card").querySelectorAll(".figures > figure > img")[2];
    const pictures = [[before.src, after.src], [lit.src, after.dataset.lit]];
    swap.hidden = false;
    swap.addEventListener("click", () => {
      const pressed = swap.getAttribute("aria-pressed") !== "true";
      swap.setAttribute("aria-pressed", String(pressed));
      [before.src, after.src] = pictures[Number(pressed)];
    });
  }
})();
