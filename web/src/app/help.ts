import { openDialog } from '../ui/dialog.ts';
import { h } from '../ui/dom.ts';
import { type Command, displayStroke } from './keys.ts';

const HAND: [string, string][] = [
  ['Click on a mesh', 'Sets a point of the selected pair, or begins a pair'],
  ['Drag a point', 'Moves it over the surface; the target follows'],
  ['Shift', 'While clicking or dragging: snaps to the nearest vertex'],
  ['Drag beside points', 'Turns the view'],
  ['Alt and drag', 'Turns the view, also over points and while painting'],
  ['Right button and drag', 'Moves the view'],
  ['Wheel', 'Zooms to the pointer'],
];

const VIEW_KEYS: [string, string][] = [
  ['← → ↑ ↓', 'Turn the view'],
  ['Shift and arrows', 'Move the view'],
  ['+ and −', 'Zoom'],
  ['Enter', 'Set the point at the centre of the view; with Shift at a vertex'],
  ['Alt and arrows', 'Push the selected point along the surface'],
];

export function openHelp(commands: readonly Command[]): void {
  const groups = (['Pairs', 'View', 'Motion', 'Page'] as const).map((group) =>
    table(
      group,
      commands
        .filter((command) => command.group === group)
        .map((command) => [command.keys.map(displayStroke).join(' or '), command.title]),
    ),
  );
  openDialog(
    'Keys and mouse',
    [
      h(
        'div',
        { class: 'help' },
        table('Mouse', HAND),
        table('In a view that has the focus (Tab)', VIEW_KEYS),
        ...groups,
      ),
    ],
    true,
  );
}

function table(title: string, rows: [string, string][]): HTMLElement {
  return h(
    'section',
    {},
    h('h3', {}, title),
    h('dl', { class: 'keys' }, ...rows.flatMap(([keys, text]) => [h('dt', {}, h('kbd', {}, keys)), h('dd', {}, text)])),
  );
}
