import { fill, h } from '../ui/dom.ts';
import { cssColour, formatNumber, sampleColour, ticks } from '../viewer/colours.ts';
import type { FieldEntry } from './data.ts';

const STOPS = 16;
/** Scales end at numbers such as 5, 20 and 100. */
const TICKS = 6;

/** The scale of the colours, with name, unit and numbers. */
export class Legend {
  readonly element: HTMLElement;
  private readonly title = h('span', { class: 'v3-legend-title' });
  private readonly figures = h('span', { class: 'v3-legend-figures' });

  constructor() {
    const bar = h('span', { class: 'v3-legend-bar' });
    const colours = Array.from({ length: STOPS }, (_, i) => cssColour(sampleColour('picture', i / (STOPS - 1))));
    bar.style.backgroundImage = `linear-gradient(to right, ${colours.join(', ')})`;
    this.element = h('div', { class: 'v3-legend', role: 'img' }, this.title, bar, this.figures);
  }

  show(field: FieldEntry | null): void {
    this.element.hidden = field === null;
    if (!field) return;
    const numbers = ticks(0, field.high, TICKS).map(formatNumber);
    if (field.over) numbers.push(`>${numbers.pop()}`);
    this.title.textContent = field.unit;
    fill(this.figures, ...numbers.map((number) => h('span', {}, number)));
    this.element.setAttribute('aria-label', `Colours: ${field.unit}, from ${numbers[0]} to ${numbers.at(-1)}`);
  }
}
