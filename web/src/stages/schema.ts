/** What a form must know of a JSON Schema: the schema of the pipeline, read field by field. Pure. */

export type Json = null | boolean | number | string | Json[] | { [key: string]: Json };
export interface Schema {
  [key: string]: unknown;
}

interface Common {
  name: string;
  description: string;
  default: Json | undefined;
  nullable: boolean;
  isFile: boolean;
  isCommand: boolean;
  examples: Json[];
}

export interface NumberField extends Common {
  kind: 'number';
  integer: boolean;
  minimum: number | null;
  maximum: number | null;
  /** Whether the limits themselves are allowed. */
  openMinimum: boolean;
  openMaximum: boolean;
}

export interface EnumField extends Common {
  kind: 'enum';
  options: { value: string; description: string }[];
}

export interface StageField extends Common {
  kind: 'stage';
  stage: string;
  types: StageType[];
  /** Whether a text may stand in place of a stage, such as the name of a file. */
  text: boolean;
}

export interface StageType {
  name: string;
  description: string;
  fields: () => Field[];
}

export interface ObjectField extends Common {
  kind: 'object';
  fields: () => Field[];
}

/** A sequence of stages or mappings; sequences of simple values are edited as one text. */
export interface ListField extends Common {
  kind: 'list';
  item: () => StageField | ObjectField;
}

export interface PlainField extends Common {
  kind: 'boolean' | 'text' | 'value';
}

export type Field = NumberField | EnumField | StageField | ObjectField | ListField | PlainField;

/** The fields of an object schema. */
export function fieldsOf(schema: Schema, root: Schema, defaults: Json | undefined = undefined): Field[] {
  const properties = (resolve(schema, root).properties ?? {}) as Record<string, Schema>;
  return Object.entries(properties)
    .filter(([name]) => name !== 'type')
    .map(([name, property]) => readField(name, property, root, member(defaults, name)));
}

function readField(name: string, schema: Schema, root: Schema, slotDefault: Json | undefined): Field {
  const flat = flatten(schema, root);
  const common: Common = {
    name,
    description: String(schema.description ?? flat.description ?? ''),
    default: mergeDefaults(schema.default as Json | undefined, slotDefault),
    nullable: flat.nullable,
    isFile: flat.isFile,
    isCommand: flat.isCommand,
    examples: (schema.examples ?? []) as Json[],
  };
  const { alternatives } = flat;
  const types = alternatives.filter((one) => constOf(one, root) !== null);
  if (flat.stage !== null || (types.length > 0 && types.length === alternatives.length)) {
    return {
      ...common,
      kind: 'stage',
      stage: flat.stage ?? name,
      types: types.map((one) => readType(one, root, flat.defaults)),
      text: alternatives.some((one) => one.type === 'string' && !('const' in one)),
    };
  }
  const options = enumOptions(alternatives);
  if (options) return { ...common, kind: 'enum', options };
  if (alternatives.length !== 1) return { ...common, kind: 'value' };
  return readSingle(common, alternatives[0], root);
}

function readSingle(common: Common, schema: Schema, root: Schema): Field {
  const types = Array.isArray(schema.type) ? schema.type.filter((type) => type !== 'null') : [schema.type];
  if (types.length !== 1) return { ...common, kind: 'value' };
  switch (types[0]) {
    case 'number':
    case 'integer':
      return {
        ...common,
        kind: 'number',
        integer: types[0] === 'integer',
        minimum: numberOr(schema.minimum, schema.exclusiveMinimum),
        maximum: numberOr(schema.maximum, schema.exclusiveMaximum),
        openMinimum: schema.exclusiveMinimum !== undefined,
        openMaximum: schema.exclusiveMaximum !== undefined,
      };
    case 'boolean':
      return { ...common, kind: 'boolean' };
    case 'string':
      return { ...common, kind: 'text' };
    case 'object':
      if (schema.properties === undefined) return { ...common, kind: 'value' };
      return { ...common, kind: 'object', fields: () => fieldsOf(schema, root, common.default) };
    case 'array':
      return readList(common, schema, root);
    default:
      return { ...common, kind: 'value' };
  }
}

function readList(common: Common, schema: Schema, root: Schema): Field {
  if (schema.items === undefined) return { ...common, kind: 'value' };
  const item = readField(common.name, schema.items as Schema, root, undefined);
  if (item.kind !== 'stage' && item.kind !== 'object') return { ...common, kind: 'value' };
  return { ...common, kind: 'list', item: () => item };
}

function readType(schema: Schema, root: Schema, defaults: Json | undefined): StageType {
  return {
    name: constOf(schema, root) ?? '',
    description: String(schema.description ?? ''),
    fields: () => fieldsOf(schema, root, defaults),
  };
}

interface Flat {
  alternatives: Schema[];
  nullable: boolean;
  stage: string | null;
  isFile: boolean;
  isCommand: boolean;
  defaults: Json | undefined;
  description: string | null;
}

