import { resultPanel } from '../live/panel.ts';
import { Player, timeline } from '../live/timeline.ts';
import { conflictList } from '../markers/conflicts.ts';
import { pairDetail } from '../markers/detail.ts';
import { pairList } from '../markers/list.ts';
import { Painter } from '../paint/painter.ts';
import { paintPanel } from '../paint/panel.ts';
import { type Failure, sentence } from '../protocol/client.ts';
import type { Diagnostic } from '../protocol/types.ts';
import { stagesPanel } from '../stages/panel.ts';
import { startPage } from '../start/start.ts';
import { button, releaseLists } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { type IconName, icon } from '../ui/icons.ts';
import { noticeLine } from '../ui/noticeline.ts';
import { inline } from '../ui/prose.ts';
import { detached, effect } from '../ui/signal.ts';
import { furnishPane } from '../views/heads.ts';
import type { Pane } from '../views/pane.ts';
import { Stage } from '../views/stage.ts';
import { viewToolbar } from '../views/toolbar.ts';
import { Actions } from './actions.ts';
import { topBar } from './bar.ts';
import { makeCommands, paneKey } from './commands.ts';
import { openHelp } from './help.ts';
import { commandFor, type Keys, strokeOf } from './keys.ts';
import type { Panel, Studio } from './studio.ts';

/** Puts the page together. */
export function mount(root: HTMLElement, studio: Studio): Stage {
  const stage = new Stage(studio);
  const actions = new Actions(studio, stage);
  const player = new Player(studio);
  const painter = new Painter(studio, stage);
  const commands = makeCommands(studio, stage, actions, player);
  const furnished = new WeakSet<Pane>();
  effect(() => {
    for (const pane of stage.panes.value) {
      if (furnished.has(pane)) continue;
      furnished.add(pane);
      detached(() => furnishPane(pane, studio));
    }
  });
  const work = h(
    'main',
    { class: 'work' },
    sidePanel(studio, stage, actions, painter),
    h(
      'div',
      { class: 'views' },
      h('div', { class: 'view-bar' }, viewToolbar(studio, stage), noticeLine()),
      stage.element,
      timeline(studio, player),
    ),
  );
  const cover = h('main', { class: 'cover' });
  effect(() => {
    const phase = studio.phase.value;
    work.hidden = phase.name !== 'ready';
    cover.hidden = phase.name === 'ready';
    if (phase.name === 'start') fill(cover, startPage(studio));
    else if (phase.name === 'loading')
      fill(
        cover,
        h('div', { class: 'message', role: 'status' }, h('div', { class: 'spinner' }), h('p', {}, phase.text)),
      );
    else if (phase.name === 'failed') fill(cover, failure(studio, phase));
  });
  root.append(
    topBar(studio, () => openHelp(commands)),
    work,
    cover,
  );
  releaseLists(document);
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape' && studio.canLeaveChoice() && !document.querySelector('dialog[open], :popover-open')) {
      void studio.load();
      return;
    }
    if (studio.phase.peek().name !== 'ready' || document.querySelector('dialog[open]')) return;
    const pane = stage.panes.peek().find((other) => other.surfaceElement === event.target);
    if (pane && !event.ctrlKey && !event.metaKey && paneKey(stage, pane, event)) return event.preventDefault();
    if (pane === undefined && event.key === ' ' && event.target instanceof HTMLButtonElement) return;
    const command = commandFor(commands, strokeOf(event), keysOf(event.target));
    if (!command) return;
    event.preventDefault();
    command.run();
  });
  return stage;
}

/** What keys do in an element: they write, they choose from a list, or they are those of the page. */
function keysOf(target: EventTarget | null): Keys {
  if (target instanceof HTMLSelectElement) return 'choose';
  if (target instanceof HTMLTextAreaElement) return 'write';
  const isText =
    target instanceof HTMLInputElement && !['range', 'radio', 'checkbox', 'button', 'file'].includes(target.type);
  return isText ? 'write' : 'command';
}

function failure(studio: Studio, { message, hint, diagnostics }: Failure): HTMLElement {
  return h(
    'div',
    { class: 'message failed', role: 'alert' },
    icon('warning'),
    h('h1', {}, 'This could not be opened'),
    h('p', {}, ...inline(message)),
    hint ? h('p', { class: 'hint' }, ...inline(hint)) : null,
    diagnostics.length > 0 ? h('ul', { class: 'diagnostics' }, ...diagnostics.map(diagnosticItem)) : null,
    h(
      'div',
      { class: 'row' },
      button({ label: 'Choose other files', kind: 'primary', run: () => studio.chooseFiles() }),
      button({ label: 'Try again', run: () => void studio.load() }),
    ),
  );
}

function diagnosticItem(fault: Diagnostic): HTMLElement {
  const place = [fault.file, fault.line, fault.column].filter((part) => part !== null).join(':');
  return h(
    'li',
    {},
    place ? h('strong', {}, `${place} `) : null,
    ...inline(sentence(fault.message)),
    ...(fault.hint ? [' ', ...inline(sentence(fault.hint))] : []),
  );
}

const TABS: { panel: Panel; label: string; icon: IconName }[] = [
  { panel: 'points', label: 'Pairs', icon: 'target' },
  { panel: 'result', label: 'Result', icon: 'eye' },
  { panel: 'stages', label: 'Stages', icon: 'list' },
  { panel: 'paint', label: 'Paint', icon: 'brush' },
];

function sidePanel(studio: Studio, stage: Stage, actions: Actions, painter: Painter): HTMLElement {
  const pages: Record<Panel, HTMLElement> = {
    points: h(
      'div',
      { class: 'panel-fill' },
      conflictList(studio),
      pairList(studio, actions),
      pairDetail(studio, actions),
    ),
    result: resultPanel(studio, stage),
    stages: stagesPanel(studio),
    paint: paintPanel(studio, painter),
  };
  const tabs = TABS.map(({ panel, label, icon: name }) => {
    const tab = h(
      'button',
      {
        type: 'button',
        role: 'tab',
        id: `tab-${panel}`,
        'aria-controls': `panel-${panel}`,
        onclick: () => {
          studio.panel.value = panel;
        },
        onkeydown: (event: KeyboardEvent) => moveTab(studio, panel, event),
      },
      icon(name),
      label,
    );
    pages[panel].id = `panel-${panel}`;
    pages[panel].setAttribute('role', 'tabpanel');
    pages[panel].setAttribute('aria-labelledby', `tab-${panel}`);
    effect(() => {
      const current = studio.panel.value === panel;
      tab.setAttribute('aria-selected', String(current));
      tab.tabIndex = current ? 0 : -1;
      pages[panel].hidden = !current;
    });
    return tab;
  });
  const element = h(
    'aside',
    { class: 'panel', 'aria-label': 'Tools' },
    h('div', { class: 'tabs', role: 'tablist' }, ...tabs),
    ...Object.values(pages),
  );
  effect(() => {
    element.dataset.panel = studio.panel.value;
  });
  return element;
}

function moveTab(studio: Studio, panel: Panel, event: KeyboardEvent): void {
  const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
  if (step === 0) return;
  const index = TABS.findIndex((tab) => tab.panel === panel);
  studio.panel.value = TABS[(index + step + TABS.length) % TABS.length].panel;
  document.getElementById(`tab-${studio.panel.value}`)?.focus();
  event.stopPropagation();
}
