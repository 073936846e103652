// Keys: what each does, and the list of them that the page shows.

export interface Key {
  /** Names of `KeyboardEvent.key`, letters in lower case. */
  keys: readonly string[];
  /** As people read them. */
  shown: readonly string[];
  says: string;
  /** Whether the shift key was down. */
  does: (shift: boolean, key: string) => void;
}

/** Obey keys wherever the focus is, but for those that a control with the focus knows itself. */
export function listen(table: readonly Key[]): void {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const focused = event.target instanceof HTMLElement ? event.target : document.body;
    const knowsArrows = focused.matches("select") || (focused.matches("input") && !event.shiftKey);
    if (knowsArrows && /^(Arrow|Home|End)/.test(event.key)) return;
    if (focused.matches("select") && event.key.length === 1) return;
    if (focused.matches("button, summary") && (event.key === " " || event.key === "Enter")) return;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const found = table.find(({ keys }) => keys.includes(name));
    if (found === undefined) return;
    event.preventDefault();
    found.does(event.shiftKey, name);
  });
}

/** Fill a list with keys and what they do. */
export function list(table: readonly Key[], into: HTMLElement): void {
  into.replaceChildren(
    ...table.map(({ shown, says }) => {
      const item = document.createElement("li");
      for (const name of shown) {
        const key = document.createElement("kbd");
        key.textContent = name;
        item.append(key, " ");
      }
      item.append(says);
      return item;
    }),
  );
}
