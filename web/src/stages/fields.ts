import type { Step } from '../protocol/types.ts';
import { h } from '../ui/dom.ts';
import type { FormHost } from './host.ts';
import {
  type EnumField,
  type Field,
  flowText,
  type Json,
  type NumberField,
  numberProblem,
  parseFlow,
  rangeText,
  valueAt,
} from './schema.ts';

/** The control of a simple field. Its element has the path, so that the focus can be found again after a redraw. */
export function control(host: FormHost, field: Field, path: Step[], id: string): HTMLElement {
  const value = valueAt(host.pipeline.value as Json, path);
  switch (field.kind) {
    case 'boolean':
      return choice(host, path, id, value, field.default, [
        { value: 'true', label: 'yes' },
        { value: 'false', label: 'no' },
      ]);
    case 'enum':
      return choice(host, path, id, value, field.default, optionsOf(field));
    case 'number':
      return numberInput(host, field, path, id, value);
    default:
      return textInput(host, field, path, id, value);
  }
}

function optionsOf(field: EnumField): { value: string; label: string; title: string }[] {
  return field.options.map(({ value, description }) => ({ value, label: value, title: description }));
}

function choice(
  host: FormHost,
  path: Step[],
  id: string,
  value: Json | undefined,
  byDefault: Json | undefined,
  options: { value: string; label: string; title?: string }[],
): HTMLElement {
  const usual = options.find((option) => option.value === String(byDefault))?.label;
  const select = h(
    'select',
    {
      id,
      'data-path': path.join('.'),
      onchange: () => {
        const chosen = select.value;
        if (chosen === '') host.unset(path);
        else host.set(path, chosen === 'true' ? true : chosen === 'false' ? false : chosen);
      },
    },
    h('option', { value: '' }, usual ? `${usual} (default)` : 'default'),
    ...options.map((option) => h('option', { value: option.value, title: option.title }, option.label)),
  );
  const text = value === undefined ? '' : String(value);
  if (text !== '' && !options.some((option) => option.value === text))
    select.append(h('option', { value: text }, text));
  select.value = text;
  return select;
}

function numberInput(
  host: FormHost,
  field: NumberField,
  path: Step[],
  id: string,
  value: Json | undefined,
): HTMLElement {
  const input = h('input', {
    id,
    type: 'text',
    inputmode: 'decimal',
    value: value === undefined ? '' : flowText(value),
    placeholder: field.default === undefined || field.default === null ? '' : String(field.default),
    title: rangeText(field),
    'data-path': path.join('.'),
    onchange: () => {
      const text = input.value.trim();
      if (text === '') return host.unset(path);
      // A variable of the pipeline may stand for a number.
      if (text.startsWith('${')) return host.set(path, text);
      const number = Number(text);
      input.setCustomValidity(numberProblem(field, number) ?? '');
      if (input.reportValidity()) host.set(path, number);
    },
    oninput: () => input.setCustomValidity(''),
  });
  return input;
}

function textInput(host: FormHost, field: Field, path: Step[], id: string, value: Json | undefined): HTMLElement {
  const example = field.examples[0];
  const input = h('input', {
    id,
    type: 'text',
    spellcheck: 'false',
    value: flowText(value),
    placeholder: example === undefined ? '' : flowText(example),
    'data-path': path.join('.'),
    onchange: () => {
      if (input.value.trim() === '') return host.unset(path);
      if (field.kind === 'text') return host.set(path, input.value);
      const parsed = parseFlow(input.value);
      if ('value' in parsed) return host.set(path, parsed.value);
      input.setCustomValidity(parsed.problem);
      input.reportValidity();
    },
    oninput: () => input.setCustomValidity(''),
  });
  return input;
}
