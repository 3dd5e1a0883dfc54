import type { Studio } from '../app/studio.ts';
import type { OpenRequest, Side } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { noticeLine } from '../ui/noticeline.ts';
import { effect, signal } from '../ui/signal.ts';
import { fileBrowser } from './browser.ts';
import { type FileChoice, fileName } from './choice.ts';
import { dropArea } from './drop.ts';
import { recentProjects } from './recent.ts';

/** The choice of files: two meshes, or a pipeline. */
export function startPage(studio: Studio): HTMLElement {
  const { files } = studio;
  const { source, target } = files;
  const choose = (path: string) => files.choose(path);
  const refresh = signal(0);
  return h(
    'div',
    { class: 'start' },
    h(
      'div',
      { class: 'start-head' },
      h('h1', {}, 'Carry the poses of one mesh over to another'),
      h(
        'p',
        {},
        'Choose a source that moves and a target that should move like it. Or open a pipeline. ',
        'A click on a box chooses which one the next file fills.',
      ),
      noticeLine(),
    ),
    h(
      'div',
      { class: 'slots' },
      slot(files, 'source', 'the mesh with poses'),
      h('span', { class: 'swap' }, button({ label: 'Swap', icon: 'swap', bare: true, run: () => files.swap() })),
      slot(files, 'target', 'the mesh that takes them'),
      button({
        label: 'Open',
        kind: 'primary',
        icon: 'chevron',
        run: () => {
          const [from, to] = [source.peek(), target.peek()];
          if (from && to) void studio.open({ source: from, target: to });
        },
        disabled: () => source.value === null || target.value === null,
      }),
    ),
    sameFile(source, target),
    h(
      'div',
      { class: 'start-body' },
      fileBrowser({ refresh, mesh: choose, pipeline: (path) => void studio.open({ pipeline: path }) }),
      h(
        'div',
        { class: 'start-side' },
        dropArea((path) => {
          if (/\.ya?ml$/i.test(path)) void studio.open({ pipeline: path });
          else choose(path);
          refresh.value = refresh.peek() + 1;
        }),
        recent(studio),
        resume(studio),
      ),
    ),
  );
}

/** A mesh that takes its own poses is hardly meant. */
function sameFile(source: { value: string | null }, target: { value: string | null }): HTMLElement {
  const element = h('p', { class: 'doubt', role: 'alert' });
  effect(() => {
    const same = source.value !== null && source.value === target.value;
    element.hidden = !same;
    element.textContent = same ? 'Source and target are the same file. Clear one of them if that is a mistake.' : '';
  });
  return element;
}

/** The box of a side: a click makes it the one that the next file fills. */
function slot(files: FileChoice, side: Side, hint: string): HTMLElement {
  const title = side === 'source' ? 'Source' : 'Target';
  const path = files[side];
  const name = h('span', { class: 'slot-name' });
  const clear = button({
    label: `Clear ${title.toLowerCase()}`,
    icon: 'close',
    bare: true,
    run: () => files.clear(side),
  });
  const choice = h(
    'button',
    {
      type: 'button',
      class: 'slot-choice',
      onclick: () => {
        files.next.value = side;
      },
    },
    h('span', { class: 'slot-title' }, title),
    name,
  );
  const element = h('div', { class: 'slot', role: 'group', 'aria-label': title }, choice, clear);
  effect(() => {
    const isNext = files.next.value === side;
    element.classList.toggle('filled', path.value !== null);
    element.classList.toggle('next', isNext);
    choice.setAttribute('aria-pressed', String(isNext));
    choice.title = isNext ? 'The next file comes here' : `Click to choose another file for the ${side}`;
    name.textContent = path.value ? fileName(path.value) : hint;
    name.title = path.value ?? '';
    clear.hidden = path.value === null;
  });
  return element;
}

function recent(studio: Studio): HTMLElement {
  const list = recentProjects();
  return h(
    'section',
    { class: 'block', 'aria-label': 'Recent' },
    h('h2', {}, 'Recent'),
    list.length === 0 ? h('p', { class: 'muted' }, 'What you open is listed here.') : null,
    h(
      'ul',
      { class: 'recent' },
      ...list.map((what) =>
        h(
          'li',
          {},
          h(
            'button',
            { type: 'button', class: 'link', onclick: () => void studio.open(what) },
            icon('folder'),
            titleOf(what),
          ),
        ),
      ),
    ),
  );
}

function resume(studio: Studio): HTMLElement | null {
  if (!studio.canLeaveChoice()) return null;
  return button({
    label: `Back to ${studio.session.peek()?.name ?? 'the project'}`,
    keys: 'Esc',
    run: () => void studio.load(),
  });
}

function titleOf(what: OpenRequest): string {
  if ('pipeline' in what) return fileName(what.pipeline);
  return `${fileName(what.source)} → ${fileName(what.target)}`;
}
