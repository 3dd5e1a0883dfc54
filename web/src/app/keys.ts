/** The keys of the page. Pure: what an event means, and which keys a command has. */

export interface KeyLike {
  key: string;
  ctrlKey: boolean;
  metaKey: boolean;
  shiftKey: boolean;
  altKey: boolean;
}

/** A stroke in one spelling, e.g. `mod+shift+z`; `mod` is Ctrl, or Command on a Mac. */
export function strokeOf(event: KeyLike): string {
  const key = event.key === ' ' ? 'space' : event.key.toLowerCase();
  // The character of `?` already holds the shift that some keyboards need for it.
  const shift = event.shiftKey && (key.length > 1 || /[a-z]/.test(key));
  return [event.ctrlKey || event.metaKey ? 'mod' : '', event.altKey ? 'alt' : '', shift ? 'shift' : '', key]
    .filter(Boolean)
    .join('+');
}

export interface Command {
  id: string;
  title: string;
  group: 'Pairs' | 'View' | 'Motion' | 'Page';
  keys: string[];
  run: () => void;
}

/** What keys do where the focus is. */
export type Keys = 'write' | 'choose' | 'command';

/**
 * The command of a stroke. A text field keeps its keys, undo among them, and a list those that it is chosen from by: letters, digits,
 * arrows and the like. Escape leaves both.
 */
export function commandFor(commands: readonly Command[], stroke: string, keys: Keys): Command | null {
  if (keys === 'write' && stroke !== 'escape') return null;
  if (keys === 'choose' && !/^(escape|delete|mod\+.*|[^a-z0-9])$/.test(stroke)) return null;
  return commands.find((command) => command.keys.includes(stroke)) ?? null;
}

const NAMES: Record<string, string> = {
  mod: 'Ctrl',
  alt: 'Alt',
  shift: 'Shift',
  space: 'Space',
  enter: 'Enter',
  escape: 'Esc',
  delete: 'Del',
  backspace: '⌫',
  home: 'Home',
  arrowleft: '←',
  arrowright: '→',
  arrowup: '↑',
  arrowdown: '↓',
};

/** A stroke as people read it. */
export function displayStroke(stroke: string): string {
  return stroke
    .split('+')
    .map((part) => NAMES[part] ?? (part.length === 1 ? part.toUpperCase() : part))
    .join(' ');
}
