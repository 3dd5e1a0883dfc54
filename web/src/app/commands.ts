import type { Player } from '../live/timeline.ts';
import { isolate, showAll, toggleComponent } from '../views/components.ts';
import type { Pane } from '../views/pane.ts';
import type { Stage } from '../views/stage.ts';
import type { Actions } from './actions.ts';
import { display } from './display.ts';
import { openHelp } from './help.ts';
import type { Command } from './keys.ts';
import type { Studio } from './studio.ts';

const NUDGE = 2;
const TURN = 24;

/** Every command that has a key. */
export function makeCommands(studio: Studio, stage: Stage, actions: Actions, player: Player): Command[] {
  const commands: Command[] = [
    command('Pairs', 'next', 'Go to the pair that helps most', ['g'], () => void actions.next()),
    command('Pairs', 'down', 'Select the pair below', ['j'], () => actions.select(1)),
    command('Pairs', 'up', 'Select the pair above', ['k'], () => actions.select(-1)),
    command('Pairs', 'confirm', 'Confirm, and go on', ['c'], () => actions.confirm()),
    command('Pairs', 'skip', 'Skip, or take back into use', ['s'], () => actions.skip()),
    command('Pairs', 'new', 'Begin a new pair', ['n'], () => actions.startNew()),
    command('Pairs', 'rename', 'Rename', ['r', 'f2'], () => actions.editName()),
    command('Pairs', 'delete', 'Delete', ['delete', 'backspace'], () => actions.remove()),
    command('Pairs', 'mirror', 'Mirror across a plane', ['m'], () => actions.mirror()),
    command('Pairs', 'undo', 'Undo', ['mod+z'], () => void studio.history.step(false)),
    command('Pairs', 'redo', 'Redo', ['mod+shift+z', 'mod+y'], () => void studio.history.step(true)),
    command('Pairs', 'letgo', 'Let go of the selected pair', ['escape'], () => letGo(studio, stage)),
    command('View', 'fly', 'Fly to the selected pair', ['f'], () => actions.flyTo(studio.selected.peek())),
    command('View', 'whole', 'See the whole mesh', ['home'], () => stage.camera.whole()),
    command('View', 'front', 'See it from the front', ['1'], () => stage.camera.whole(0, 0)),
    command('View', 'side', 'See it from the side', ['2'], () => stage.camera.whole(Math.PI / 2, 0)),
    command('View', 'top', 'See it from above', ['3'], () => stage.camera.whole(0, Math.PI / 2)),
    command('View', 'wireframe', 'Wireframe', ['w'], () => flip(display.wireframe)),
    command('View', 'xray', 'X-ray', ['x'], () => flip(display.xray)),
    command('View', 'link', 'Link the cameras', ['l'], () => flip(display.linked)),
    command('View', 'views', 'Target at rest in a view of its own', ['v'], () => flip(display.threeViews)),
    command('View', 'hide', 'Hide the component below the pointer', ['h'], () =>
      onComponent(stage, (pane, index) => toggleComponent(studio, pane.side, index)),
    ),
    command('View', 'isolate', 'Show only the component below the pointer', ['i'], () =>
      onComponent(stage, (pane, index) => isolate(studio, pane.side, index)),
    ),
    command('View', 'showall', 'Show all components', ['u'], () => showAll(studio)),
    command('Motion', 'play', 'Play, pause', ['space'], () => player.toggle()),
    command('Motion', 'before', 'Frame before', [','], () => player.step(-1)),
    command('Motion', 'after', 'Frame after', ['.'], () => player.step(1)),
    command('Motion', 'rest', 'Rest', ['0'], () => player.go(null)),
    command('Page', 'search', 'Search pairs', ['/'], () => focusSearch(studio)),
    command('Page', 'help', 'Show these keys', ['?'], () => openHelp(commands)),
  ];
  return commands;
}

/** Keys of a view that has the focus: they turn, zoom, set a point at the centre, and push the selected point about. */
export function paneKey(stage: Stage, pane: Pane, event: KeyboardEvent): boolean {
  const arrows: Record<string, [number, number]> = {
    ArrowLeft: [-1, 0],
    ArrowRight: [1, 0],
    ArrowUp: [0, -1],
    ArrowDown: [0, 1],
  };
  const arrow = arrows[event.key];
  const { width, height } = pane.view;
  if (arrow && event.altKey) stage.markerTool.nudge(pane, arrow[0] * NUDGE, arrow[1] * NUDGE, event.shiftKey);
  else if (arrow && event.shiftKey) stage.camera.pan(pane, -arrow[0] * TURN, -arrow[1] * TURN);
  else if (arrow) stage.camera.turn(pane, arrow[0] * TURN, arrow[1] * TURN);
  else if (event.key === '+' || event.key === '=') stage.camera.zoom(pane, 0.85, width / 2, height / 2);
  else if (event.key === '-') stage.camera.zoom(pane, 1 / 0.85, width / 2, height / 2);
  else if (event.key === 'Enter') stage.tool.peek().click(pane, width / 2, height / 2, null, event.shiftKey);
  else return false;
  return true;
}

function command(group: Command['group'], id: string, title: string, keys: string[], run: () => void): Command {
  return { group, id, title, keys, run };
}

function flip(value: { value: boolean }): void {
  value.value = !value.value;
}

function letGo(studio: Studio, stage: Stage): void {
  if (isField(document.activeElement)) {
    document.activeElement.blur();
  } else {
    studio.selected.value = null;
    stage.camera.letGo();
  }
}

function isField(element: Element | null): element is HTMLElement {
  return (
    element instanceof HTMLInputElement ||
    element instanceof HTMLTextAreaElement ||
    element instanceof HTMLSelectElement
  );
}

function onComponent(stage: Stage, run: (pane: Pane, component: number) => void): void {
  const pane = stage.activePane();
  if (!pane?.surface) return;
  const { x, y } = pane.pointer ?? { x: pane.view.width / 2, y: pane.view.height / 2 };
  const hit = pane.pick(x, y);
  if (hit) run(pane, pane.surface.components[hit.triangle]);
}

function focusSearch(studio: Studio): void {
  studio.panel.value = 'points';
  queueMicrotask(() => document.querySelector<HTMLInputElement>('.points .search input')?.focus());
}
