import type { Studio } from '../app/studio.ts';
import { chooseShapes, hasShapes } from '../live/clips.ts';
import type { Mask, Side } from '../protocol/types.ts';
import { button, select } from '../ui/controls.ts';
import { openDialog } from '../ui/dialog.ts';
import { fill, h, uniqueId } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect, type Signal } from '../ui/signal.ts';
import type { PaintKind } from './draft.ts';
import { maskNameProblem, USUAL_NAMES } from './mask.ts';
import type { Painter } from './painter.ts';
import { useOf } from './use.ts';

/** Painting of weights and choice of components, and what is saved. */
export function paintPanel(studio: Studio, painter: Painter): HTMLElement {
  const brush = h(
    'section',
    { class: 'block', 'aria-label': 'Brush' },
    h(
      'p',
      {},
      'Weights say how much of a shape’s motion each vertex takes: all where it is painted, none where it is not. ',
      'A mask keeps, for instance, a blink away from the mouth.',
    ),
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
      button({ label: 'Fill', run: () => painter.change('the filling', () => 1) }),
      button({ label: 'Empty', run: () => painter.change('the emptying', () => 0) }),
      button({ label: 'Invert', run: () => painter.change('the inversion', (weight) => 1 - weight) }),
    ),
  );
  const components = h('section', { class: 'block', 'aria-label': 'Chosen components' });
  effect(() => {
    brush.hidden = painter.kind.value !== 'weights';
    components.hidden = !brush.hidden;
    fill(
      components,
      h(
        'p',
        {},
        'Rigid components move as one piece and keep their shape, such as eyeballs, teeth and buttons. ',
        'The transfer multi_component takes them.',
      ),
      h('p', { class: 'hint' }, 'Click components on the mesh.'),
      ...(painter.components.value.size === 0
        ? [h('p', { class: 'muted' }, 'None is chosen yet.')]
        : [h('ul', { class: 'chips' }, ...[...painter.components.value].map((name) => h('li', {}, name)))]),
    );
  });
  return h(
    'div',
    { class: 'panel-page paint' },
    whatToPaint(studio, painter),
    maskNote(studio, painter),
    brush,
    components,
    saving(studio, painter),
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

/** Masks that no pipeline can use are announced before somebody paints one, with the way out. */
function maskNote(studio: Studio, painter: Painter): HTMLElement {
  const element = h('div', { class: 'doubt block mask-note', role: 'status' });
  effect(() => {
    element.hidden = painter.kind.value !== 'weights' || painter.takesMasks.value;
    if (element.hidden) return;
    const clip = studio.session.value?.poses?.list.length ? 'Now a clip is played.' : 'This source has no poses.';
    fill(
      element,
      h('p', {}, `A pipeline uses masks only for shapes. ${clip}`),
      hasShapes(studio)
        ? h('p', {}, 'Choose “Shapes” beside the timeline before you use a mask. What is painted stays.')
        : h('p', {}, 'Open a source that has shapes to use a mask. You can paint and save one now.'),
      hasShapes(studio) ? button({ label: 'Choose Shapes', run: () => chooseShapes(studio) }) : null,
    );
  });
  return element;
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

function saving(studio: Studio, painter: Painter): HTMLElement {
  const id = uniqueId('mask');
  const problem = h('p', { class: 'problem', role: 'status' });
  const name = h('input', { id, type: 'text', spellcheck: 'false', maxlength: 60 });
  const state = h('span', { class: 'muted' });
  const use = h('div', { class: 'use' });
  const present = () => painter.saved.value;
  effect(() => {
    state.textContent = painter.unsaved.value ? 'not saved yet' : present() ? 'saved' : '';
  });
  // Each kind has a name of its own, so that one does not take the other's file. What a person has typed meanwhile stays when a
  // save of the other kind ends.
  let offered = '';
  effect(() => {
    const offer = present()?.name ?? USUAL_NAMES[painter.kind.value];
    if (offer === offered) return;
    offered = offer;
    name.value = offer;
  });
  effect(() => {
    const mask = present();
    fill(use, ...(mask ? useOf(studio, painter, mask) : []));
  });

  async function save(): Promise<void> {
    problem.textContent = maskNameProblem(name.value) ?? '';
    if (problem.textContent !== '') return;
    const given = name.value;
    if (await painter.save(given))
      askToReplace(`${given}.${painter.side.peek()}.mask.json`, () => painter.save(given, true));
  }

  return h(
    'section',
    { class: 'block', 'aria-label': 'Save' },
    h('div', { class: 'field-row' }, h('label', { for: id }, 'Name'), name),
    problem,
    h('div', { class: 'row' }, state, button({ label: 'Save', kind: 'primary', run: () => void save() })),
    use,
  );
}

function askToReplace(file: string, replace: () => Promise<unknown>): void {
  const dialog = openDialog('Replace the file?', [
    h('p', {}, `${file} is there already and holds another mask. Replacing it cannot be undone.`),
    h(
      'div',
      { class: 'row end' },
      button({ label: 'Keep it', run: () => dialog.close() }),
      button({
        label: 'Replace',
        kind: 'danger',
        run: () => {
          dialog.close();
          void replace();
        },
      }),
    ),
  ]);
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
