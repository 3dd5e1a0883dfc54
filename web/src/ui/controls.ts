import { h, uniqueId } from './dom.ts';
import { type IconName, icon } from './icons.ts';
import { effect } from './signal.ts';

interface ButtonOptions {
  label: string;
  /** The tooltip, where the label does not say enough. */
  title?: string;
  /** The key that does the same, for the tooltip. */
  keys?: string;
  icon?: IconName;
  /** Only the icon is seen; the label is its name. */
  bare?: boolean;
  kind?: 'primary' | 'plain' | 'danger';
  run: () => void;
  pressed?: () => boolean;
  disabled?: () => boolean;
}

export function button(options: ButtonOptions): HTMLButtonElement {
  const title = options.title ?? (options.keys ? `${options.label} (${options.keys})` : options.label);
  const element = h(
    'button',
    {
      type: 'button',
      class: `button ${options.kind ?? 'plain'}${options.bare ? ' bare' : ''}`,
      title: options.title || options.bare || options.keys ? title : null,
      'aria-label': options.bare ? options.label : null,
      onclick: options.run,
    },
    options.icon ? icon(options.icon) : null,
    options.bare ? null : options.label,
  );
  const { pressed, disabled } = options;
  if (pressed) effect(() => element.setAttribute('aria-pressed', String(pressed())));
  if (disabled) {
    effect(() => {
      element.disabled = disabled();
    });
  }
  return element;
}

interface SelectOptions<T extends string> {
  label: string;
  options: () => { value: T; label: string }[];
  value: () => T;
  change: (value: T) => void;
  /** The label is read by screen readers only. */
  quiet?: boolean;
}

export function select<T extends string>(options: SelectOptions<T>): HTMLElement {
  const id = uniqueId('select');
  const element = h('select', { id, onchange: () => options.change(element.value as T) });
  effect(() => {
    element.replaceChildren(...options.options().map(({ value, label }) => h('option', { value }, label)));
    element.value = options.value();
  });
  return h(
    'span',
    { class: 'field-inline' },
    h('label', { for: id, class: options.quiet ? 'visually-hidden' : null }, options.label),
    element,
  );
}

export function searchField(label: string, change: (text: string) => void): HTMLElement {
  const input = h('input', {
    type: 'search',
    placeholder: label,
    'aria-label': label,
    spellcheck: 'false',
    oninput: () => change(input.value),
  });
  return h('div', { class: 'search' }, icon('search'), input);
}

/** A share from 0 to 1, or null while it is not known. */
export function progressBar(label: string, share: () => number | null): HTMLElement {
  const bar = h('div', { class: 'progress-bar' });
  const element = h(
    'div',
    { class: 'progress', role: 'progressbar', 'aria-label': label, 'aria-valuemin': 0, 'aria-valuemax': 100 },
    bar,
  );
  effect(() => {
    const value = share();
    element.classList.toggle('unknown', value === null);
    if (value === null) element.removeAttribute('aria-valuenow');
    else element.setAttribute('aria-valuenow', String(Math.round(value * 100)));
    bar.style.transform = value === null ? '' : `scaleX(${value})`;
  });
  return element;
}

/** A list that was chosen from by mouse gives the focus back, so that the keys of the page work again; by keyboard it keeps it. */
export function releaseLists(page: Document): void {
  let byMouse: EventTarget | null = null;
  page.addEventListener('pointerdown', ({ target }) => {
    byMouse = target;
  });
  page.addEventListener('keydown', () => {
    byMouse = null;
  });
  page.addEventListener('change', ({ target }) => {
    if (target instanceof HTMLSelectElement && target === byMouse) target.blur();
  });
}
