import type { Diagnostic, Step } from '../protocol/types.ts';
import { button } from '../ui/controls.ts';
import { h, uniqueId } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { inline, prose, splitCommands } from '../ui/prose.ts';
import { control } from './fields.ts';
import type { FormHost } from './host.ts';
import {
  type Field,
  flowText,
  isObject,
  type Json,
  type ListField,
  type ObjectField,
  type StageField,
  typeOf,
  valueAt,
} from './schema.ts';

/** A field of any kind, with its name, help, value and faults. */
export function fieldElement(host: FormHost, field: Field, path: Step[]): HTMLElement {
  if (field.kind === 'stage') return stageElement(host, field, path);
  if (field.kind === 'object') return objectElement(host, field, path);
  if (field.kind === 'list') return listElement(host, field, path);
  const id = uniqueId('setting');
  const value = valueAt(host.pipeline.value as Json, path);
  const faults = faultsAt(host.pipeline.diagnostics, path);
  return h(
    'div',
    {
      class: `setting${value === undefined ? '' : ' set'}${faults.length > 0 ? ' faulty' : ''}${isWide(field) ? ' wide' : ''}`,
    },
    h(
      'div',
      { class: 'setting-line' },
      h('label', { for: id, class: 'setting-name' }, field.name),
      control(host, field, path, id),
      resetButton(host, path, field.name, value),
    ),
    ...faults,
    h('div', { class: 'help-text' }, ...prose(field.description), defaultText(field)),
  );
}

/** Texts and free values need more room than a number. */
function isWide(field: Field): boolean {
  return field.kind === 'text' || field.kind === 'value';
}

function stageElement(host: FormHost, field: StageField, path: Step[]): HTMLElement {
  const id = uniqueId('stage');
  const value = valueAt(host.pipeline.value as Json, path);
  const chosen = host.pipeline.choices.find((choice) => choice.slot === path.join('.'));
  const byDefault = typeOf(field.default) ?? typeOf(chosen?.value as Json | undefined);
  const isText = typeof value === 'string';
  const type = typeOf(value) ?? (isText ? null : byDefault);
  const known = field.types.find((one) => one.name === type);
  const select = h(
    'select',
    {
      id,
      'data-path': path.join('.'),
      onchange: () => {
        if (select.value === '') host.unset(path);
        else if (select.value === TEXT) host.set(path, '');
        else host.set(path, { type: select.value });
      },
    },
    h('option', { value: '' }, byDefault ? `${byDefault} (chosen)` : 'left out'),
    field.text ? h('option', { value: TEXT }, 'a file') : null,
    ...field.types.map((one) => h('option', { value: one.name }, one.name)),
  );
  select.value = isText ? TEXT : (typeOf(value) ?? '');
  const text = isText
    ? h('input', {
        type: 'text',
        value,
        'aria-label': `File of ${field.name}`,
        'data-path': `${path.join('.')}:text`,
        onchange: (event: Event) => host.set(path, (event.target as HTMLInputElement).value),
      })
    : null;
  const body = [
    ...faultsAt(host.pipeline.diagnostics, path),
    h('div', { class: 'help-text' }, ...prose(field.description)),
    h(
      'div',
      { class: 'setting-line' },
      h('label', { for: id, class: 'setting-name' }, 'type'),
      select,
      resetButton(host, path, field.name, value),
    ),
    text,
    chosen && value === undefined ? h('p', { class: 'chosen' }, `Chosen by the meshes: ${chosen.reason}`) : null,
    known ? h('div', { class: 'help-text' }, ...prose(known.description)) : null,
    ...(known ? known.fields().map((inner) => fieldElement(host, inner, [...path, inner.name])) : []),
  ];
  const state = isText ? value : (typeOf(value) ?? (byDefault ? `${byDefault}, chosen` : 'left out'));
  return folding(host, field.name, state, value !== undefined, path, body);
}

/** Stands for a text in the list of types; no type may have blanks. */
const TEXT = 'a file';

function objectElement(host: FormHost, field: ObjectField, path: Step[]): HTMLElement {
  const value = valueAt(host.pipeline.value as Json, path);
  const body = [
    ...faultsAt(host.pipeline.diagnostics, path),
    h('div', { class: 'help-text' }, ...prose(field.description)),
    ...field.fields().map((inner) => fieldElement(host, inner, [...path, inner.name])),
  ];
  const state = value === undefined ? 'as usual' : summary(value);
  return folding(host, field.name, state, value !== undefined, path, body);
}

