import { button } from './controls.ts';
import { fill, h } from './dom.ts';
import { icon } from './icons.ts';
import { effect, signal } from './signal.ts';

interface Notice {
  id: number;
  level: 'info' | 'error';
  text: string;
  hint: string | null;
}

const INFO_MILLISECONDS = 6000;
const MOST = 4;
const notices = signal<Notice[]>([]);
let count = 0;

/** Reports something in a corner; errors stay until they are closed. */
export function notify(text: string, hint: string | null = null, level: 'info' | 'error' = 'info'): void {
  count += 1;
  const notice = { id: count, level, text, hint };
  const others = notices.peek().filter((other) => other.text !== text);
  notices.value = [...others, notice].slice(-MOST);
  if (level === 'info') window.setTimeout(() => dismiss(notice.id), INFO_MILLISECONDS);
}

function dismiss(id: number): void {
  notices.value = notices.peek().filter((notice) => notice.id !== id);
}

/** The corner with the notices, which screen readers read out as they come. */
export function noticeArea(): HTMLElement {
  const area = h('div', { class: 'notices', role: 'status', 'aria-live': 'polite' });
  effect(() => fill(area, ...notices.value.map(render)));
  return area;
}

function render(notice: Notice): HTMLElement {
  return h(
    'div',
    { class: `notice ${notice.level}` },
    icon(notice.level === 'error' ? 'warning' : 'info'),
    h('div', {}, h('p', {}, notice.text), notice.hint ? h('p', { class: 'hint' }, notice.hint) : null),
    button({ label: 'Dismiss', icon: 'close', bare: true, run: () => dismiss(notice.id) }),
  );
}
