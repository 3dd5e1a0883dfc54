import { display } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import { sentence } from '../protocol/client.ts';
import type { LiveState, Worst } from '../protocol/types.ts';
import { runReport } from '../stages/run.ts';
import { select } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import { verdict } from '../ui/verdict.ts';
import { formatNumber } from '../viewer/colours.ts';
import type { Stage } from '../views/stage.ts';
import { shapeSliders } from './sliders.ts';

/** Colours, shapes, the worst places and the last run. */
export function resultPanel(studio: Studio, stage: Stage): HTMLElement {
  return h(
    'div',
    { class: 'panel-page result' },
    h('section', { class: 'block', 'aria-label': 'Live result' }, h('h3', {}, 'Live result'), liveState(studio)),
    h(
      'section',
      { class: 'block', 'aria-label': 'Colours' },
      h('h3', {}, 'Colours'),
      select({
        label: 'Show',
        options: () => [
          { value: '', label: 'Plain surface' },
          ...(studio.session.value?.scalars ?? []).map((scalar) => ({ value: scalar.name, label: scalar.title })),
        ],
        value: () => studio.live.scalar.value ?? '',
        change: (value) => {
          studio.live.scalar.value = value || null;
          if (value) display.target.value = display.target.peek() === 'rest' ? 'result' : display.target.peek();
        },
      }),
    ),
    shapeSliders(studio),
    worstList(studio, stage),
    runReport(studio),
  );
}

function liveState(studio: Studio): HTMLElement {
  const element = h('div', { class: 'live-states', role: 'status', 'aria-live': 'polite' });
  effect(() => {
    const { preview, result } = studio.live.states.value;
    const reason = studio.session.value?.live.reason ?? null;
    const lines = [describeState('Preview', preview), describeState('Result', result)].filter((line) => line !== null);
    if (reason) lines.unshift(sentence(reason));
    fill(
      element,
      ...(lines.length > 0 ? lines : ['Drag a point and the target moves.']).map((line) => h('p', {}, line)),
    );
  });
  return element;
}

function describeState(name: string, state: LiveState | undefined): string | null {
  if (!state) return null;
  switch (state.state) {
    case 'computing': {
      const share = state.share === null ? '' : ` ${Math.round(state.share * 100)} %`;
      return `${name}: computing ${state.stage ?? ''}${share} …`;
    }
    case 'ready':
      return `${name}: up to date.`;
    default:
      return `${name}: ${sentence(state.error?.message ?? state.state)}${state.error?.hint ? ` ${sentence(state.error.hint)}` : ''}`;
  }
}

function worstList(studio: Studio, stage: Stage): HTMLElement {
  const list = h('ol', { class: 'worst' });
  const empty = h('p', { class: 'muted' }, 'When a result is there, its worst places are listed here.');
  effect(() => {
    const worst = studio.live.worst.value;
    empty.hidden = worst.length > 0;
    fill(list, ...worst.map((entry) => h('li', {}, worstEntry(studio, stage, entry))));
  });
  return h('section', { class: 'block', 'aria-label': 'Worst places' }, h('h3', {}, 'Worst places'), empty, list);
}

function worstEntry(studio: Studio, stage: Stage, worst: Worst): HTMLElement {
  const place = [worst.about, worst.pose_name].filter(Boolean).join(' · ');
  const value = worst.value === null ? 'not measured' : `${formatNumber(worst.value)} ${worst.unit}`;
  const limit = worst.limit === null ? '' : `, limit ${formatNumber(worst.limit)} ${worst.unit}`;
  return h(
    'button',
    {
      type: 'button',
      class: `worst-entry ${worst.level}`,
      onclick: () => {
        if (worst.pose !== null) {
          studio.live.playing.value = false;
          studio.live.pose.value =
            studio.session.peek()?.poses?.are === 'shapes' ? { blend: [[worst.pose, 1]] } : { index: worst.pose };
        }
        if (worst.vertex !== null) stage.flyToPoints(null, { vertex: worst.vertex });
      },
    },
    verdict(worst.level),
    h('span', { class: 'figure' }, value),
    h('span', { class: 'about' }, `${worst.title}${limit}`),
    h('span', { class: 'place' }, place || 'whole run'),
  );
}
