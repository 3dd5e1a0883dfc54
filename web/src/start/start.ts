import type { Studio } from '../app/studio.ts';
import type { OpenRequest } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { noticeLine } from '../ui/notices.ts';
import { effect, signal } from '../ui/signal.ts';
import { fileBrowser } from './browser.ts';
import { dropArea } from './drop.ts';
import { recentProjects } from './recent.ts';

/** The choice of files: two meshes, or a pipeline. */
export function startPage(studio: Studio): HTMLElement {
  const source = signal<string | null>(null);
  const target = signal<string | null>(null);
  const choose = (path: string) => {
    if (source.peek() === null) source.value = path;
    else target.value = path;
  };
  const refresh = signal(0);
  return h(
    'div',
    { class: 'start' },
    h(
      'div',
      { class: 'start-head' },
      h('h1', {}, 'Carry the poses of one mesh over to another'),
      h('p', {}, 'Choose a source that moves and a target that should move like it. Or open a pipeline.'),
      noticeLine(),
    ),
    h(
      'div',
      { class: 'slots' },
      slot('Source', 'the mesh with poses', source),
      slot('Target', 'the mesh that takes them', target),
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

function slot(title: string, hint: string, path: { value: string | null }): HTMLElement {
  const name = h('span', { class: 'slot-name' });
  const clear = button({
    label: `Clear ${title.toLowerCase()}`,
    icon: 'close',
    bare: true,
    run: () => {
      path.value = null;
    },
  });
  const element = h(
    'div',
    { class: 'slot', role: 'group', 'aria-label': title },
    h('span', { class: 'slot-title' }, title),
    name,
    clear,
  );
  effect(() => {
    element.classList.toggle('filled', path.value !== null);
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
  if (studio.session.peek()?.project === null || !studio.meshes.peek()) return null;
  return button({ label: `Back to ${studio.session.peek()?.name ?? 'the project'}`, run: () => void studio.load() });
}

function titleOf(what: OpenRequest): string {
  if ('pipeline' in what) return fileName(what.pipeline);
  return `${fileName(what.source)} → ${fileName(what.target)}`;
}

export function fileName(path: string): string {
  return path.split(/[\\/]/).pop() ?? path;
}
