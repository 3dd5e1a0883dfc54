import { button } from './controls.ts';
import { fill, h, uniqueId } from './dom.ts';
import { icon } from './icons.ts';
import { dismiss, earlier, keep, type Notice, notices } from './notices.ts';
import { inline } from './prose.ts';
import { effect } from './signal.ts';

/**
 * The line of messages, beside the views and never over them, so that a click cannot miss one and hit a mesh. It shows the newest; a click
 * shows all of them in full, and those from before.
 */
export function noticeLine(): HTMLElement {
  const id = uniqueId('messages');
  const list = h('div', { id, class: 'popover messages', popover: 'auto', role: 'log', 'aria-label': 'Messages' });
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
  const isOpen = () => list.matches(':popover-open');
  // What is being read stays. The event after the list is shown would come too late for a message that goes now.
  list.addEventListener('beforetoggle', (event) => {
    if ((event as ToggleEvent).newState === 'open') notices.peek().forEach(keep);
  });
  effect(() => {
    const newest = notices.value.at(-1);
    element.dataset.level = newest?.level ?? '';
    fill(
      text,
      newest ? icon(newest.level === 'error' ? 'warning' : 'info') : null,
      newest ? h('strong', {}, ...inline(newest.text)) : null,
      newest?.hint ? h('span', {}, ' ', ...inline(newest.hint)) : null,
    );
    text.title = [newest?.text, newest?.hint].filter(Boolean).join(' ');
    close.hidden = newest === undefined;
    if (newest && (isOpen() || text.scrollHeight > text.clientHeight + 1)) keep(newest);
  });
  effect(() => {
    const [present, past] = [notices.value, earlier.value];
    more.hidden = present.length + past.length === 0;
    more.textContent = present.length > 1 ? `All ${present.length}` : present.length === 1 ? 'In full' : 'Messages';
    more.title = 'All messages, and those from before';
    fill(
      list,
      ...present.map((notice) => render(notice)).reverse(),
      past.length > 0 ? h('h3', {}, 'Earlier') : null,
      ...past.map((notice) => renderEarlier(notice)).reverse(),
    );
  });
  return element;
}

function render(notice: Notice): HTMLElement {
  return h(
    'div',
    { class: `notice ${notice.level}` },
    icon(notice.level === 'error' ? 'warning' : 'info'),
    words(notice),
    button({ label: 'Dismiss', icon: 'close', bare: true, run: () => dismiss(notice.id) }),
  );
}

function renderEarlier(notice: Notice): HTMLElement {
  const time = notice.at.toLocaleTimeString('en-GB', { hour: '2-digit', minute: '2-digit' });
  return h('div', { class: 'notice-earlier' }, h('span', { class: 'muted' }, time), words(notice));
}

function words({ text, hint }: Notice): HTMLElement {
  return h('div', {}, h('p', {}, ...inline(text)), hint ? h('p', { class: 'hint' }, ...inline(hint)) : null);
}
