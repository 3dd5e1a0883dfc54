import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type Command, commandFor, displayStroke, strokeOf } from '../../src/app/keys.ts';

function press(
  key: string,
  more: Partial<Record<'ctrlKey' | 'metaKey' | 'shiftKey' | 'altKey', boolean>> = {},
): string {
  return strokeOf({ key, ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...more });
}

test('strokes have one spelling', () => {
  assert.equal(press('Z', { ctrlKey: true, shiftKey: true }), 'mod+shift+z');
  assert.equal(press('z', { metaKey: true }), 'mod+z');
  assert.equal(press(' '), 'space');
  assert.equal(press('?', { shiftKey: true }), '?');
  assert.equal(press('ArrowLeft', { altKey: true }), 'alt+arrowleft');
});

test('a text field keeps its keys, and a list those that it is chosen from by', () => {
  const keys = ['mod+z', 'escape', 'j', ','];
  const command: Command = { id: 'undo', title: '', group: 'Pairs', keys, run: () => {} };
  for (const key of keys) assert.equal(commandFor([command], key, 'command'), command);
  assert.deepEqual(
    keys.filter((key) => commandFor([command], key, 'write')),
    ['escape'],
  );
  assert.deepEqual(
    keys.filter((key) => commandFor([command], key, 'choose')),
    ['mod+z', 'escape', ','],
  );
  assert.equal(commandFor([command], 'x', 'command'), null);
});

test('strokes are shown as people know them', () => {
  assert.equal(displayStroke('mod+shift+z'), 'Ctrl Shift Z');
  assert.equal(displayStroke('space'), 'Space');
});
