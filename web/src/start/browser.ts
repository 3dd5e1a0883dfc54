import { api, describeError } from '../protocol/client.ts';
import type { Folder, FolderEntry } from '../protocol/types.ts';
import { bytes } from '../stages/run.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect, type Signal, signal } from '../ui/signal.ts';

interface BrowserOptions {
  refresh: Signal<number>;
  mesh: (path: string) => void;
  pipeline: (path: string) => void;
}

type Listing = { folder: Folder } | { error: { message: string; hint: string | null } } | null;

/** Lists the folders of the server; a click on a mesh or a pipeline chooses it. */
export function fileBrowser(options: BrowserOptions): HTMLElement {
  const path = signal<string | null>(null);
  const listing = signal<Listing>(null);
  const roots = h('div', { class: 'roots', role: 'group', 'aria-label': 'Folders' });
  const place = h('p', { class: 'place' });
  const list = h('ul', { class: 'entries', 'aria-label': 'Files', 'aria-busy': 'true' });
  effect(() => {
    void options.refresh.value;
    void read(path.value);
  });

  async function read(wanted: string | null): Promise<void> {
    list.setAttribute('aria-busy', 'true');
    try {
      const folder = await api.files(wanted);
      if (wanted === path.peek()) listing.value = { folder };
    } catch (error) {
      listing.value = { error: describeError(error) };
    }
    list.setAttribute('aria-busy', 'false');
  }

  function choose(entry: FolderEntry): void {
    if (entry.kind === 'folder') path.value = entry.path;
    else if (entry.kind === 'mesh') options.mesh(entry.path);
    else if (entry.kind === 'pipeline') options.pipeline(entry.path);
  }

  effect(() => {
    const shown = listing.value;
    if (!shown) return fill(list, ...Array.from({ length: 6 }, () => h('li', { class: 'skeleton' })));
    if ('error' in shown) {
      return fill(
        list,
        h('li', { class: 'problem' }, shown.error.message, shown.error.hint ? ` ${shown.error.hint}` : null),
      );
    }
    const { folder } = shown;
    place.textContent = folder.path;
    fill(
      roots,
      ...folder.roots.map((root) =>
        rootButton(root.name, root.path === folder.path, () => {
          path.value = root.path;
        }),
      ),
    );
    const up =
      folder.parent === null
        ? null
        : upEntry(() => {
            path.value = folder.parent;
          });
    const entries = folder.entries.map((entry) =>
      h(
        'li',
        {},
        entryButton(entry, () => choose(entry)),
      ),
    );
    fill(list, up, ...entries, entries.length === 0 ? h('li', { class: 'empty' }, 'This folder is empty.') : null);
  });
  return h('section', { class: 'browser', 'aria-label': 'Files of the server' }, roots, place, list);
}

function rootButton(name: string, current: boolean, run: () => void): HTMLElement {
  return h('button', { type: 'button', class: 'chip', 'aria-current': current, onclick: run }, name);
}

function upEntry(run: () => void): HTMLElement {
  return h(
    'li',
    {},
    h('button', { type: 'button', class: 'entry', onclick: run }, icon('up'), h('span', {}, 'Folder above')),
  );
}

function entryButton(entry: FolderEntry, run: () => void): HTMLElement {
  const usable = entry.kind === 'folder' || entry.kind === 'mesh' || entry.kind === 'pipeline';
  return h(
    'button',
    { type: 'button', class: `entry ${entry.kind}`, onclick: run, disabled: !usable },
    icon(entry.kind === 'folder' ? 'folder' : entry.kind === 'pipeline' ? 'list' : 'file'),
    h('span', { class: 'entry-name' }, entry.name),
    h('span', { class: 'entry-kind' }, entry.kind === 'folder' ? '' : `${kindOf(entry)} · ${bytes(entry.bytes)}`),
  );
}

const KINDS = { folder: 'folder', mesh: 'mesh', pipeline: 'pipeline', markers: 'pairs', other: 'file' };

/** What a file is, for people. The server takes any JSON for pairs. */
export function kindOf({ kind, name }: Pick<FolderEntry, 'kind' | 'name'>): string {
  if (kind !== 'markers') return KINDS[kind];
  if (/\.mask\.json$/i.test(name)) return 'mask';
  return /^run\.json$/i.test(name) ? 'report of a run' : KINDS.markers;
}
