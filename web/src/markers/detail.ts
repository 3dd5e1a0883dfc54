import type { Actions } from '../app/actions.ts';
import type { Studio } from '../app/studio.ts';
import type { Pair, Point } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { fill, h, uniqueId } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import { readableIn } from '../ui/words.ts';
import { needOf, pairTitle } from './order.ts';

/** The selected pair: its name, its points, and what can be done with it. Its height never changes. */
export function pairDetail(studio: Studio, actions: Actions): HTMLElement {
  const id = uniqueId('name');
  const name = h('input', {
    id,
    type: 'text',
    maxlength: 120,
    spellcheck: 'false',
    onchange: () => actions.rename(name.value),
    onkeydown: (event: KeyboardEvent) => {
      if (event.key === 'Enter') name.blur();
    },
  });
  actions.nameField = name;
  const facts = h('dl', { class: 'facts' });
  const problem = h('p', { class: 'problem', role: 'status' });
  const none = h('p', { class: 'muted' }, 'No pair is selected. A click on a mesh begins a new one.');
  const present = () => studio.markers.pairs.value.find((pair) => pair.id === studio.selected.value) ?? null;
  const body = h(
    'div',
    { class: 'detail-body' },
    h('div', { class: 'field-row' }, h('label', { for: id }, 'Name'), name),
    facts,
    problem,
    h(
      'div',
      { class: 'row actions' },
      button({
        label: 'Confirm',
        keys: 'C',
        icon: 'check',
        run: () => actions.confirm(),
        disabled: () => {
          const pair = present();
          return !pair || pair.status === 'confirmed' || needOf(pair) === 'partner';
        },
      }),
      button({
        label: 'Skip',
        title: 'Leave the pair out of the transfer, and keep its points (S)',
        keys: 'S',
        icon: 'skip',
        run: () => actions.skip(),
        pressed: () => present()?.status === 'skipped',
      }),
      button({
        label: 'Fly there',
        keys: 'F',
        icon: 'eye',
        bare: true,
        run: () => actions.flyTo(studio.selected.peek()),
      }),
      button({ label: 'Delete', keys: 'Del', icon: 'trash', bare: true, kind: 'danger', run: () => actions.remove() }),
    ),
  );
  const element = h('section', { class: 'detail', 'aria-label': 'Selected pair' }, none, body);
  effect(() => {
    const pair = present();
    none.hidden = pair !== null;
    body.hidden = pair === null;
    if (!pair) return;
    if (document.activeElement !== name) name.value = pair.name === null ? '' : pairTitle(pair);
    name.placeholder = pairTitle(pair);
    fill(facts, ...factsOf(pair));
    const found = studio.markers.document.value.problems.find((other) => other.pair === pair.id);
    problem.textContent = found ? readableIn([found.message, found.hint].filter(Boolean).join('. ')) : '';
    problem.title = problem.textContent;
  });
  return element;
}

function factsOf(pair: Pair): Node[] {
  return [
    h('dt', {}, 'Source'),
    h('dd', {}, describePoint(pair.source)),
    h('dt', {}, 'Target'),
    h('dd', {}, describePoint(pair.target)),
  ];
}

function describePoint(point: Point | null): string {
  if (!point) return 'click it in its view';
  return 'vertex' in point ? `vertex ${point.vertex}` : `on triangle ${point.triangle}`;
}
