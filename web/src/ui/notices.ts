import { button } from './controls.ts';
import { fill, h, uniqueId } from './dom.ts';
import { icon } from './icons.ts';
import { splitCommands } from './prose.ts';
import { effect, signal } from './signal.ts';

type Level = 'info' | 'error';

interface Notice {
  id: number;
  level: Level;
  text: string;
  hint: string | null;
  /** What it is about: a newer notice of the same topic takes its place, and it goes when the matter is settled. */
  topic: string | null;
}

const INFO_MILLISECONDS = 6000;
const MOST = 20;
const notices = signal<Notice[]>([]);
let count = 0;

/** Reports something in the line of messages; errors stay until they are settled or dismissed. */
export function notify(
  text: string,
  hint: string | null = null,
  level: Level = 'info',
  topic: string | null = null,
): void {
  count += 1;
  // The page can do itself what commands would.
  const notice = { id: count, level, text, hint: hint && (splitCommands(hint).page || null), topic };
  const others = notices.peek().filter((other) => other.text !== text && (topic === null || other.topic !== topic));
  notices.value = [...others, notice].slice(-MOST);
  if (level === 'info') window.setTimeout(() => dismiss(notice.id), INFO_MILLISECONDS);
}

/** What was wrong about a topic is so no more. */
export function settle(topic: string): void {
  const left = notices.peek().filter((notice) => notice.topic !== topic);
  if (left.length < notices.peek().length) notices.value = left;
}

/** Nothing that was said holds any more. */
export function clearNotices(): void {
  notices.value = [];
}

function dismiss(id: number): void {
  notices.value = notices.peek().filter((notice) => notice.id !== id);
}

/**
 * The line of messages, beside the views and never over them, so that a click cannot miss one and hit a mesh. It shows the newest; a click
 * shows all of them in full.
 */
export function noticeLine(): HTMLElement {
  const id = uniqueId('messages');
  const list = h('div', { id, class: 'popover messages', popover: 'auto' });
  const text = h('span', { class: 'notice-text', role: 'status', 'aria-live': 'polite' });
  const more = h('button', { type: 'button', class: 'button plain', popovertarget: id });
  const close = button({
    label: 'Dismiss',
    icon: 'close',
    bare: true,
    run: () => {
      const newest = notices.peek().at(-1);
      if (newest) dismiss(newest.id);
    },
  });
  const element = h('div', { class: 'notice-line' }, text, more, close, list);
  effect(() => {
    const newest = notices.value.at(-1);
    element.dataset.level = newest?.level ?? '';
    fill(
      text,
      newest ? icon(newest.level === 'error' ? 'warning' : 'info') : null,
      newest ? h('strong', {}, newest.text) : null,
      newest?.hint ? ` ${newest.hint}` : null,
    );
    text.title = [newest?.text, newest?.hint].filter(Boolean).join(' ');
    close.hidden = newest === undefined;
    more.hidden = newest === undefined;
    more.textContent = notices.value.length > 1 ? `All ${notices.value.length}` : 'Read';
    fill(list, ...notices.value.map(render).reverse());
  });
  return element;
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
