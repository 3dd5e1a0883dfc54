import type { Studio } from '../app/studio.ts';
import { button, searchField } from '../ui/controls.ts';
import { fill, h, uniqueId } from '../ui/dom.ts';
import { effect, signal } from '../ui/signal.ts';

/** A slider for each shape; the sum of all is shown. */
export function shapeSliders(studio: Studio): HTMLElement {
  const search = signal('');
  const list = h('div', { class: 'sliders' });
  const element = h(
    'section',
    { class: 'block', 'aria-label': 'Shapes' },
    h(
      'div',
      { class: 'row' },
      h('h3', {}, 'Shapes'),
      button({ label: 'All to rest', run: () => set(studio, new Map()) }),
    ),
    searchField('Search shapes', (text) => {
      search.value = text.toLowerCase();
    }),
    list,
  );
  effect(() => {
    const poses = studio.session.value?.poses;
    element.hidden = poses?.are !== 'shapes';
    if (poses?.are !== 'shapes') return;
    const rows = poses.list
      .map((pose, index) => ({ pose, index }))
      .filter(({ pose }) => pose.name.toLowerCase().includes(search.value))
      .map(({ pose, index }) => slider(studio, pose.name, index));
    fill(list, ...rows);
  });
  return element;
}

function slider(studio: Studio, name: string, index: number): HTMLElement {
  const id = uniqueId('shape');
  const number = h('output', { for: id });
  const input = h('input', {
    id,
    type: 'range',
    min: 0,
    max: 1,
    step: 0.01,
    oninput: () => set(studio, weights(studio).set(index, Number(input.value))),
  });
  effect(() => {
    const pose = studio.live.pose.value;
    const value = pose && 'blend' in pose ? (pose.blend.find(([other]) => other === index)?.[1] ?? 0) : 0;
    if (document.activeElement !== input) input.value = String(value);
    number.textContent = value.toFixed(2);
  });
  return h('div', { class: 'slider' }, h('label', { for: id, title: name }, name), input, number);
}

function weights(studio: Studio): Map<number, number> {
  const pose = studio.live.pose.peek();
  return new Map(pose && 'blend' in pose ? pose.blend : []);
}

function set(studio: Studio, values: Map<number, number>): void {
  const blend = [...values].filter(([, weight]) => weight !== 0);
  studio.live.pose.value = blend.length > 0 ? { blend } : null;
}
