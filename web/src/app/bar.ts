import { sentence } from '../protocol/client.ts';
import { runControl } from '../stages/run.ts';
import { button } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect } from '../ui/signal.ts';
import { theme, toggleTheme } from '../ui/theme.ts';
import { readableIn } from '../ui/words.ts';
import { openAbout } from './about.ts';
import type { Studio } from './studio.ts';

/** The bar at the top: the project, whether it is saved, and what concerns all of it. */
export function topBar(studio: Studio, help: () => void): HTMLElement {
  const ready = () => studio.phase.value.name === 'ready';
  const name = h('span', { class: 'project' });
  const work = h(
    'div',
    { class: 'bar-work' },
    button({ label: 'Open', icon: 'folder', run: () => studio.chooseFiles() }),
    name,
    saveState(studio),
    h('span', { class: 'spacer' }),
    undoButton(studio, false),
    undoButton(studio, true),
    runControl(studio),
  );
  effect(() => {
    work.hidden = !ready();
    name.textContent = studio.session.value?.name ?? '';
  });
  const dark = button({ label: 'Light or dark', icon: 'sun', bare: true, run: toggleTheme });
  effect(() => fill(dark, icon(theme.value === 'dark' ? 'sun' : 'moon')));
  return h(
    'header',
    { class: 'bar' },
    h('span', { class: 'brand' }, 'mimesh'),
    work,
    h('span', { class: 'spacer' }),
    dark,
    button({ label: 'Keys and mouse', keys: '?', icon: 'help', bare: true, run: help }),
    button({ label: 'About', icon: 'info', bare: true, run: () => void openAbout() }),
  );
}

function undoButton(studio: Studio, redo: boolean): HTMLElement {
  const [label, keys] = redo ? ['Redo', 'Ctrl Shift Z'] : ['Undo', 'Ctrl Z'];
  const due = () => studio.history.due(redo);
  const element = button({
    label,
    keys,
    icon: redo ? 'redo' : 'undo',
    bare: true,
    run: () => void studio.history.step(redo),
    disabled: () => due() === null && (redo || studio.markers.waiting.value === 0),
  });
  effect(() => {
    const step = due();
    element.title = `${label}${step ? `: ${readableIn(step.title)}` : ''} (${keys})`;
  });
  return element;
}

/** Whether every change is on disk, and whether there is a connection. */
function saveState(studio: Studio): HTMLElement {
  const element = h('span', { class: 'save-state', role: 'status', 'aria-live': 'polite' });
  effect(() => {
    const [level, text] = describe(studio);
    element.dataset.level = level;
    element.textContent = text;
    const mistakes = studio.pipeline.mistakes.value.map((one) => sentence(one.message));
    if (mistakes.length > 0) mistakes.push('All is saved as it is. Stages shows where the mistakes are.');
    element.title = [text, ...mistakes, studio.pipeline.pipeline.value?.file, studio.markers.document.value.file]
      .filter(Boolean)
      .join('\n');
  });
  return element;
}

function describe(studio: Studio): ['good' | 'busy' | 'bad', string] {
  const waiting = studio.markers.waiting.value;
  const { disk, disk_error, exists, pairs } = studio.markers.document.value;
  const pipeline = studio.pipeline.pipeline.value;
  if (studio.socket.connection.value !== 'open') {
    const kept = waiting > 0 ? ` · ${waiting} kept in this browser` : '';
    if (studio.refused.value) return ['bad', `The program was started anew: open the address that it printed${kept}`];
    return ['bad', `No connection${kept || ' · trying again'}`];
  }
  const failed = disk === 'failed' ? disk_error : pipeline?.disk === 'failed' ? pipeline.disk_error : undefined;
  if (failed !== undefined) return ['bad', `Not saved: ${failed ?? 'the file cannot be written'}`];
  if (disk === 'changed_elsewhere') return ['bad', 'The file was changed by another program'];
  if (studio.pipeline.mistakes.value.length > 0) return ['bad', 'Mistakes'];
  if (waiting > 0 || studio.pipeline.saving.value) return ['busy', 'Saving …'];
  if (!pipeline?.exists) return ['busy', 'Not written yet'];
  if (studio.painting.hasUnsaved) return ['busy', 'What is painted is not saved'];
  return exists || pairs.length === 0
    ? ['good', 'Saved']
    : ['busy', 'Proposed pairs are saved once you confirm or move one'];
}
