import type { Studio } from '../app/studio.ts';
import type { Mask, Side } from '../protocol/types.ts';
import { button, select } from '../ui/controls.ts';
import { fill, h, uniqueId } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect, type Signal } from '../ui/signal.ts';
import { maskNameProblem } from './mask.ts';
import type { Painter, PaintKind } from './painter.ts';

/** Painting of weights and choice of components, and what is saved. */
export function paintPanel(studio: Studio, painter: Painter): HTMLElement {
  const brush = h(
    'section',
    { class: 'block', 'aria-label': 'Brush' },
    h('p', { class: 'hint' }, 'Drag over the mesh to paint. Alt and drag turns the view.'),
    range('Radius', painter.radius, 0.01, 0.3, (value) => `${(value * 100).toFixed(0)} % of the diagonal`),
    range('Strength', painter.strength, 0.05, 1, (value) => `${(value * 100).toFixed(0)} %`),
    h(
      'div',
      { class: 'row' },
      button({
        label: 'Paint',
        icon: 'brush',
        pressed: () => !painter.erases.value,
        run: () => setErase(painter, false),
      }),
      button({
        label: 'Erase',
        icon: 'close',
        pressed: () => painter.erases.value,
        run: () => setErase(painter, true),
      }),
    ),
    h(
      'div',
      { class: 'row' },
      button({ label: 'Fill', run: () => painter.change(() => 1) }),
      button({ label: 'Empty', run: () => painter.change(() => 0) }),
      button({ label: 'Invert', run: () => painter.change((weight) => 1 - weight) }),
    ),
  );
  const components = h('section', { class: 'block', 'aria-label': 'Chosen components' });
  effect(() => {
    brush.hidden = painter.kind.value !== 'weights';
    components.hidden = !brush.hidden;
    fill(
      components,
      h('p', { class: 'hint' }, 'Click components on the mesh. They can be named where a stage takes rigid parts.'),
      ...(painter.components.value.size === 0
        ? [h('p', { class: 'muted' }, 'None is chosen yet.')]
        : [h('ul', { class: 'chips' }, ...[...painter.components.value].map((name) => h('li', {}, name)))]),
    );
  });
  return h(
    'div',
    { class: 'panel-page paint' },
    whatToPaint(studio, painter),
    brush,
    components,
    saving(painter),
    savedMasks(painter),
  );
}

function whatToPaint(studio: Studio, painter: Painter): HTMLElement {
  return h(
    'section',
    { class: 'block', 'aria-label': 'What to paint' },
    select<PaintKind>({
      label: 'Kind',
      options: () => [
        { value: 'weights', label: 'Weights of vertices' },
        { value: 'components', label: 'Rigid components' },
      ],
      value: () => painter.kind.value,
      change: (value) => {
        painter.kind.value = value;
      },
    }),
    select<Side>({
      label: 'Mesh',
      options: () => [
        { value: 'source', label: `Source, ${studio.session.value?.source?.file ?? 'generated'}` },
        { value: 'target', label: `Target, ${studio.session.value?.target?.file ?? 'generated'}` },
      ],
      value: () => painter.side.value,
      change: (value) => {
        painter.side.value = value;
      },
    }),
  );
}

function setErase(painter: Painter, erases: boolean): void {
  painter.erases.value = erases;
}

function range(
  label: string,
  value: Signal<number>,
  min: number,
  max: number,
  text: (value: number) => string,
): HTMLElement {
  const id = uniqueId('range');
  const output = h('output', { for: id, class: 'muted' });
  const input = h('input', {
    id,
    type: 'range',
    min,
    max,
    step: 0.01,
    value: value.peek(),
    oninput: () => {
      value.value = Number(input.value);
    },
  });
  effect(() => {
    output.textContent = text(value.value);
  });
  return h('div', { class: 'range' }, h('label', { for: id }, label), output, input);
}

function saving(painter: Painter): HTMLElement {
  const id = uniqueId('mask');
  const problem = h('p', { class: 'problem', role: 'status' });
  const name = h('input', { id, type: 'text', value: 'mask', spellcheck: 'false', maxlength: 64 });
  const state = h('span', { class: 'muted' });
  effect(() => {
    state.textContent = painter.unsaved.value ? 'not saved yet' : '';
  });
  return h(
    'section',
    { class: 'block', 'aria-label': 'Save' },
    h('div', { class: 'field-row' }, h('label', { for: id }, 'Name'), name),
    problem,
    h(
      'div',
      { class: 'row' },
      state,
      button({
        label: 'Save',
        kind: 'primary',
        run: () => {
          problem.textContent = maskNameProblem(name.value) ?? '';
          if (problem.textContent === '') void painter.save(name.value);
        },
      }),
    ),
  );
}

function savedMasks(painter: Painter): HTMLElement {
  const list = h('ul', { class: 'masks' });
  effect(() => {
    const { masks } = painter;
    fill(
      list,
      ...(masks.value.length === 0
        ? [h('li', { class: 'muted' }, 'Nothing is saved yet.')]
        : masks.value.map((mask) => row(painter, mask))),
    );
  });
  return h('section', { class: 'block', 'aria-label': 'Saved' }, h('h3', {}, 'Saved'), list);
}

function row(painter: Painter, mask: Mask): HTMLElement {
  return h(
    'li',
    {},
    h(
      'button',
      { type: 'button', class: 'link', title: mask.file, onclick: () => void painter.load(mask) },
      icon(mask.kind === 'weights' ? 'brush' : 'list'),
      `${mask.name} · ${mask.side}`,
    ),
    button({
      label: `Delete ${mask.name}`,
      icon: 'trash',
      bare: true,
      kind: 'danger',
      run: () => void painter.remove(mask),
    }),
  );
}
