import assert from 'node:assert/strict';
import { test } from 'node:test';
import { past } from '../../src/app/past.ts';
import { nearestFrame, playableStep, preparation } from '../../src/live/ahead.ts';
import { ALL, chosenClip, clipSetting, SEVERAL } from '../../src/live/clip.ts';
import { needOf } from '../../src/markers/order.ts';
import { withoutPartner } from '../../src/markers/partners.ts';
import { maskSetting, rigidSetting } from '../../src/paint/setting.ts';
import type { Ahead, Pair } from '../../src/protocol/types.ts';
import { readable, readableIn } from '../../src/ui/words.ts';

const present = { revision: 4, pipeline: 2, scalar: null };
const ahead: Ahead = { revision: 4, pipeline: 2, done: 30, count: 30, step: 1, scalar: null, error: null };

test('results are played only when all of them are there, and of the present state', () => {
  assert.equal(playableStep(ahead, present), 1);
  assert.equal(playableStep({ ...ahead, step: 3 }, present), 3);
  assert.equal(playableStep({ ...ahead, done: 12 }, present), null);
  assert.equal(playableStep(ahead, { ...present, revision: 5 }), null);
  assert.equal(playableStep(ahead, { ...present, pipeline: 3 }), null);
  assert.equal(playableStep(ahead, { ...present, scalar: 'edge_stretch' }), null);
  assert.equal(playableStep(null, present), null);
  assert.equal(playableStep({ ...ahead, done: 0, count: 0 }, present), null);
});

test('what is missing is told in words', () => {
  assert.match(preparation({ ...ahead, done: 12 }, present), /12 of 30 frames/);
  assert.match(preparation({ ...ahead, done: 12 }, { ...present, revision: 5 }), /being prepared/);
  const error = { code: 'x', message: 'three pairs are needed', hint: null, diagnostics: [] };
  assert.match(preparation({ ...ahead, error }, present), /three pairs are needed/);
});

test('of a clip with some frames the nearest before is played', () => {
  assert.deepEqual(
    [0, 1, 2, 3, 7].map((frame) => nearestFrame(frame, 3)),
    [0, 0, 0, 3, 6],
  );
});

test('another clip keeps the other settings of the poses', () => {
  const pose = (clip: string | null) => ({ name: '', clip, seconds: null });
  const clips = ['Run', 'Walk'].map((name) => ({ name, seconds: 1, frames: 2 }));
  const chosen = (names: (string | null)[], all = clips) => chosenClip({ list: names.map(pose), clips: all });
  assert.equal(chosen(['Run', 'Run']), 'Run');
  assert.equal(chosen(['Run', 'Walk']), ALL);
  assert.equal(chosen(['Run', 'Walk'], [...clips, { name: 'Turn', seconds: 1, frames: 2 }]), SEVERAL);
  assert.equal(chosen([null]), null);
  assert.deepEqual(clipSetting({ source: { rest: 'a.glb' } }, 'Run'), {
    path: ['source', 'poses'],
    value: { clip: 'Run' },
  });
  assert.deepEqual(clipSetting({ source: { poses: { clip: 'Walk', fps: 12 } } }, 'Run'), {
    path: ['source', 'poses', 'clip'],
    value: 'Run',
  });
  assert.deepEqual(clipSetting({ source: { poses: 'a-*.obj' } }, 'Run').value, { clip: 'Run' });
});

test('a mask goes where the pipeline takes it, beside what is there', () => {
  const at = (pipeline: unknown) => maskSetting(pipeline, 'jaw*', '/x/jaw.target.mask.json');
  const file = { file: 'jaw.target.mask.json' };
  assert.deepEqual([at({}).path, at({}).value], [['shapes'], { masks: { 'jaw*': file } }]);
  assert.deepEqual(at({ shapes: { only: 'a' } }).path, ['shapes', 'masks']);
  assert.deepEqual(at({ shapes: { masks: { '*': file } } }).path, ['shapes', 'masks', 'jaw*']);
  const rigid = rigidSetting({ transfer: { type: 'gradient' } }, ['eye 1']);
  assert.deepEqual([rigid.path, rigid.value], [['transfer'], { type: 'multi_component', rigid: ['eye 1'] }]);
  assert.deepEqual(rigidSetting({ transfer: { type: 'multi_component', k: 1 } }, ['eye 1']).path, [
    'transfer',
    'rigid',
  ]);
});

test('names and steps read well', () => {
  assert.equal(readable('limb2-1'), 'Limb 2, point 1');
  assert.equal(readable('place-3'), 'Place, point 3');
  assert.equal(readable('left-1'), 'left-1');
  assert.equal(readable('nose'), 'nose');
  assert.equal(past('set transfer.type to gradient'), 'set transfer.type to gradient');
  assert.equal(past('changes in the file'), 'changes in the file');
});

test('messages name pairs as the list does, and leave keys, files and code', () => {
  assert.equal(readableIn('moved limb2-1'), 'moved Limb 2, point 1');
  assert.equal(past('move limb2-1'), 'moved Limb 2, point 1');
  assert.equal(
    readableIn('its mirror image is marker limb3-2 on the source only'),
    'its mirror image is Limb 3, point 2 on the source only',
  );
  assert.equal(readableIn('moved limb6-2 mirrored'), 'moved Limb 6, point 2, mirrored');
  assert.equal(readable('limb6-2 mirrored 2'), 'Limb 6, point 2, mirrored 2');
  assert.equal(readable('nose mirrored'), 'nose, mirrored');
  assert.equal(past('move point 12'), 'moved pair 12');
  assert.equal(
    readableIn('Add a marker at marker 28, 3 markers lie there'),
    'Add a pair at pair 28, 3 pairs lie there',
  );
  for (const kept of [
    'set markers: to a',
    'read a.markers.yaml',
    '`marker` is no key',
    'mimesh-markers',
    'Limb 2, point 1',
  ])
    assert.equal(readableIn(kept), kept);
  assert.equal(readableIn('set output to climb2-1.glb'), 'set output to climb2-1.glb');
});

test('proposals that read alike are one level of doubt', () => {
  const at = (confidence: number) =>
    needOf({ source: { vertex: 0 }, target: { vertex: 0 }, status: 'proposed', confidence } as Pair);
  assert.equal(at(0.4985), at(0.5002));
  assert.equal(at(0.4949), 'doubtful');
});

test('pairs without a partner are named, by the reasons', () => {
  const names = ['limb1-1', 'nose', null, 'ear', 'eye', 'tail'];
  const pairs = names.map((name, i) => ({ id: i, number: i + 1, name }) as Pair);
  const left = pairs.map(({ id }) => ({
    pair: id,
    reason: id === 1 ? 'its mirror image is marker limb3-2' : 'proposed',
  }));
  assert.equal(
    withoutPartner(left, (id) => pairs[id]),
    'Without a partner: Limb 1, point 1, Pair 3, ear and 2 more (proposed); nose (its mirror image is Limb 3, point 2).',
  );
  assert.equal(
    withoutPartner([], () => null),
    null,
  );
});
