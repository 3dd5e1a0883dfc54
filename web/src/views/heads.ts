import { display, type TargetContent } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import { legend } from '../live/legend.ts';
import { pairTitle } from '../markers/order.ts';
import type { Side } from '../protocol/types.ts';
import { select } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import type { Up } from '../viewer/frame.ts';
import type { Pane } from './pane.ts';

/** Fills the corners of a pane: what it shows, the axis that points up, what a click will do, and the legend. */
export function furnishPane(pane: Pane, studio: Studio): void {
  pane.head.append(contents(pane, studio), upAxis(pane.side, studio));
  if (pane.role === 'result') pane.head.append(badge(studio));
  pane.foot.append(hint(pane, studio));
  if (pane.role === 'result') pane.foot.append(legend(studio));
}

function contents(pane: Pane, studio: Studio): HTMLElement {
  if (pane.role === 'rest') return h('span', {});
  if (pane.role === 'source') {
    return select({
      label: 'Source shows',
      quiet: true,
      options: () => [
        { value: 'pose', label: 'In pose' },
        { value: 'rest', label: 'At rest' },
      ],
      value: () => (display.sourceAtRest.value ? 'rest' : 'pose'),
      change: (value) => {
        display.sourceAtRest.value = value === 'rest';
      },
    });
  }
  return select<TargetContent>({
    label: 'Target shows',
    quiet: true,
    options: () => [
      { value: 'result', label: 'Result' },
      { value: 'rest', label: 'At rest' },
      { value: 'over_rest', label: 'Result over rest' },
      ...(studio.session.value?.has_truth
        ? ([
            { value: 'truth', label: 'Truth' },
            { value: 'over_truth', label: 'Result over truth' },
          ] as const)
        : []),
    ],
    value: () => display.target.value,
    change: (value) => {
      display.target.value = value;
    },
  });
}

function upAxis(side: Side, studio: Studio): HTMLElement {
  return select<Up>({
    label: `Axis of the ${side} that points up`,
    quiet: true,
    options: () => [
      { value: 'y', label: 'Y up' },
      { value: 'z', label: 'Z up' },
      { value: 'x', label: 'X up' },
    ],
    value: () => display.up[side].value ?? studio.session.value?.[side]?.up ?? 'y',
    change: (value) => {
      display.up[side].value = value;
    },
  });
}

/** Whether the target shows the quick preview or the pipeline's own result. */
function badge(studio: Studio): HTMLElement {
  const element = h('span', { class: 'shown-badge', role: 'status' });
  effect(() => {
    const shown = studio.live.target.value;
    const computing = studio.live.states.value.result?.state === 'computing';
    const content = display.target.value;
    element.hidden = !shown || content === 'rest' || content === 'truth';
    element.textContent =
      shown?.header.channel === 'result' ? 'Result' : computing ? 'Preview, result follows' : 'Preview';
  });
  return element;
}

function hint(pane: Pane, studio: Studio): HTMLElement {
  const element = h('p', { class: 'pane-hint' });
  effect(() => {
    const pair = studio.markers.pairs.value.find((other) => other.id === studio.selected.value);
    if (studio.panel.value === 'paint') element.textContent = '';
    else if (!pair) element.textContent = 'Click to begin a pair';
    else if (pair[pane.side] === null) element.textContent = `Click to set ${pairTitle(pair)}`;
    else element.textContent = `Click or drag to move ${pairTitle(pair)} · Esc to let go`;
    element.classList.toggle('wanted', pair !== undefined && pair[pane.side] === null);
  });
  return element;
}
