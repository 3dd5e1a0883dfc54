import type { Actions } from '../app/actions.ts';
import type { Studio } from '../app/studio.ts';
import type { Pair } from '../protocol/types.ts';
import { whatRunDoes } from '../stages/run.ts';
import { button, progressBar, searchField, select } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect } from '../ui/signal.ts';
import { pairColour } from './colours.ts';
import { needOf, pairTitle, percentOf } from './order.ts';

/** The list of pairs, with what is to be done about them. */
export function pairList(studio: Studio, actions: Actions): HTMLElement {
  const list = h('ul', { class: 'pairs', 'aria-label': 'Pairs' });
  const rows = new Map<number, Row>();
  effect(() => {
    const shown = actions.listed.value;
    const kept = shown.map((pair) => {
      const row = rows.get(pair.id) ?? new Row(studio, actions, pair.id);
      rows.set(pair.id, row);
      row.update(pair);
      return row.element;
    });
    const ids = new Set(shown.map((pair) => pair.id));
    for (const id of [...rows.keys()]) if (!ids.has(id)) rows.delete(id);
    if (kept.length === 0) fill(list, emptyRow(studio));
    else if (!same(list, kept)) list.replaceChildren(...kept);
  });
  effect(() => {
    const [selected, hovered] = [studio.selected.value, studio.hovered.value];
    void actions.listed.value;
    for (const [id, row] of rows) row.mark(id === selected, id === hovered);
  });
  // Only a new choice scrolls: a hand over the list would lose its place.
  let shown: number | null = null;
  effect(() => {
    const selected = studio.selected.value;
    void actions.listed.value;
    if (selected === shown || (selected !== null && !rows.has(selected))) return;
    shown = selected;
    if (selected !== null) rows.get(selected)?.element.scrollIntoView({ block: 'nearest' });
  });
  return h('div', { class: 'panel-page points' }, head(studio, actions), tools(actions), list);
}

/** Rows are moved only if their order has changed, so that the focus stays. */
function same(list: Element, rows: Element[]): boolean {
  return list.children.length === rows.length && rows.every((row, i) => list.children[i] === row);
}

function head(studio: Studio, actions: Actions): HTMLElement {
  const count = h('p', { class: 'count' });
  const share = () => {
    const pairs = studio.markers.pairs.value.filter((pair) => pair.status !== 'skipped');
    const checked = pairs.filter((pair) => needOf(pair) === 'none').length;
    return { checked, all: pairs.length };
  };
  effect(() => {
    const { checked, all } = share();
    count.textContent = all === 0 ? 'No pairs yet' : `${checked} of ${all} pairs checked`;
  });
  const next = button({ label: 'Next', keys: 'G', icon: 'target', kind: 'primary', run: () => void actions.next() });
  const run = button({
    label: 'Run',
    kind: 'primary',
    icon: 'play',
    run: () => void studio.run(),
    disabled: () => studio.jobs.value.some((job) => job.state === 'running'),
  });
  const done = h('p', { class: 'hint all-checked', role: 'status' });
  effect(() => {
    const { checked, all } = share();
    const isDone = all > 0 && checked === all;
    run.title = whatRunDoes(studio);
    next.hidden = isDone;
    run.hidden = !isDone;
    done.textContent = isDone ? 'All pairs are checked. Run writes the result.' : '';
  });
  return h(
    'div',
    { class: 'points-head' },
    h('div', { class: 'row' }, count, next, run),
    done,
    progressBar('Pairs checked', () => {
      const { checked, all } = share();
      return all === 0 ? 0 : checked / all;
    }),
  );
}

function tools(actions: Actions): HTMLElement {
  return h(
    'div',
    { class: 'points-tools' },
    h(
      'div',
      { class: 'row' },
      button({ label: 'New', keys: 'N', icon: 'plus', run: () => actions.startNew() }),
      button({ label: 'Mirror', keys: 'M', icon: 'mirror', run: () => actions.mirror() }),
      button({
        label: 'Propose',
        title:
          'Finds pairs by the shapes of both meshes. Pairs that are only proposed are replaced; checked ones stay.',
        icon: 'search',
        run: () => actions.propose(),
      }),
    ),
    h(
      'div',
      { class: 'row' },
      searchField('Search pairs', (text) => {
        actions.search.value = text;
      }),
      select({
        label: 'Order',
        quiet: true,
        options: () => [
          { value: 'doubtful', label: 'Doubtful first' },
          { value: 'number', label: 'By number' },
        ],
        value: () => actions.order.value,
        change: (value) => {
          actions.order.value = value;
        },
      }),
    ),
  );
}

function emptyRow(studio: Studio): HTMLElement {
  return h('li', { class: 'empty' }, emptyText(studio));
}

function emptyText(studio: Studio): string {
  if (studio.markers.pairs.value.length > 0) return 'No pair matches the search.';
  const proposing = studio.jobs.value.some((job) => job.kind === 'propose' && job.state === 'running');
  return proposing
    ? 'Pairs are being found by the shapes of both meshes …'
    : 'Click a place on the source, then the same place on the target. “Propose” finds pairs by shape.';
}

class Row {
  readonly element: HTMLElement;
  private readonly main: HTMLButtonElement;
  private readonly badge = h('span', { class: 'badge' });
  private readonly name = h('span', { class: 'name' });
  private readonly state = h('span', { class: 'state' });
  private readonly meter = h('span', { class: 'meter' });

  constructor(studio: Studio, actions: Actions, id: number) {
    this.main = h(
      'button',
      {
        type: 'button',
        class: 'pair',
        onclick: () => {
          studio.selected.value = id;
          actions.flyTo(id);
        },
        onpointerenter: () => {
          studio.hovered.value = id;
        },
        onpointerleave: () => {
          studio.hovered.value = null;
        },
      },
      this.badge,
      this.name,
      this.state,
      this.meter,
    );
    this.element = h('li', {}, this.main);
  }

  update(pair: Pair): void {
    const need = needOf(pair);
    this.main.dataset.need = pair.status === 'skipped' ? 'skipped' : need;
    this.main.dataset.pair = String(pair.id);
    this.badge.textContent = String(pair.number);
    this.badge.style.setProperty('--pair', pairColour(pair.colour));
    this.badge.classList.toggle('hollow', pair.status === 'proposed');
    this.name.textContent = pairTitle(pair);
    fill(this.state, ...stateOf(pair));
    this.state.title =
      pair.status === 'proposed'
        ? 'How alike the shapes around both points are. An unsure pair may well be right: look.'
        : '';
    const sure = pair.status === 'proposed' ? (pair.confidence ?? 0) : null;
    this.meter.hidden = sure === null;
    if (sure !== null) this.meter.style.setProperty('--share', String(sure));
  }

  mark(selected: boolean, hovered: boolean): void {
    this.main.setAttribute('aria-current', String(selected));
    this.main.classList.toggle('hovered', hovered);
  }
}

function stateOf(pair: Pair): (Node | string)[] {
  if (pair.status === 'skipped') return ['Skipped'];
  const need = needOf(pair);
  if (need === 'partner') return [pair.source ? 'No target point' : 'No source point'];
  if (need === 'none') return [icon('check'), 'Checked'];
  const percent = pair.confidence === null ? 'Proposed' : `${percentOf(pair)} % sure`;
  return [percent];
}
