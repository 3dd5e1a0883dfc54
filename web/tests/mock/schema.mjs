// A small pipeline schema of the same make as that of the program.
import { readFileSync } from 'node:fs';

const variable = { $ref: '#/$defs/Variable' };
const number = (description, rest) => ({
  description,
  default: rest.default,
  anyOf: [{ type: 'number', ...rest }, variable],
});

const small = {
  $schema: 'https://json-schema.org/draft/2020-12/schema',
  title: 'Pipeline',
  type: 'object',
  additionalProperties: false,
  properties: {
    source: {
      description: 'The mesh that gives its motion, at rest and in its poses.',
      anyOf: [{ $ref: '#/$defs/Source' }, variable],
    },
    target: { description: 'The mesh that takes the motion.', anyOf: [{ $ref: '#/$defs/Source' }, variable] },
    correspondence: {
      description: 'How triangles are paired.',
      anyOf: [{ 'x-stage': 'correspondence', $ref: '#/$defs/Correspondence' }, { type: 'null' }, variable],
    },
    transfer: {
      description: 'How poses are carried over.',
      anyOf: [{ 'x-stage': 'transfer', $ref: '#/$defs/Transfer' }, variable],
    },
    output: {
      description: 'The files that are written.',
      'x-file': true,
      anyOf: [{ type: 'string' }, { type: 'array', items: { type: 'string' } }],
    },
  },
  $defs: {
    Variable: { description: 'The value of a variable.', type: 'string', pattern: '^\\$\\{[^{}]+\\}$' },
    Source: {
      type: 'object',
      additionalProperties: false,
      properties: {
        rest: { type: 'string', description: 'The mesh at rest.', 'x-file': true },
        up: { description: 'The axis that points up.', enum: ['x', 'y', 'z'] },
      },
    },
    Correspondence: {
      oneOf: [
        {
          type: 'object',
          description: 'The same numbers on both meshes.',
          properties: { type: { const: 'identity' } },
          required: ['type'],
          additionalProperties: false,
        },
        {
          type: 'object',
          description: 'Brings the source onto the target, guided by `markers`, and takes closest triangles.',
          properties: {
            type: { const: 'nonrigid_fit' },
            steps: {
              description: 'Steps of the fit.',
              default: 4,
              anyOf: [{ type: 'integer', minimum: 1, maximum: 20 }, variable],
            },
            smoothness: number('Weight of smoothness.', { default: 1, minimum: 0 }),
          },
          required: ['type'],
          additionalProperties: false,
        },
      ],
    },
    Transfer: {
      oneOf: [
        {
          type: 'object',
          description: 'Carries deformation gradients over (Sumner and Popović 2004).',
          properties: {
            type: { const: 'gradient' },
            sampling: {
              description: 'Where gradients are read.',
              default: 'points',
              oneOf: [
                { const: 'points', description: 'At points of each triangle.' },
                { const: 'triangles', description: 'Once a triangle.' },
              ],
            },
            tolerance: number('The change at which steps end.', { default: 0.02, exclusiveMinimum: 0, maximum: 1 }),
            robust: {
              description: 'Whether outliers count less.',
              default: true,
              anyOf: [{ type: 'boolean' }, variable],
            },
          },
          required: ['type'],
          additionalProperties: false,
        },
        {
          type: 'object',
          description: 'Moves the target by a few handles (Yang et al. 2018).',
          properties: {
            type: { const: 'biharmonic' },
            weights: {
              description: 'How the influence of handles spreads.',
              anyOf: [{ 'x-stage': 'weights', $ref: '#/$defs/Weights' }, variable],
              default: { type: 'bounded_biharmonic' },
            },
            residual: { description: 'Whether the target takes what the maps leave.', default: true, type: 'boolean' },
          },
          required: ['type'],
          additionalProperties: false,
        },
      ],
    },
    Weights: {
      oneOf: [
        {
          type: 'object',
          description: 'The smoothest weights between 0 and 1.',
          properties: {
            type: { const: 'bounded_biharmonic' },
            bridge: number('Strength of bridges between components.', { default: 0.5, minimum: 0 }),
          },
          required: ['type'],
        },
        {
          type: 'object',
          description: 'Weights by inverse distance.',
          properties: {
            type: { const: 'geodesic_falloff' },
            power: number('How fast weights fall off.', { default: 2, minimum: 1, maximum: 16 }),
          },
          required: ['type'],
        },
      ],
    },
  },
};

export const schema = process.env.MOCK_SCHEMA ? JSON.parse(readFileSync(process.env.MOCK_SCHEMA, 'utf8')) : small;
