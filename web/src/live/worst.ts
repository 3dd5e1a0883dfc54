import { display } from '../app/display.ts';
import type { Studio } from '../app/studio.ts';
import type { Worst } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import { inline } from '../ui/prose.ts';
import { effect } from '../ui/signal.ts';
import { verdict } from '../ui/verdict.ts';
import { readableIn } from '../ui/words.ts';
import { formatNumber } from '../viewer/colours.ts';
import type { Stage } from '../views/stage.ts';

/** Entries about one statistic, the worst first. */
export function byStatistic(list: readonly Worst[]): Worst[][] {
  const groups = new Map<string, Worst[]>();
  for (const worst of list) groups.set(worst.title, [...(groups.get(worst.title) ?? []), worst]);
  return [...groups.values()];
}

/** Statistics above their limits, each once with its worst place; a click shows the pose and points at the place. */
export function worstEntries(studio: Studio, stage: Stage, list: readonly Worst[], most: number): HTMLElement[] {
  return byStatistic(list)
    .slice(0, most)
    .map(([first, ...others]) =>
      h(
        'li',
        {},
        worstEntry(studio, stage, first),
        others.length === 0
          ? null
          : h(
              'details',
              {},
              h('summary', {}, `${others.length} more ${others.length === 1 ? 'place' : 'places'}`),
              ...others.map((other) => worstEntry(studio, stage, other, true)),
            ),
      ),
    );
}

function worstEntry(studio: Studio, stage: Stage, worst: Worst, short = false): HTMLElement {
  const place = [readableIn(worst.about ?? ''), worst.pose_name].filter(Boolean).join(' · ');
  const value = worst.value === null ? 'not measured' : `${formatNumber(worst.value)} ${worst.unit}`;
  const limit = worst.limit === null ? '' : `, limit ${formatNumber(worst.limit)} ${worst.unit}`;
  return h(
    'button',
    {
      type: 'button',
      class: `worst-entry ${worst.level}`,
      title: worst.meaning.replace(/`/g, ''),
      onclick: () => showWorst(studio, stage, worst),
    },
    verdict(worst.level),
    h('span', { class: 'figure' }, value),
    short ? null : h('span', { class: 'about' }, `${readableIn(worst.title)}${limit}`),
    short || !worst.fault ? null : h('span', { class: 'advice' }, ...inline(`${capital(readableIn(worst.fault))}.`)),
    h('span', { class: 'place' }, place || 'whole run'),
  );
}

/** Shows the pose of a statistic and points at its place, which may be known only when that pose was measured. */
export function showWorst(studio: Studio, stage: Stage, worst: Worst): void {
  if (worst.pose !== null) {
    studio.live.playing.value = false;
    studio.live.pose.value =
      studio.session.peek()?.poses?.are === 'shapes' ? { blend: [[worst.pose, 1]] } : { index: worst.pose };
  }
  showColours(studio, worst.metric);
  const marker = /^marker (.+)$/.exec(worst.about ?? '')?.[1];
  const pair = studio.markers.pairs.peek().find((one) => (one.name ?? String(one.number)) === marker);
  if (pair?.target) {
    // Its number points at the place.
    studio.selected.value = pair.id;
    stage.flyToPoints(pair.source, pair.target);
  } else if (worst.vertex !== null) stage.showPlace('target', { vertex: worst.vertex });
  else studio.live.sought.value = { metric: worst.metric, pose: worst.pose };
}

/** The colours that show where a metric is bad, if it has a colour map. */
function showColours(studio: Studio, metric: string): void {
  if (!studio.session.peek()?.scalars.some((scalar) => scalar.name === metric)) return;
  studio.live.scalar.value = metric;
  // The target at rest has no colours.
  if (display.target.peek() === 'rest') display.target.value = 'result';
}

/** Points at the place that is sought as soon as the pose is measured. */
export function followSought(studio: Studio, stage: Stage): void {
  effect(() => {
    const sought = studio.live.sought.value;
    const found =
      sought && studio.live.worst.value.find((one) => one.metric === sought.metric && one.pose === sought.pose);
    if (!found || found.vertex === null) return;
    studio.live.sought.value = null;
    stage.showPlace('target', { vertex: found.vertex });
  });
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1).replace(/\.$/, '');
}
