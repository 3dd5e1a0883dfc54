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
      const problem = numberProblem(field, number);
      say(problem);
      if (problem === null) host.set(path, number);
    },
    oninput: () => say(null),
  });
  const message = h('p', { class: 'problem field-problem', role: 'alert' });
  message.hidden = true;
  function say(text: string | null): void {
    message.hidden = text === null;
    message.textContent = text ?? '';
    input.setAttribute('aria-invalid', String(text !== null));
  }
  return h('span', { class: 'text-field' }, input, message);
}

function textInput(host: FormHost, field: Field, path: Step[], id: string, value: Json | undefined): HTMLElement {
  const example = field.examples[0];
  const problem = h('p', { class: 'problem field-problem', role: 'alert' });
  problem.hidden = true;
  const input = h('input', {
    id,
    type: 'text',
    spellcheck: 'false',
    autocomplete: 'off',
    value: flowText(value),
    placeholder: example === undefined ? '' : flowText(example),
    title: flowText(value),
    'data-path': path.join('.'),
    onchange: () => void take(),
    oninput: () => say(null),
  });

  function say(text: string | null): void {
    problem.hidden = text === null;
    problem.textContent = text ?? '';
    input.setAttribute('aria-invalid', String(text !== null));
  }

  /** Takes the text. What is wrong with it is said below it and keeps nobody in the field. */
  async function take(): Promise<void> {
    const text = input.value.trim();
    if (text === '') return host.unset(path);
    if (field.kind === 'text') return host.set(path, input.value);
    const parsed = await host.parse(text);
    if ('value' in parsed) host.set(path, parsed.value);
    else say(parsed.problem);
  }

  return h('span', { class: 'text-field' }, input, problem);
}
