import type { Studio } from '../app/studio.ts';
import { button } from '../ui/controls.ts';
import { openDialog } from '../ui/dialog.ts';
import { h, uniqueId } from '../ui/dom.ts';
import { pairTitle } from './order.ts';

type Axis = 'x' | 'y' | 'z';

/** Asks for the plane, and adds the partners that are missing beyond it. */
export function openMirrorDialog(studio: Studio): void {
  let axis: Axis = guessAxis(studio);
  const source = offsetField('Source plane at');
  const target = offsetField('Target plane at');
  const selected = studio.markers.pair(studio.selected.peek());

  function mirror(pair?: number): void {
    const [source_offset, target_offset] = [source.value(), target.value()];
    studio.markers.edit({ op: 'mirror', axis, pair, source_offset, target_offset });
    dialog.close();
  }

  const dialog = openDialog('Mirror pairs', [
    h('p', {}, 'Every pair gets its partner on the other side of a plane, unless one is there already.'),
    h(
      'fieldset',
      { class: 'choices' },
      h('legend', {}, 'Plane across the axis'),
      ...(['x', 'y', 'z'] as const).map((value) => {
        const id = uniqueId('axis');
        const input = h('input', {
          type: 'radio',
          name: 'axis',
          id,
          value,
          checked: value === axis,
          onchange: () => {
            axis = value;
          },
        });
        return h('span', { class: 'choice' }, input, h('label', { for: id }, value.toUpperCase()));
      }),
    ),
    h('p', { class: 'hint' }, 'Left empty, the plane goes through the middle of each mesh.'),
    source.element,
    target.element,
    h(
      'div',
      { class: 'row end' },
      button({ label: 'Cancel', run: () => dialog.close() }),
      selected ? button({ label: `Only ${pairTitle(selected)}`, run: () => mirror(selected.id) }) : null,
      button({
        label: selected ? 'All pairs' : 'Mirror',
        kind: 'primary',
        icon: 'mirror',
        run: () => mirror(),
      }),
    ),
  ]);
}

/** The mesh is usually symmetric across its narrower level axis. */
function guessAxis(studio: Studio): Axis {
  const facts = studio.session.peek()?.source;
  if (!facts) return 'x';
  const [low, high] = facts.bounds;
  const level = (['x', 'y', 'z'] as const).filter((axis) => axis !== facts.up);
  const widths = level.map((axis) => high['xyz'.indexOf(axis)] - low['xyz'.indexOf(axis)]);
  return level[widths[0] <= widths[1] ? 0 : 1];
}

function offsetField(label: string): { element: HTMLElement; value: () => number | undefined } {
  const id = uniqueId('offset');
  const input = h('input', { type: 'number', step: 'any', id, placeholder: 'middle' });
  return {
    element: h('div', { class: 'field-row' }, h('label', { for: id }, label), input),
    value: () => (input.value.trim() === '' ? undefined : Number(input.value)),
  };
}
