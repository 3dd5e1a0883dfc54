import { fill, h } from '../ui/dom.ts';
import type { PoseEntry } from './data.ts';
import { Legend } from './legend.ts';
import type { Shown } from './stage.ts';

/** The choice of a pose, and of what is shown of it. `change` is told of each. */
export function controls(poses: PoseEntry[], change: (shown: Shown) => void, whole: () => void) {
  const shown: Shown = { pose: poses[0], rest: false, colours: true, wireframe: false };
  const legend = new Legend();
  const reasons = h('ul', { class: 'v3-reasons', 'aria-live': 'polite' });

  function update(): void {
    legend.show(shown.colours && !shown.rest ? shown.pose.field : null);
    fill(reasons, ...shown.pose.reasons.map((reason) => h('li', {}, reason)));
    change(shown);
  }

  function choice(pose: PoseEntry, index: number): HTMLElement {
    const input = h('input', {
      type: 'radio',
      name: 'v3-pose',
      checked: index === 0,
      onchange: () => {
        shown.pose = pose;
        update();
      },
    });
    const badge = pose.verdict && h('span', { class: `badge ${pose.level}` }, pose.verdict);
    return h('label', { class: 'v3-choice' }, input, h('span', { class: 'v3-name' }, pose.name), badge);
  }

  function toggle(label: string, key: 'rest' | 'colours' | 'wireframe'): HTMLElement {
    const input = h('input', {
      type: 'checkbox',
      checked: shown[key],
      onchange: (event: Event) => {
        shown[key] = (event.target as HTMLInputElement).checked;
        update();
      },
    });
    return h('label', { class: 'v3-toggle' }, input, label);
  }

  const list = h(
    'fieldset',
    { class: 'v3-poses' },
    h('legend', {}, 'Pose'),
    h('div', { class: 'v3-choices' }, ...poses.map(choice)),
  );
  const options = h(
    'div',
    { class: 'v3-options' },
    poses.some((pose) => pose.field) && toggle('Colours', 'colours'),
    toggle('Wireframe', 'wireframe'),
    toggle('At rest', 'rest'),
    h('button', { type: 'button', class: 'v3-button', onclick: whole }, 'Whole mesh'),
  );
  return { list, options, reasons, legend: legend.element, update };
}