/** All that may stand at a place, with `anyOf`, `oneOf` and references opened, and without null and variables. */
function flatten(schema: Schema, root: Schema): Flat {
  const flat: Flat = {
    alternatives: [],
    nullable: false,
    stage: null,
    isFile: false,
    isCommand: false,
    defaults: undefined,
    description: null,
  };
  visit(schema, 0);
  return flat;

  function visit(node: Schema, depth: number): void {
    if (depth > 12) return;
    if (typeof node['x-stage'] === 'string') flat.stage = node['x-stage'];
    if (node['x-defaults'] !== undefined) flat.defaults = node['x-defaults'] as Json;
    flat.isFile ||= node['x-file'] === true;
    flat.isCommand ||= node['x-command'] === true;
    if (node.$ref === '#/$defs/Variable' || node.$ref === '#/$defs/Settings') return;
    const own = resolve(node, root);
    if (own !== node) flat.description ??= typeof own.description === 'string' ? own.description : null;
    const inner = (own.anyOf ?? own.oneOf) as Schema[] | undefined;
    if (own.type === 'null') flat.nullable = true;
    else if (inner) for (const one of inner) visit(one, depth + 1);
    else {
      if (Array.isArray(own.type) && own.type.includes('null')) flat.nullable = true;
      flat.alternatives.push(own);
    }
  }
}

function resolve(schema: Schema, root: Schema): Schema {
  let present = schema;
  for (let depth = 0; typeof present.$ref === 'string' && depth < 12; depth++) {
    const steps = present.$ref.replace(/^#\//, '').split('/');
    let found: unknown = root;
    for (const step of steps) found = (found as Record<string, unknown> | undefined)?.[step];
    if (found === undefined) return {};
    present = found as Schema;
  }
  return present;
}

function constOf(schema: Schema, root: Schema): string | null {
  const properties = resolve(schema, root).properties as Record<string, Schema> | undefined;
  const type = properties?.type?.const;
  return typeof type === 'string' ? type : null;
}

function enumOptions(alternatives: Schema[]): EnumField['options'] | null {
  const options: EnumField['options'] = [];
  for (const one of alternatives) {
    const description = String(one.description ?? '');
    if (typeof one.const === 'string') options.push({ value: one.const, description });
    else if (Array.isArray(one.enum)) {
      options.push(...one.enum.filter((value) => typeof value === 'string').map((value) => ({ value, description })));
    } else return null;
  }
  return options.length > 0 ? options : null;
}

/** The type of a stage that a value names; of a bare text and of nothing, none. */
export function typeOf(value: Json | undefined): string | null {
  const type = member(value, 'type');
  return typeof type === 'string' ? type : null;
}

export function member(value: Json | undefined, key: string | number): Json | undefined {
  if (value === null || typeof value !== 'object') return undefined;
  return (value as Record<string | number, Json>)[key];
}

export function valueAt(value: Json | undefined, path: readonly (string | number)[]): Json | undefined {
  return path.reduce<Json | undefined>((present, step) => member(present, step), value);
}

function mergeDefaults(own: Json | undefined, slot: Json | undefined): Json | undefined {
  if (slot === undefined) return own;
  if (isObject(own) && isObject(slot)) return { ...own, ...slot };
  return slot;
}

export function isObject(value: Json | undefined): value is { [key: string]: Json } {
  return value !== null && typeof value === 'object' && !Array.isArray(value);
}

function numberOr(...values: unknown[]): number | null {
  return values.find((value): value is number => typeof value === 'number') ?? null;
}

/** Why a number may not stand in a field; null if it may. */
export function numberProblem(field: NumberField, value: number): string | null {
  if (!Number.isFinite(value)) return 'This is no number.';
  if (field.integer && !Number.isInteger(value)) return 'This must be a whole number.';
  const { minimum, maximum } = field;
  if (minimum !== null && (value < minimum || (field.openMinimum && value === minimum))) {
    return `This must be ${field.openMinimum ? 'more than' : 'at least'} ${minimum}.`;
  }
  if (maximum !== null && (value > maximum || (field.openMaximum && value === maximum))) {
    return `This must be ${field.openMaximum ? 'less than' : 'at most'} ${maximum}.`;
  }
  return null;
}

/** The limits of a number, for people. */
export function rangeText(field: NumberField): string {
  const { minimum, maximum } = field;
  const whole = field.integer ? 'whole, ' : '';
  if (minimum !== null && maximum !== null) return `${whole}${minimum} to ${maximum}`;
  if (minimum !== null) return `${whole}${field.openMinimum ? 'more than' : 'from'} ${minimum}`;
  if (maximum !== null) return `${whole}${field.openMaximum ? 'less than' : 'up to'} ${maximum}`;
  return field.integer ? 'whole' : '';
}

/** The text of a value of any kind, as it may stand in YAML on one line. */
export function flowText(value: Json | undefined): string {
  if (value === undefined) return '';
  if (typeof value === 'string') return plain(value) ? value : JSON.stringify(value);
  if (Array.isArray(value)) return `[${value.map(flowText).join(', ')}]`;
  if (isObject(value)) {
    const entries = Object.entries(value).map(([key, inner]) => `${flowText(key)}: ${flowText(inner)}`);
    return entries.length === 0 ? '{}' : `{ ${entries.join(', ')} }`;
  }
  return JSON.stringify(value);
}

/** Whether YAML takes a text without quotes for itself, in collections too. */
function plain(text: string): boolean {
  if (text === '' || text.trim() !== text) return false;
  if (/^[-+]?[.\d]/.test(text) && !Number.isNaN(Number(text))) return false;
  if (/^(true|false|null|yes|no|on|off|y|n|~|\.inf|\.nan)$/i.test(text)) return false;
  // Names of poses in braces and variables are read as they are written.
  const bare = text.replace(/\$?\{[A-Za-z_]\w*\}/g, 'x');
  return !/^[-?:,[\]{}#&*!|>'"%@`]|[[\]{},]|: |:$| #/.test(bare);
}
