"use strict";
(function () {
  const said = document.getElementById("said");

  // Files opened from a disk may have no clipboard: then the old way, and if that fails the text is marked.
  function copyOld(code) {
    const range = document.createRange(), selection = window.getSelection();
    range.selectNodeContents(code);
    selection.removeAllRanges();
    selection.addRange(range);
    return document.execCommand("copy");
  }

  async function copy(button) {
    const part = button.parentElement, code = part.querySelector("code");
    let done = false;
    try {
      await navigator.clipboard.writeText(code.textContent);
      done = true;
    } catch (error) {
      done = copyOld(code);
    }
    const name = part.querySelector("h3").textContent;
    said.textContent = done ? `${name}: copied` : `${name}: marked, press Ctrl+C`;
    button.focus();
  }

  for (const button of document.querySelectorAll(".copy")) button.hidden = false;
  document.addEventListener("click", (event) => {
    const button = event.target.closest(".copy");
    if (button) copy(button);
  });

  const keys = { n: "next", p: "prev", u: "up" };
  document.addEventListener("keydown", (event) => {
    const link = keys[event.key] && document.querySelector(`a[rel=${keys[event.key]}]`);
    if (link && !event.ctrlKey && !event.altKey && !event.metaKey) link.click();
  });
})();
