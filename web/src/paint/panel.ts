import type { Studio } from '../app/studio.ts';
import { h } from '../ui/dom.ts';
import type { Stage } from '../views/stage.ts';

export function paintPanel(_studio: Studio, _stage: Stage): HTMLElement {
  return h('div', { class: 'panel-page' });
}
