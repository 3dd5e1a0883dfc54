/** Makes elements. Texts always become text nodes, so names from files can never become markup. */

type Child = Node | string | number | null | undefined | false;
type Listener = (event: never) => void;
type Properties = Record<string, string | number | boolean | null | undefined | Listener>;

/**
 * An element. `on…` adds a listener, `class` and attributes are set as such; `true` is an empty attribute, and `false`, null or
 * undefined leave it out.
 */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  assign(element, properties);
  append(element, children);
  return element;
}

export function append(parent: Node, children: Child[]): void {
  for (const child of children) {
    if (child === null || child === undefined || child === false) continue;
    parent.appendChild(child instanceof Node ? child : document.createTextNode(String(child)));
  }
}

function assign(element: Element, properties: Properties): void {
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined) continue;
    // States for screen readers are words; other attributes are there or not.
    if (name.startsWith('aria-')) {
      element.setAttribute(name, String(value));
      continue;
    }
    if (value === false) continue;
    if (typeof value === 'function') {
      element.addEventListener(name.slice(2).toLowerCase(), value as unknown as EventListener);
    } else {
      element.setAttribute(name, value === true ? '' : String(value));
    }
  }
}

/** Replaces the children of an element. */
export function fill(parent: Element, ...children: Child[]): void {
  parent.replaceChildren();
  append(parent, children);
}

let count = 0;

/** An id for `for`, `aria-labelledby` and the like. */
export function uniqueId(stem: string): string {
  count += 1;
  return `${stem}-${count}`;
}