function listElement(host: FormHost, field: ListField, path: Step[]): HTMLElement {
  const value = valueAt(host.pipeline.value as Json, path);
  const items = Array.isArray(value) ? value : [];
  const item = field.item();
  const added: Json = item.kind === 'stage' ? { type: item.types[0]?.name ?? '' } : {};
  const body = [
    ...faultsAt(host.pipeline.diagnostics, path),
    h('div', { class: 'help-text' }, ...prose(field.description)),
    ...items.map((_, i) =>
      h(
        'div',
        { class: 'list-item' },
        fieldElement(host, { ...item, name: `${i + 1}` }, [...path, i]),
        button({
          label: `Remove ${field.name} ${i + 1}`,
          icon: 'trash',
          bare: true,
          run: () => host.set(path, items.toSpliced(i, 1)),
        }),
      ),
    ),
    h(
      'div',
      { class: 'row' },
      button({
        label: 'Add',
        icon: 'plus',
        run: () => {
          const before = Array.isArray(value) ? value : Array.isArray(field.default) ? field.default : [];
          host.open.add([...path, before.length].join('.'));
          host.set(path, [...before, added]);
        },
      }),
      value === undefined ? null : button({ label: 'Leave out', icon: 'undo', run: () => host.unset(path) }),
    ),
  ];
  return folding(
    host,
    field.name,
    value === undefined ? 'as usual' : `${items.length}`,
    value !== undefined,
    path,
    body,
  );
}

/** A mapping in few words, e.g. `rest: horse.glb`. */
function summary(value: Json): string {
  if (!isObject(value)) return flowText(value);
  return Object.entries(value)
    .map(([key, inner]) => `${key}: ${isObject(inner) ? '…' : flowText(inner)}`)
    .join(', ');
}

function folding(
  host: FormHost,
  name: string,
  state: string,
  isSet: boolean,
  path: Step[],
  body: (Node | null)[],
): HTMLElement {
  const key = path.join('.');
  const open = host.open.has(key);
  const count = host.pipeline.diagnostics.filter((one) => one.level === 'error' && startsWith(one.path, path)).length;
  const head = h(
    'button',
    {
      type: 'button',
      class: 'fold',
      'aria-expanded': open,
      'data-path': `${key}:fold`,
      onclick: () => {
        if (!host.open.delete(key)) host.open.add(key);
        host.redraw();
      },
    },
    icon('chevron'),
    h('span', { class: 'fold-name' }, name),
    h('span', { class: 'fold-state' }, state),
    count > 0 ? h('span', { class: 'verdict bad' }, icon('warning'), String(count)) : null,
  );
  return h(
    'div',
    { class: `group${isSet ? ' set' : ''}${path.length === 1 ? ' top' : ''}` },
    head,
    open ? h('div', { class: 'group-body' }, ...body) : null,
  );
}

function resetButton(host: FormHost, path: Step[], name: string, value: Json | undefined): HTMLElement {
  const reset = button({
    label: `Take ${name} away, so that the default holds`,
    icon: 'undo',
    bare: true,
    run: () => host.unset(path),
  });
  reset.classList.add('reset');
  // The focus finds it again after the form was drawn anew.
  reset.dataset.path = `${path.join('.')}:reset`;
  // It keeps its place, so that nothing moves when a value is set.
  if (value === undefined) reset.disabled = true;
  return reset;
}

function defaultText(field: Field): HTMLElement | null {
  if (field.default === undefined || field.default === null) return null;
  const text = flowText(field.default);
  return text.length > 60 ? null : h('span', { class: 'default' }, `Default: ${text}`);
}

/** The faults of a value, or of something in it that has no field of its own. */
function faultsAt(diagnostics: readonly Diagnostic[], path: Step[]): HTMLElement[] {
  return diagnostics
    .filter(
      (one) =>
        one.path !== null &&
        one.path.length >= path.length &&
        one.path.length <= path.length + 1 &&
        startsWith(one.path, path),
    )
    .filter(
      (one) => one.path?.length === path.length || typeof one.path?.at(-1) === 'number' || one.path?.at(-1) === 'type',
    )
    .map((one) =>
      h(
        'p',
        { class: one.level === 'error' ? 'problem' : 'doubt', role: 'alert' },
        ...inline(one.message),
        ...inline(hintOf(one) ?? ''),
      ),
    );
}

/** Hints that name commands are for those who have no page. */
function hintOf({ hint }: Diagnostic): string | null {
  const page = hint && splitCommands(hint).page;
  return page ? ` – ${page}` : null;
}

function startsWith(path: Step[] | null, start: Step[]): boolean {
  return path !== null && start.every((step, i) => path[i] === step);
}
