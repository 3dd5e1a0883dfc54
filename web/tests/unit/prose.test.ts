import assert from 'node:assert/strict';
import { test } from 'node:test';
import { splitCommands } from '../../src/ui/prose.ts';

test('sentences with commands stand apart from what the page can do', () => {
  const step =
    'Add a marker around vertex 3. `mimesh markers suggest a.glb b.glb` names the point that helps most. Then run again.';
  assert.deepEqual(splitCommands(step), {
    page: 'Add a marker around vertex 3. Then run again.',
    commands: '`mimesh markers suggest a.glb b.glb` names the point that helps most.',
  });
  assert.equal(splitCommands('`mimesh inspect` lists the clips of a file').page, '');
  assert.equal(splitCommands('leave it out for 4').page, 'leave it out for 4');
});
