import type { Studio } from '../app/studio.ts';
import { sentence } from '../protocol/client.ts';
import type { Conflict } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import { pairTitle } from './order.ts';

/** Edits that the server did not take, because someone else changed the same thing. */
export function conflictList(studio: Studio): HTMLElement {
  const element = h('div', { class: 'conflicts', role: 'alert' });
  effect(() => {
    const { conflicts } = studio.markers;
    element.hidden = conflicts.value.length === 0;
    fill(element, ...conflicts.value.map((conflict) => render(studio, conflict)));
  });
  return element;
}

function render(studio: Studio, conflict: Conflict): HTMLElement {
  const title = conflict.current ? pairTitle(conflict.current) : 'An edit';
  return h(
    'div',
    { class: 'conflict' },
    h('p', {}, h('strong', {}, `${title} was not changed. `), sentence(conflict.reason)),
    h('p', { class: 'hint' }, 'What you see now is what is saved. Make the change again if you still want it.'),
    button({ label: 'Understood', run: () => studio.markers.dismissConflict(conflict) }),
  );
}
