// Whether somebody looks at the page: it is seen, its window has the keyboard, and no dialog covers it.

export class Attention {
  constructor(changed) {
    this.changed = changed;
    this.looking = true;
    for (const name of ["visibilitychange", "focus", "blur"]) {
      (name === "visibilitychange" ? document : window).addEventListener(name, () => this.update());
    }
    for (const dialog of document.querySelectorAll("dialog")) dialog.addEventListener("close", () => this.update());
    this.update();
  }

  open(dialog) {
    if (!dialog.open) dialog.showModal();
    this.update();
  }

  close(...dialogs) {
    for (const dialog of dialogs) if (dialog.open) dialog.close();
    this.update();
  }

  update() {
    const looking = !document.hidden && document.hasFocus() && !document.querySelector("dialog[open]");
    if (looking === this.looking) return;
    this.looking = looking;
    this.changed();
  }
}
