import type { Studio } from '../app/studio.ts';
import type { Component, Side } from '../protocol/types.ts';
import { button, searchField } from '../ui/controls.ts';
import { fill, h, uniqueId } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect, signal } from '../ui/signal.ts';

const MOST_ROWS = 300;

/** A button that opens the list of components of both meshes, to hide, isolate and search them. */
export function componentsButton(studio: Studio): HTMLElement {
  const id = uniqueId('components');
  const panel = h('div', { id, class: 'popover', popover: 'auto' });
  const opener = h(
    'button',
    { type: 'button', class: 'button plain', popovertarget: id, title: 'Hide, isolate and search components' },
    icon('list'),
    h('span', { class: 'button-text' }, 'Components'),
  );
  opener.setAttribute('aria-label', 'Components');
  const search = signal('');
  const side = signal<Side>('target');
  const list = h('ul', { class: 'components', 'aria-label': 'Components' });
  panel.append(
    h(
      'div',
      { class: 'row' },
      ...(['source', 'target'] as const).map((value) =>
        button({
          label: value === 'source' ? 'Source' : 'Target',
          pressed: () => side.value === value,
          run: () => {
            side.value = value;
          },
        }),
      ),
      button({ label: 'Show all', keys: 'U', run: () => showAll(studio) }),
    ),
    searchField('Search components', (text) => {
      search.value = text.toLowerCase();
    }),
    list,
  );
  effect(() => {
    const components = studio.session.value?.[side.value]?.components ?? [];
    const hidden = studio.hidden[side.value].value;
    const found = components
      .map((component, index) => ({ component, index }))
      .filter(({ component }) => component.name.toLowerCase().includes(search.value));
    const rows = found
      .slice(0, MOST_ROWS)
      .map(({ component, index }) => row(studio, side.value, component, index, hidden));
    const more = found.length - rows.length;
    fill(list, ...rows, more > 0 ? h('li', { class: 'muted' }, `${more} more: search for them`) : null);
  });
  return h('span', { class: 'components-menu' }, opener, panel);
}

function row(
  studio: Studio,
  side: Side,
  component: Component,
  index: number,
  hidden: ReadonlySet<number>,
): HTMLElement {
  const shown = !hidden.has(index);
  return h(
    'li',
    { class: shown ? '' : 'off' },
    h(
      'button',
      {
        type: 'button',
        class: 'button plain bare',
        'aria-label': `Show ${component.name}`,
        'aria-pressed': shown,
        onclick: () => toggleComponent(studio, side, index),
      },
      icon(shown ? 'eye' : 'hidden'),
    ),
    h('span', { class: 'component-name', title: component.name }, component.name),
    h('span', { class: 'muted' }, `${component.triangles.toLocaleString('en')} triangles`),
    h('button', { type: 'button', class: 'link', onclick: () => isolate(studio, side, index) }, 'Only this'),
  );
}

export function toggleComponent(studio: Studio, side: Side, index: number): void {
  const hidden = new Set(studio.hidden[side].peek());
  if (!hidden.delete(index)) hidden.add(index);
  studio.hidden[side].value = hidden;
}

export function isolate(studio: Studio, side: Side, index: number): void {
  const count = studio.session.peek()?.[side]?.components.length ?? 0;
  studio.hidden[side].value = new Set(Array.from({ length: count }, (_, i) => i).filter((i) => i !== index));
}

export function showAll(studio: Studio): void {
  studio.hidden.source.value = new Set();
  studio.hidden.target.value = new Set();
}
