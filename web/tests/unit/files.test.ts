import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kindOf } from '../../src/start/browser.ts';

test('files are called what they are', () => {
  const kinds = ['a.markers.yaml', 'run.json', 'hump.target.mask.json'].map((name) =>
    kindOf({ name, kind: 'markers' }),
  );
  assert.deepEqual(kinds, ['pairs', 'report of a run', 'mask']);
  assert.equal(kindOf({ name: 'run.json', kind: 'other' }), 'file');
});
