import { display } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import { sentence } from '../protocol/client.ts';
import type { LiveState } from '../protocol/types.ts';
import { runReport } from '../stages/run.ts';
import { select } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { effect } from '../ui/signal.ts';
import type { Stage } from '../views/stage.ts';
import { shapeSliders } from './sliders.ts';
import { followSought, showWorst, worstEntries } from './worst.ts';

const MOST = 12;

/** Colours, shapes, the worst places and the last run. */
export function resultPanel(studio: Studio, stage: Stage): HTMLElement {
  followSought(studio, stage);
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
    runReport(studio, (worst) => showWorst(studio, stage, worst)),
    worstOfRun(studio, stage),
  );
}

function liveState(studio: Studio): HTMLElement {
  const element = h('div', { class: 'live-states', role: 'status', 'aria-live': 'polite' });
  effect(() => {
    const { preview, result, truth } = studio.live.states.value;
    const reason = studio.session.value?.live.reason ?? null;
    const states = [describeState('Preview', preview), describeState('Result', result), describeState('Truth', truth)];
    const lines = states.filter((line) => line !== null);
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
      return name === 'Preview' ? null : `${name}: up to date.`;
    default:
      return `${name}: ${sentence(state.error?.message ?? state.state)}${state.error?.hint ? ` ${sentence(state.error.hint)}` : ''}`;
  }
}

/** The worst places of the pose that is shown. */
function worstList(studio: Studio, stage: Stage): HTMLElement {
  const list = h('ol', { class: 'worst' });
  const empty = h('p', { class: 'muted' });
  effect(() => {
    const worst = studio.live.worst.value;
    const ready = studio.live.states.value.result?.state === 'ready';
    empty.hidden = worst.length > 0;
    empty.textContent = ready
      ? 'Nothing is above its limit in this pose.'
      : 'When a result is there, its worst places are listed here.';
    fill(list, ...worstEntries(studio, stage, worst, MOST));
  });
  return h('section', { class: 'block', 'aria-label': 'Worst places' }, h('h3', {}, 'Worst places'), empty, list);
}

/** The worst places of the last run, over all poses. */
function worstOfRun(studio: Studio, stage: Stage): HTMLElement {
  const list = h('ol', { class: 'worst' });
  const title = 'Worst places of the run';
  const element = h('section', { class: 'block', 'aria-label': title }, h('h3', {}, title), list);
  effect(() => {
    const worst = studio.runs.last()?.result?.worst ?? [];
    element.hidden = worst.length === 0;
    fill(list, ...worstEntries(studio, stage, worst, MOST));
  });
  return element;
}
