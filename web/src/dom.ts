// Elements with text as text: nothing that a user has written is ever read as markup.

type Content = Node | string | null | undefined | false;

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  given: Partial<Record<string, string | boolean | ((event: Event) => void)>> = {},
  ...content: Content[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (typeof value === "string") element.setAttribute(name, value);
  }
  element.append(...content.filter((one): one is Node | string => one !== null && one !== undefined && one !== false));
  return element;
}

export function replace(parent: Element, ...content: Content[]): void {
  parent.replaceChildren(...content.filter((one): one is Node | string => one !== null && one !== undefined && one !== false));
}
