// Parts of the page.

export function element(id: string): HTMLElement {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found;
}

export const input = (id: string): HTMLInputElement => element(id) as HTMLInputElement;
export const select = (id: string): HTMLSelectElement => element(id) as HTMLSelectElement;
