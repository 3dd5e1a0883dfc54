import { api, describeError } from '../protocol/client.ts';
import type { About } from '../protocol/types.ts';
import { openDialog } from '../ui/dialog.ts';
import { fill, h } from '../ui/dom.ts';

export async function openAbout(): Promise<void> {
  const body = h('div', { class: 'about' }, h('p', { class: 'muted' }, 'Loading …'));
  openDialog('About mimesh', [body], true);
  try {
    fill(body, ...describe(await api.about()));
  } catch (error) {
    fill(body, h('p', { class: 'problem' }, describeError(error).message));
  }
}

function describe(about: About): Node[] {
  return [
    h('p', {}, `mimesh ${about.version} carries the poses of one triangle mesh over to another.`),
    h('h3', {}, 'Licences of the packages in this page'),
    ...about.licences.map((entry) =>
      h(
        'details',
        {},
        h('summary', {}, `${entry.name} ${entry.version} · ${entry.licence}`),
        h('pre', { tabindex: 0 }, entry.text),
      ),
    ),
  ];
}
