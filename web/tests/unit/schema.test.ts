import assert from 'node:assert/strict';
import { test } from 'node:test';
import YAML from 'yaml';
import { assignment } from '../../src/stages/assign.ts';
import { fieldsOf, flowText, type Json, type NumberField, numberProblem, rangeText } from '../../src/stages/schema.ts';

const variable = { $ref: '#/$defs/Variable' };
const root = {
  properties: {
    rest: { type: 'string', description: 'The mesh.', 'x-file': true },
    weight: { default: 1, anyOf: [{ type: 'number', exclusiveMinimum: 0, maximum: 2 }, variable] },
    count: { anyOf: [{ type: ['integer', 'null'], minimum: 1 }, variable] },
    axis: { oneOf: [{ const: 'x', description: 'Across.' }, { enum: ['y', 'z'] }] },
    mixed: { oneOf: [{ type: 'string' }, { type: 'array', items: { type: 'string' } }] },
    robust: { anyOf: [{ type: 'boolean' }, variable] },
    metrics: {
      type: ['array', 'null'],
      items: { anyOf: [{ 'x-stage': 'metric', $ref: '#/$defs/Transfer' }, variable] },
    },
    numbers: { type: 'array', items: { anyOf: [{ type: 'integer' }, variable] } },
    inner: { anyOf: [{ $ref: '#/$defs/Inner' }, { type: 'null' }], default: { gaps: 0.5 } },
    transfer: {
      anyOf: [
        { 'x-stage': 'transfer', 'x-defaults': { lambda: 3 }, $ref: '#/$defs/Transfer' },
        { type: 'null' },
        variable,
      ],
      default: { type: 'gradient' },
    },
    markers: { anyOf: [{ 'x-stage': 'landmarks', oneOf: [{ type: 'string' }, { $ref: '#/$defs/Transfer' }] }] },
  },
  $defs: {
    Variable: { type: 'string', pattern: '^\\$' },
    Inner: { type: 'object', properties: { gaps: { type: 'number' } } },
    Transfer: {
      oneOf: [
        {
          type: 'object',
          description: 'One.',
          properties: { type: { const: 'gradient' }, lambda: { type: 'number', default: 1 } },
        },
        { type: 'object', description: 'Two.', properties: { type: { const: 'chain' } } },
      ],
    },
  },
};

const fields = new Map(fieldsOf(root, root).map((field) => [field.name, field]));

test('every kind of setting gets its field', () => {
  const kinds = Object.fromEntries([...fields].map(([name, field]) => [name, field.kind]));
  assert.deepEqual(kinds, {
    rest: 'text',
    weight: 'number',
    count: 'number',
    axis: 'enum',
    mixed: 'value',
    robust: 'boolean',
    metrics: 'list',
    numbers: 'value',
    inner: 'object',
    transfer: 'stage',
    markers: 'stage',
  });
  assert.equal(fields.get('rest')?.isFile, true);
  assert.equal(fields.get('count')?.nullable, true);
});

test('a stage has its types, their help, and defaults that its slot changes', () => {
  const transfer = fields.get('transfer');
  assert.ok(transfer?.kind === 'stage');
  assert.deepEqual(
    transfer.types.map((type) => [type.name, type.description]),
    [
      ['gradient', 'One.'],
      ['chain', 'Two.'],
    ],
  );
  assert.equal(transfer.types[0].fields()[0].default, 3);
  assert.equal(transfer.text, false);
  const markers = fields.get('markers');
  assert.ok(markers?.kind === 'stage' && markers.text);
});

test('numbers outside their limits are refused with the reason', () => {
  const weight = fields.get('weight') as NumberField;
  const count = fields.get('count') as NumberField;
  assert.equal(numberProblem(weight, 1.5), null);
  assert.match(numberProblem(weight, 0) ?? '', /more than 0/);
  assert.match(numberProblem(weight, 3) ?? '', /at most 2/);
  assert.match(numberProblem(weight, Number.NaN) ?? '', /no number/);
  assert.match(numberProblem(count, 1.5) ?? '', /whole/);
  assert.equal(rangeText(weight), '0 to 2');
  assert.equal(rangeText(count), 'whole, from 1');
});

test('mappings above a value are made, with the type of a stage that is left out', () => {
  const types = (path: (string | number)[]) => (path.join('.') === 'transfer' ? 'gradient' : null);
  assert.deepEqual(assignment({}, ['transfer', 'lambda'], 2, types), {
    path: ['transfer'],
    value: { type: 'gradient', lambda: 2 },
  });
  assert.deepEqual(assignment({ transfer: { type: 'chain' } }, ['transfer', 'inner', 'gaps'], 2, types), {
    path: ['transfer', 'inner'],
    value: { gaps: 2 },
  });
  assert.deepEqual(assignment(null as never, ['output'], 'x.glb', types), { path: ['output'], value: 'x.glb' });
});

test('values of any kind are texts in YAML, and YAML reads them back', () => {
  const values = [
    'horse.glb',
    ['a', 'b c'],
    { clip: 'Run', fps: 24 },
    3,
    true,
    null,
    '24',
    'yes',
    '',
    'a: b',
    'x, y',
    '1e3',
  ];
  for (const value of [...values, 'horse-??.obj', { files: 'a-{pose}.obj', deep: [{ k: ['#1', '~'] }] }]) {
    const text = flowText(value as Json);
    // Braces of names are guarded by the server before YAML is read.
    assert.deepEqual(YAML.parse(`[${text.replaceAll('{pose}', 'POSE')}]`), [
      JSON.parse(JSON.stringify(value).replaceAll('{pose}', 'POSE')),
    ]);
  }
  assert.equal(flowText({ clip: 'Run', fps: 24 }), '{ clip: Run, fps: 24 }');
});
