import type { Studio } from '../app/studio.ts';
import type { Pair } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { openDialog } from '../ui/dialog.ts';
import { h, uniqueId } from '../ui/dom.ts';
import { notify } from '../ui/notices.ts';
import { mirrorOne } from './mirrorone.ts';
import { pairTitle } from './order.ts';

type Axis = 'x' | 'y' | 'z';

/** Asks for the plane, and adds the partners that are missing beyond it. */
export function openMirrorDialog(studio: Studio, added: (pair: number) => void): void {
  let axis: Axis = guessAxis(studio);
  const source = offsetField('Source plane at');
  const target = offsetField('Target plane at');
  const selected = studio.markers.pair(studio.selected.peek());

  /** The server mirrors all pairs or none, so the image of one is a new pair. */
  function one(pair: Pair): void {
    const { session, meshes } = studio;
    const [facts, data] = [session.peek(), meshes.peek()];
    dialog.close();
    if (!facts?.source || !facts.target || !data) return;
    const result = mirrorOne(pair, studio.markers.pairs.peek(), axis, {
      source: { mesh: data.source, facts: facts.source, offset: source.value() },
      target: { mesh: data.target, facts: facts.target, offset: target.value() },
    });
    if ('problem' in result) {
      notify(`${pairTitle(pair)} was not mirrored.`, result.problem, 'info', 'mirror');
      return;
    }
    const [id] = studio.markers.edit(result.op);
    added(id);
    notify(
      `Added the mirror image of ${pairTitle(pair)}.`,
      'Look whether it lies right on both meshes.',
      'info',
      'mirror',
    );
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
      selected ? button({ label: `Only ${pairTitle(selected)}`, run: () => one(selected) }) : null,
      button({
        label: selected ? 'All pairs' : 'Mirror',
        kind: 'primary',
        icon: 'mirror',
        run: () => {
          studio.markers.edit({ op: 'mirror', axis, source_offset: source.value(), target_offset: target.value() });
          dialog.close();
        },
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
