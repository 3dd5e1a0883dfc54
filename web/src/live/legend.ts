import type { Studio } from '../app/studio.ts';
import type { FrameScalar } from '../protocol/types.ts';
import { fill, h } from '../ui/dom.ts';
import { computed, effect } from '../ui/signal.ts';
import { cssColour, formatNumber, sampleColour, ticks } from '../viewer/colours.ts';
import { mapOf } from '../views/stage.ts';

const STOPS = 12;

/** The scale of the colours on the target, with figures and unit. */
export function legend(studio: Studio): HTMLElement {
  const title = h('p', { class: 'legend-title' });
  const bar = h('div', { class: 'legend-bar' });
  const limit = h('span', { class: 'legend-limit' });
  const figures = h('div', { class: 'legend-figures' });
  const element = h(
    'div',
    { class: 'legend', role: 'img' },
    title,
    h('div', { class: 'legend-scale' }, bar, limit),
    figures,
  );
  // Every frame brings its scale; the legend is drawn anew only for another one.
  const scale = computed(() => {
    const scalar = studio.live.target.value?.scalar ?? null;
    return scalar !== null && scalar.name === studio.live.scalar.value ? JSON.stringify(scalar) : null;
  });
  effect(() => {
    // While a mask is painted, its colours take the place of these.
    element.hidden = scale.value === null || studio.panel.value === 'paint';
    if (scale.value === null) return;
    const scalar = JSON.parse(scale.value) as FrameScalar;
    const map = mapOf(scalar);
    const colours = Array.from({ length: STOPS }, (_, i) => cssColour(sampleColour(map, i / (STOPS - 1))));
    title.textContent = scalar.unit ? `${scalar.title}, ${scalar.unit}` : scalar.title;
    bar.style.backgroundImage = `linear-gradient(to right, ${colours.join(', ')})`;
    fill(figures, ...ticks(scalar.low, scalar.high).map((value) => h('span', {}, formatNumber(value))));
    limit.hidden = scalar.limit === null;
    if (scalar.limit !== null) {
      limit.style.left = `${((scalar.limit - scalar.low) / (scalar.high - scalar.low)) * 100}%`;
      limit.title = `limit ${formatNumber(scalar.limit)}`;
    }
    element.setAttribute(
      'aria-label',
      `Colours: ${scalar.title} from ${formatNumber(scalar.low)} to ${formatNumber(scalar.high)} ${scalar.unit}`,
    );
  });
  return element;
}
