import type { Studio } from '../app/studio.ts';
import type { Worst } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import { verdict } from '../ui/verdict.ts';
import { formatNumber } from '../viewer/colours.ts';
import type { Stage } from '../views/stage.ts';

/** Statistics above their limits; a click shows the pose and flies to the place. */
export function worstEntries(studio: Studio, stage: Stage, list: readonly Worst[]): HTMLElement[] {
  return list.map((entry) => h('li', {}, worstEntry(studio, stage, entry)));
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
