import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Undo } from '../../src/app/undo.ts';
import { EMPTY } from '../../src/markers/empty.ts';
import { Painting } from '../../src/paint/painting.ts';
import type { MeshFacts, Session } from '../../src/protocol/types.ts';
import { flush, signal } from '../../src/ui/signal.ts';

Object.assign(globalThis, { window: { setTimeout: () => 0 } });

/** Points and settings with numbered steps, as the server has them, and a mask. */
function studio() {
  let last = 0;
  const steps = (name: string) => {
    const document = signal({ ...EMPTY });
    const [past, future]: { title: string; order: number }[][] = [[], []];
    const show = () => {
      const [undo, redo] = [past.at(-1), future.at(-1)];
      const [undo_order, redo_order] = [undo?.order ?? null, redo?.order ?? null];
      document.value = { ...EMPTY, undo: undo?.title ?? null, undo_order, redo: redo?.title ?? null, redo_order };
      flush();
    };
    return {
      document,
      pipeline: document,
      pairs: signal([]),
      waiting: signal(0),
      saving: signal(false),
      settled: async () => {},
      dropUnsent: () => false,
      change: () => {
        last += 1;
        past.push({ title: name, order: last });
        future.length = 0;
        show();
      },
      step: async (redo: boolean) => {
        const [from, to] = redo ? [future, past] : [past, future];
        to.push(...from.splice(-1));
        show();
        return true;
      },
    };
  };
  const painting = new Painting();
  const facts = { file: 'camel.glb', vertices: 1 } as MeshFacts;
  painting.open({ name: 'camel', source: facts, target: facts } as Session);
  const [markers, pipeline] = [steps('move nose'), steps('set output')];
  const socket = { connection: signal('open') };
  const undo = new Undo({ markers, pipeline, painting, socket } as unknown as ConstructorParameters<typeof Undo>[0]);
  const stroke = () => {
    painting.begin('the stroke');
    painting.draft().mask.dab(0, 0, 0.1);
    painting.changed();
  };
  return { markers, pipeline, painting, undo, stroke };
}

test('points, settings and strokes are undone in the order in which they were done, and done again likewise', async () => {
  const { markers, pipeline, stroke, undo } = studio();
  stroke();
  markers.change();
  stroke();
  stroke();
  pipeline.change();
  const undone: string[] = [];
  for (let due = undo.due(false); due; due = undo.due(false)) {
    undone.push(due.title);
    await undo.step(false);
  }
  assert.deepEqual(undone, ['set output', 'the stroke', 'the stroke', 'move nose', 'the stroke']);
  const again: string[] = [];
  for (let due = undo.due(true); due; due = undo.due(true)) {
    again.push(due.title);
    await undo.step(true);
  }
  assert.deepEqual(again, undone.toReversed());
});

test('a new step ends what could be done again, of whatever kind', async () => {
  const { markers, pipeline, painting, stroke, undo } = studio();
  markers.change();
  pipeline.change();
  await undo.step(false);
  stroke();
  assert.equal(undo.due(true), null);
  assert.equal(undo.due(false)?.title, 'the stroke');
  await undo.step(false);
  assert.equal(undo.due(true)?.title, 'the stroke');
  markers.change();
  assert.equal(undo.due(true), null);
  assert.equal(painting.due(true), null);
});

test('a server that was started anew numbers its steps anew, and later ones are undone first', async () => {
  const { markers, stroke, undo, painting } = studio();
  for (let i = 0; i < 5; i++) markers.change();
  stroke();
  markers.document.value = { ...EMPTY, undo: 'move ear', undo_order: 1 };
  undo.rebase();
  assert.equal(undo.due(false)?.title, 'the stroke');
  markers.document.value = { ...EMPTY, undo: 'move tail', undo_order: 2 };
  assert.equal(undo.due(false)?.title, 'move tail');
  assert.ok(painting.due(false));
});
