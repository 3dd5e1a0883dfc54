import type { Studio } from '../app/studio.ts';
import type { Diagnostic } from '../protocol/types.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { inline, splitCommands } from '../ui/prose.ts';
import { effect } from '../ui/signal.ts';

const SAVE_AFTER_MILLISECONDS = 500;

/** The text of the pipeline, with numbers of lines and marks at those with faults. It is saved shortly after the last key. */
export function yamlEditor(studio: Studio): HTMLElement {
  const gutter = h('div', { class: 'gutter', 'aria-hidden': 'true' });
  const text = h('textarea', {
    class: 'yaml',
    spellcheck: 'false',
    autocapitalize: 'off',
    'aria-label': 'Pipeline as YAML',
    'aria-describedby': 'editor-keys',
    oninput: () => changed(),
    onscroll: () => {
      gutter.style.transform = `translateY(${-text.scrollTop}px)`;
    },
    onkeydown: (event: KeyboardEvent) => indent(text, event),
  });
  const lines = h('div', { class: 'yaml-lines', 'aria-hidden': 'true' });
  const faults = h('ul', { class: 'faults', 'aria-label': 'Faults', 'aria-live': 'polite' });
  const state = h('p', { class: 'muted', role: 'status' });
  let timer = 0;
  /** The revision that the text began with; null while the text is the saved one. */
  let base: number | null = null;

  function changed(): void {
    base ??= studio.pipeline.pipeline.peek()?.revision ?? 0;
    drawGutter();
    window.clearTimeout(timer);
    timer = window.setTimeout(() => void save(), SAVE_AFTER_MILLISECONDS);
  }

  async function save(): Promise<void> {
    const revision = base;
    if (revision === null) return;
    const sent = text.value;
    await studio.pipeline.setText(revision, sent);
    // Keys that were pressed meanwhile go on from what was just saved.
    base = text.value === sent ? null : (studio.pipeline.pipeline.peek()?.revision ?? revision);
  }

  function drawGutter(): void {
    const bad = new Set((studio.pipeline.pipeline.peek()?.diagnostics ?? []).map((one) => one.line));
    lines.style.width = `${text.clientWidth}px`;
    fill(lines, ...text.value.split('\n').map((line) => h('div', {}, line || ' ')));
    const heights = [...lines.children].map((line) => (line as HTMLElement).offsetHeight);
    const numbers = heights.map((height, i) => {
      const number = h('span', { class: bad.has(i + 1) ? 'bad' : '' }, i + 1);
      if (height > 0) number.style.height = `${height}px`;
      return number;
    });
    fill(gutter, ...numbers);
  }

  // Another width wraps the lines elsewhere.
  new ResizeObserver(() => drawGutter()).observe(text);
  effect(() => {
    const pipeline = studio.pipeline.pipeline.value;
    if (!pipeline) return;
    if (base === null && text.value !== pipeline.text) text.value = pipeline.text;
    drawGutter();
    fill(faults, ...pipeline.diagnostics.map((one) => h('li', {}, faultButton(text, one))));
    faults.hidden = pipeline.diagnostics.length === 0;
  });
  effect(() => {
    const pipeline = studio.pipeline.pipeline.value;
    const name = pipeline?.file ?? '';
    state.textContent =
      pipeline?.disk === 'failed'
        ? `${name} cannot be saved: ${pipeline.disk_error ?? ''}`
        : studio.pipeline.saving.value
          ? `Saving ${name} …`
          : pipeline?.checking
            ? `${name} · checking …`
            : pipeline?.exists
              ? `${name} · saved`
              : `${name} · not written yet`;
  });
  return h(
    'section',
    { class: 'editor', 'aria-label': 'Text' },
    state,
    h('div', { class: 'editor-text' }, lines, h('div', { class: 'gutter-clip' }, gutter), text),
    faults,
    h('p', { class: 'hint editor-keys', id: 'editor-keys' }, 'Tab indents. Esc and then Tab moves on.'),
  );
}

function faultButton(text: HTMLTextAreaElement, fault: Diagnostic): HTMLElement {
  return h(
    'button',
    { type: 'button', class: `fault ${fault.level}`, onclick: () => goTo(text, fault) },
    icon('warning'),
    h(
      'span',
      {},
      fault.line === null ? '' : `Line ${fault.line}: `,
      ...inline(fault.message),
      ...(fault.hint && splitCommands(fault.hint).page ? [' – ', ...inline(splitCommands(fault.hint).page)] : []),
    ),
  );
}

function goTo(text: HTMLTextAreaElement, fault: Diagnostic): void {
  if (fault.line === null) return;
  const before = text.value.split('\n').slice(0, fault.line - 1);
  const start = before.reduce((sum, line) => sum + line.length + 1, 0) + (fault.column ?? 1) - 1;
  text.focus();
  text.setSelectionRange(start, start + (fault.length ?? 0));
}

/** Whether the next Tab leaves the text. */
let leaves = false;

/** Tab indents, as YAML wants blanks; after Escape it moves on. */
function indent(text: HTMLTextAreaElement, event: KeyboardEvent): void {
  if (event.key === 'Escape') {
    leaves = true;
    event.stopPropagation();
    return;
  }
  const moves = event.key === 'Tab' && (leaves || event.shiftKey);
  if (event.key !== 'Shift') leaves = false;
  if (event.key !== 'Tab' || moves) return;
  event.preventDefault();
  text.setRangeText('  ', text.selectionStart, text.selectionEnd, 'end');
  text.dispatchEvent(new Event('input'));
}
