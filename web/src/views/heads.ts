import { display, type TargetContent } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import { legend } from '../live/legend.ts';
import { pairTitle } from '../markers/order.ts';
import type { Side } from '../protocol/types.ts';
import { select } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { computed, effect } from '../ui/signal.ts';
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
  // Frames come many times a second; the choices change only when the words do.
  const moved = computed(() => (studio.live.target.value?.header.channel === 'preview' ? 'Rough preview' : 'Result'));
  return select<TargetContent>({
    label: 'Target shows',
    quiet: true,
    options: () => [
      { value: 'result', label: moved.value },
      { value: 'rest', label: 'At rest' },
      { value: 'over_rest', label: `${moved.value} over rest` },
      ...(studio.session.value?.has_truth
        ? ([
            { value: 'truth', label: 'Truth' },
            { value: 'over_truth', label: `${moved.value} over truth` },
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
  // Frames come many times a second; the page changes only when the words do.
  const text = computed(() => {
    const channel = studio.live.target.value?.header.channel;
    const state = studio.live.states.value.result;
    const content = display.target.value;
    // At rest both are the target's own shape.
    if (channel !== 'preview' || content === 'rest' || content === 'truth') return '';
    if (studio.dragged.value) return 'Rough preview';
    if (studio.live.playing.value) return `Rough preview · ${studio.live.preparation()}`;
    if (state?.state === 'failed' || state?.state === 'unavailable') {
      return `Rough preview · no result: ${state.error?.message ?? 'it failed'}`;
    }
    return 'Rough preview · the result follows';
  });
  effect(() => {
    element.hidden = text.value === '';
    element.textContent = text.value;
    element.title = 'The preview is quick and may be torn. The result is what a run writes.';
  });
  return element;
}

function hint(pane: Pane, studio: Studio): HTMLElement {
  const element = h('p', { class: 'pane-hint' });
  const selected = () => studio.markers.pairs.value.find((pair) => pair.id === studio.selected.value);
  const text = computed(() => {
    const pair = selected();
    if (studio.panel.value === 'paint') return '';
    const components = studio.session.value?.[pane.side]?.components.length ?? 0;
    if (components > 0 && studio.hidden[pane.side].value.size >= components)
      return 'All of it is hidden · U shows it again';
    if (studio.panel.value !== 'points') return 'Drag a numbered point to move it · Clicks set points under Pairs';
    if (!pair) return 'Click to begin a pair';
    if (studio.fresh.value?.pair === pair.id && studio.fresh.value.complete)
      return `Click to begin the next pair · Drag to move ${pairTitle(pair)}`;
    if (pair[pane.side] === null) return `Click to set ${pairTitle(pair)}`;
    return `Click or drag to move ${pairTitle(pair)} · Esc to let go`;
  });
  effect(() => {
    element.textContent = text.value;
    element.title = text.value;
  });
  effect(() => {
    const sets = studio.panel.value === 'points';
    element.classList.toggle('wanted', sets && selected()?.[pane.side] === null);
  });
  return element;
}
